#include "server/storage/calibrations.h"

#include "absl/strings/match.h"
#include "server/storage/access.h"
#include "server/storage/audit.h"
#include "server/storage/calibration_checksum.h"
#include "server/storage/estimates.h"
#include "server/storage/events.h"
#include "server/storage/machines.h"
#include "server/storage/page_token.h"
#include "server/storage/refusal.h"
#include "server/storage/session_remarks.h"

namespace axiscal::storage {
namespace {

constexpr char kOfSession[] =
    "SELECT calibration_id FROM calibration_session INDEXED BY calibration_of_session WHERE session_id = ?1 AND "
    "calibration_id < ?2 AND calibration_id > ?3 ORDER BY calibration_id DESC LIMIT ?4";

// The three long texts come after these, with what else only a whole calibration needs: lists leave them out.
constexpr char kColumns[] =
    "SELECT c.id, c.version, c.state, c.etag, c.job_id, m.name, c.machine_revision, c.measured_at_utc_us, "
    "c.engine_version, c.rank, "
    "c.condition, c.chi2_per_dof, c.rms_before_um, c.rms_after_um, c.created_by, c.created_at_utc_us, c.approved_by, "
    "c.approved_at_utc_us, c.retired_at_utc_us, c.machine_id";
constexpr char kFrom[] = " FROM calibration AS c JOIN machine AS m ON m.id = c.machine_id ";

std::string NameOf(CalibrationState state) {
  switch (state) {
    case CalibrationState::kCandidate:
      return "candidate";
    case CalibrationState::kApproved:
      return "approved";
    case CalibrationState::kRetired:
      return "retired";
  }
  return "";
}

// How the audit names a calibration, and what is done to it.
std::string ResourceOf(CalibrationId id) { return absl::StrCat("calibrations/", id.number()); }
constexpr char kApprove[] = "calibration.approve", kRetire[] = "calibration.retire";

std::string Place(CalibrationId id) { return absl::StrCat("calibration ", id.number()); }

CalibrationRecord ReadCalibration(const Statement& row) {
  CalibrationRecord record;
  record.id = CalibrationId(row.Int(0));
  record.version = row.Int(1);
  record.state = row.As<CalibrationState>(2);
  record.etag = row.Int(3);
  if (!row.IsNull(4)) record.job = JobId(row.Int(4));
  record.content.machine = MachineId(row.Text(5));
  record.content.machine_revision = row.Int(6);
  record.content.measured_at = row.Time(7);
  record.content.engine_version = row.Text(8);
  record.content.rank = static_cast<int>(row.Int(9));
  record.content.condition = row.OptionalReal(10);
  record.content.chi2_per_dof = row.OptionalReal(11);
  record.content.rms_before_um = row.OptionalReal(12);
  record.content.rms_after_um = row.OptionalReal(13);
  record.content.created_by = row.Text(14);
  record.created_at = row.Time(15);
  record.approved_by = row.Text(16);
  record.approved_at = row.OptionalTime(17);
  record.retired_at = row.OptionalTime(18);
  return record;
}

absl::Status ReadLists(Connection& connection, int64_t machine_key, CalibrationRecord& record) {
  {
    ASSIGN_OR_RETURN(
        Statement row,
        connection.Ask("SELECT session_id FROM calibration_session WHERE calibration_id = ?1 ORDER BY position",
                       record.id));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      record.content.sessions.push_back(SessionId(row.Int(0)));
    }
  }
  ASSIGN_OR_RETURN(record.rejected_sessions, RejectedSessionsOf(connection, record.id));
  ASSIGN_OR_RETURN(record.content.estimates,
                   ReadEstimates(connection, machine_key, record.content.measured_at, record.id));
  return absl::OkStatus();
}

// A whole calibration, with what tells whether it is the one that was stored.
struct Sealed {
  CalibrationRecord record;
  std::string stored_checksum, checksum;

  bool is_intact() const { return stored_checksum == checksum; }
};

absl::StatusOr<Sealed> ReadOne(Connection& connection, Statement row) {
  Sealed sealed;
  CalibrationRecord& record = sealed.record;
  record = ReadCalibration(row);
  record.content.model_json = row.Text(20);
  record.content.options_json = row.Text(21);
  record.content.report_json = row.Text(22);
  sealed.stored_checksum = row.Text(23);
  RETURN_IF_ERROR(ReadLists(connection, row.Int(19), record));
  sealed.checksum = CalibrationChecksum(record, row.Text(24));
  return sealed;
}

std::string SelectOne(const std::string& where) {
  return std::string(kColumns) + ", c.model_json, c.options_json, c.report_json, c.checksum, r.description_json" +
         kFrom + "LEFT JOIN machine_revision AS r ON r.machine_id = c.machine_id AND r.revision = c.machine_revision " +
         where;
}

absl::StatusOr<Sealed> Find(Connection& connection, CalibrationId id) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask(SelectOne("WHERE c.id = ?1"), id));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NotFound("calibration", "CALIBRATION", std::to_string(id.number()));
  return ReadOne(connection, std::move(row));
}

absl::StatusOr<CalibrationRecord> RequireIntact(absl::StatusOr<Sealed> read) {
  if (!read.ok()) return read.status();
  if (read->is_intact()) return std::move(read->record);
  const CalibrationRecord& record = read->record;
  const std::string id = std::to_string(record.id.number());
  return base::Error(
      absl::StatusCode::kDataLoss,
      absl::StrCat(Place(record.id), " of machine ", record.content.machine.text(), " (version ", record.version,
                   ") is damaged: it, its estimates or the machine's description of revision ",
                   record.content.machine_revision,
                   " are not what was stored; restore a backup, or identify again from its sessions"),
      {"CALIBRATION_DAMAGED", {{"calibration", id}, {"machine", record.content.machine.text()}}});
}

// Runs `change`, which changes the row's state. What was intact is sealed again; what was not stays damaged.
template <typename Change>
absl::Status ChangeState(Connection& connection, CalibrationId id, const Change& change) {
  ASSIGN_OR_RETURN(const Sealed before, Find(connection, id));
  RETURN_IF_ERROR(change());
  return before.is_intact() ? SealCalibration(connection, id) : absl::OkStatus();
}

absl::Status Retire(Connection& connection, UtcTime now, CalibrationId id) {
  return ChangeState(connection, id, [&] {
    return connection.Run("UPDATE calibration SET state = 3, etag = etag + 1, retired_at_utc_us = ?2 WHERE id = ?1", id,
                          now);
  });
}

absl::StatusOr<std::optional<CalibrationId>> FindApproved(Connection& connection, int64_t machine_key) {
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT id FROM calibration WHERE machine_id = ?1 AND state = 2", machine_key));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return std::nullopt;
  return CalibrationId(row.Int(0));
}

absl::Status InsertSessions(Connection& connection, int64_t machine_key, CalibrationId id,
                            const std::vector<SessionId>& sessions) {
  for (size_t i = 0; i < sessions.size(); ++i) {
    {
      ASSIGN_OR_RETURN(Statement row,
                       connection.Ask("SELECT machine_id, state FROM session WHERE id = ?1", sessions[i]));
      ASSIGN_OR_RETURN(const bool found, row.Step());
      if (!found) return NotFound("session", "SESSION", std::to_string(sessions[i].number()));
      const std::string place = absl::StrCat("session ", sessions[i].number());
      if (row.Int(0) != machine_key) return InvalidArgument(place + " is of another machine", "CALIBRATION_INVALID");
      if (row.As<SessionState>(1) != SessionState::kComplete)
        return FailedPrecondition(place + " is not complete", "SESSION_NOT_COMPLETE");
    }
    RETURN_IF_ERROR(
        connection.Run("INSERT INTO calibration_session (calibration_id, position, session_id) VALUES (?1, ?2, ?3)", id,
                       static_cast<int64_t>(i), sessions[i]));
  }
  return absl::OkStatus();
}

absl::StatusOr<int64_t> NextVersion(Connection& connection, int64_t machine_key) {
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask("SELECT coalesce(max(version), 0) + 1 FROM calibration WHERE machine_id = ?1", machine_key));
  RETURN_IF_ERROR(row.Step().status());
  return row.Int(0);
}

}  // namespace

absl::Status SealCalibration(Connection& connection, CalibrationId id) {
  ASSIGN_OR_RETURN(const Sealed sealed, Find(connection, id));
  return connection.Run("UPDATE calibration SET checksum = ?2 WHERE id = ?1", id, sealed.checksum);
}

absl::StatusOr<CalibrationRecord> CreateCalibration(Connection& connection, UtcTime now,
                                                    const NewCalibration& calibration, std::optional<JobId> job) {
  RETURN_IF_ERROR(CheckEstimates(calibration.estimates));
  if (base::ToUtcUs(calibration.measured_at) < 0)
    return InvalidArgument("measured_at lies before 1970", "CALIBRATION_INVALID");
  RETURN_IF_ERROR(GetMachineRevision(connection, calibration.machine, calibration.machine_revision).status());
  ASSIGN_OR_RETURN(const int64_t machine_key, LiveMachineKey(connection, calibration.machine));
  ASSIGN_OR_RETURN(const int64_t version, NextVersion(connection, machine_key));
  ASSIGN_OR_RETURN(
      const int64_t number,
      connection.Insert("INSERT INTO calibration (machine_id, version, machine_revision, state, etag, job_id, "
                        "measured_at_utc_us, model_json, options_json, "
                        "report_json, engine_version, rank, condition, chi2_per_dof, rms_before_um, rms_after_um, "
                        "created_by, created_at_utc_us) "
                        "VALUES (?1, ?2, ?3, 1, 1, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16)",
                        machine_key, version, calibration.machine_revision, job, calibration.measured_at,
                        calibration.model_json, calibration.options_json, calibration.report_json,
                        calibration.engine_version, calibration.rank, calibration.condition, calibration.chi2_per_dof,
                        calibration.rms_before_um, calibration.rms_after_um, calibration.created_by, now));
  const CalibrationId id(number);
  RETURN_IF_ERROR(InsertSessions(connection, machine_key, id, calibration.sessions));
  RETURN_IF_ERROR(InsertEstimates(connection, machine_key, calibration.measured_at, id, calibration.estimates));
  RETURN_IF_ERROR(SealCalibration(connection, id));
  RETURN_IF_ERROR(NoteChange(connection, machine_key));
  const Caller caller = {calibration.created_by, ""};
  RETURN_IF_ERROR(AuditChange(connection, now, caller, "calibration.create", absl::StrCat("calibrations/", id.number()),
                              "", "candidate"));
  return GetCalibration(connection, id);
}

absl::StatusOr<CalibrationRecord> GetCalibration(Connection& connection, CalibrationId id) {
  return RequireIntact(Find(connection, id));
}

absl::StatusOr<CalibrationRecord> GetApprovedCalibration(Connection& connection, const MachineId& machine) {
  ASSIGN_OR_RETURN(const int64_t machine_key, MachineKey(connection, machine));
  ASSIGN_OR_RETURN(Statement row, connection.Ask(SelectOne("WHERE c.machine_id = ?1 AND c.state = 2"), machine_key));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NotFound("calibration", "CALIBRATION", "approved for machine " + machine.text());
  return RequireIntact(ReadOne(connection, std::move(row)));
}

absl::StatusOr<CalibrationRecord> GetApprovedByPerson(Connection& connection, const MachineId& machine) {
  ASSIGN_OR_RETURN(const int64_t machine_key, MachineKey(connection, machine));
  std::optional<CalibrationId> id;
  {
    ASSIGN_OR_RETURN(
        Statement row,
        connection.Ask("SELECT c.id FROM calibration AS c INDEXED BY calibration_ever_approved WHERE c.machine_id = ?1 "
                       "AND "
                       "c.approved_at_utc_us IS NOT NULL AND NOT EXISTS (SELECT 1 FROM routine_run AS u INDEXED BY "
                       "run_approved WHERE u.calibration_id = c.id AND u.state = 5) "
                       "ORDER BY c.approved_at_utc_us DESC LIMIT 1",
                       machine_key));
    ASSIGN_OR_RETURN(const bool found, row.Step());
    if (found) id = CalibrationId(row.Int(0));
  }
  if (!id) return NotFound("calibration", "CALIBRATION", "approved by a person for machine " + machine.text());
  return GetCalibration(connection, *id);
}

absl::StatusOr<std::optional<CalibrationId>> GetFormerOf(Connection& connection, CalibrationId id) {
  int64_t machine_key = 0;
  std::optional<UtcTime> approved_at;
  {
    ASSIGN_OR_RETURN(Statement row,
                     connection.Ask("SELECT machine_id, approved_at_utc_us FROM calibration WHERE id = ?1", id));
    ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return NotFound("calibration", "CALIBRATION", std::to_string(id.number()));
    machine_key = row.Int(0);
    approved_at = row.OptionalTime(1);
  }
  if (!approved_at) return FindApproved(connection, machine_key);
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT id FROM calibration INDEXED BY calibration_ever_approved WHERE machine_id = "
                                  "?1 AND approved_at_utc_us < ?2 ORDER BY approved_at_utc_us DESC LIMIT 1",
                                  machine_key, approved_at));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return std::nullopt;
  return CalibrationId(row.Int(0));
}

absl::StatusOr<Page<CalibrationRecord>> ListCalibrations(Connection& connection, const CalibrationFilter& filter,
                                                         const PageRequest& request, const Visible& visible) {
  const int state = filter.state.has_value() ? static_cast<int>(*filter.state) : 0;
  const std::string machine = filter.machine.has_value() ? filter.machine->text() : "";
  std::string list = absl::StrCat("calibrations|", machine, "|", state);
  const bool is_narrow = !filter.measured.is_all() || filter.session.has_value();
  if (is_narrow) {
    absl::StrAppend(&list, "|", TokenOf(filter.measured), "|", filter.session ? filter.session->number() : 0);
  }
  ASSIGN_OR_RETURN(const PageStart start, StartPageById(request, list));
  std::optional<int64_t> machine_key;
  std::string where = "WHERE c.id < ?1";
  if (filter.machine.has_value()) {
    ASSIGN_OR_RETURN(machine_key, MachineKey(connection, *filter.machine));
    where += " AND c.machine_id = ?2";
  }
  if (filter.state.has_value()) where += " AND c.state = ?3";
  LookedAt looked;
  if (is_narrow) {
    Narrowing narrowing;
    narrowing.time = "measured_at_utc_us";
    narrowing.span = filter.measured;
    if (filter.session.has_value()) {
      ASSIGN_OR_RETURN(narrowing.linked, NewestIds(connection, kOfSession, std::vector<SessionId>{*filter.session},
                                                   start.before_id, kMostLookedAt, 0));
    }
    ASSIGN_OR_RETURN(
        looked, LookAtNarrowest(connection, "calibration", machine_key, visible, state, start.before_id, narrowing));
    where = HeldTo("c", looked, machine_key.has_value(), state, "+c.measured_at_utc_us", filter.measured);
    if (filter.session.has_value())
      where +=
          " AND EXISTS (SELECT 1 FROM calibration_session AS s WHERE s.session_id = ?9 AND s.calibration_id = c.id)";
  } else if (!visible.everything && !filter.machine.has_value()) {
    ASSIGN_OR_RETURN(looked.ids, NewestOfMachines(connection, "calibration", visible.scopes, state, start.before_id,
                                                  start.row_limit()));
    where += " AND c.id IN (SELECT value FROM json_each(?5))";
  }
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask(std::string(kColumns) + kFrom + where + " ORDER BY c.id DESC LIMIT ?4",
                                  start.before_id, machine_key, state, start.row_limit(), looked.ids,
                                  filter.measured.from, filter.measured.to, looked.machines, filter.session));
  Page<CalibrationRecord> page;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) break;
    page.rows.push_back(ReadCalibration(row));
    RETURN_IF_ERROR(ReadLists(connection, row.Int(19), page.rows.back()));
  }
  EndPage(
      start, [](const CalibrationRecord& record) { return std::to_string(record.id.number()); },
      [](const CalibrationRecord& record) {
        size_t bytes = record.content.sessions.size() * 8;
        for (const Estimate& estimate : record.content.estimates) bytes += estimate.symbol.size() + 40;
        return bytes;
      },
      page);
  GoOnBelow(start, looked.last, page);
  return page;
}

namespace {
// Of a calibration that is in use already: who approves it once more changes nothing, and what he says of it is kept.
// The same call again, whose answer was lost, says nothing new.
absl::Status AuditAnotherReason(Connection& connection, UtcTime now, CalibrationId id, const Caller& caller) {
  if (caller.reason.empty()) return absl::OkStatus();
  AuditFilter of_it;
  of_it.resource = ResourceOf(id);
  ASSIGN_OR_RETURN(const Page<AuditEntry> last, ListAudit(connection, of_it, {1, ""}));
  const bool is_said = !last.rows.empty() && last.rows[0].principal == caller.principal &&
                       ReasonIn(last.rows[0].detail) == caller.reason;
  if (is_said) return absl::OkStatus();
  return AuditChange(connection, now, caller, kApprove, of_it.resource, "approved", "approved");
}
}  // namespace

absl::StatusOr<CalibrationRecord> ApproveCalibration(Connection& connection, UtcTime now, CalibrationId id,
                                                     int64_t expected_etag, std::optional<CalibrationId> in_use,
                                                     const Caller& caller) {
  ASSIGN_OR_RETURN(const CalibrationRecord present, GetCalibration(connection, id));
  if (present.state == CalibrationState::kApproved) {
    RETURN_IF_ERROR(AuditAnotherReason(connection, now, id, caller));
    return present;
  }
  RETURN_IF_ERROR(CheckEtag(Place(id), expected_etag, present.etag));
  if (!present.rejected_sessions.empty()) {
    const std::string session = std::to_string(present.rejected_sessions[0].number());
    return base::Error(absl::StatusCode::kFailedPrecondition,
                       absl::StrCat(Place(id), " stands on session ", session,
                                    ", which was rejected: identify again without it, or say that it counts"),
                       {"SESSION_REJECTED", {{"session", session}}});
  }
  ASSIGN_OR_RETURN(const int64_t machine_key, LiveMachineKey(connection, present.content.machine));
  ASSIGN_OR_RETURN(const std::optional<CalibrationId> former, FindApproved(connection, machine_key));
  if (in_use.has_value() && in_use != former) {
    return base::Error(absl::StatusCode::kAborted,
                       absl::StrCat(Place(id), " was judged against ", Place(*in_use), "; now ",
                                    former ? Place(*former) : "none", " is in use"),
                       {"ETAG_MISMATCH", {{"calibration", std::to_string(id.number())}}});
  }
  if (former.has_value()) RETURN_IF_ERROR(Retire(connection, now, *former));
  RETURN_IF_ERROR(ChangeState(connection, id, [&] {
    return connection.Run(
        "UPDATE calibration SET state = 2, etag = etag + 1, approved_by = ?2, approved_at_utc_us = ?3, "
        "retired_at_utc_us = NULL WHERE id = ?1",
        id, caller.principal, now);
  }));
  const bool was_rejected = present.state == CalibrationState::kRetired && !present.approved_at;
  RETURN_IF_ERROR(NoteChange(connection, machine_key));
  if (was_rejected) RETURN_IF_ERROR(NoteRejection(connection, machine_key, present.content.measured_at, id, false));
  RETURN_IF_ERROR(AuditChange(
      connection, now, caller, kApprove, ResourceOf(id), NameOf(present.state),
      absl::StrCat("approved", former ? absl::StrCat("; calibrations/", former->number(), " retired") : "")));
  return GetCalibration(connection, id);
}

absl::StatusOr<CalibrationRecord> RetireCalibration(Connection& connection, UtcTime now, CalibrationId id,
                                                    int64_t expected_etag, const Caller& caller) {
  // A damaged one can be retired too.
  ASSIGN_OR_RETURN(const Sealed present, Find(connection, id));
  if (present.record.state == CalibrationState::kRetired) return present.record;
  RETURN_IF_ERROR(CheckEtag(Place(id), expected_etag, present.record.etag));
  RETURN_IF_ERROR(Retire(connection, now, id));
  ASSIGN_OR_RETURN(const int64_t machine_key, MachineKey(connection, present.record.content.machine));
  RETURN_IF_ERROR(NoteChange(connection, machine_key));
  if (!present.record.approved_at)
    RETURN_IF_ERROR(NoteRejection(connection, machine_key, present.record.content.measured_at, id, true));
  RETURN_IF_ERROR(
      AuditChange(connection, now, caller, kRetire, ResourceOf(id), NameOf(present.record.state), "retired"));
  ASSIGN_OR_RETURN(Sealed retired, Find(connection, id));
  return std::move(retired.record);
}

absl::StatusOr<std::vector<records::Decision>> ListDecisions(Connection& connection, CalibrationId id, int limit) {
  AuditFilter decided;
  decided.resource = ResourceOf(id);
  decided.actions = {kApprove, kRetire};
  ASSIGN_OR_RETURN(const Page<AuditEntry> page, ListAudit(connection, decided, {limit, ""}));
  std::vector<records::Decision> decisions;
  for (const AuditEntry& entry : page.rows)
    if (entry.resource == decided.resource)  // else what it said is not known
      decisions.push_back({entry.at, entry.principal,
                           entry.action == kApprove ? CalibrationState::kApproved : CalibrationState::kRetired,
                           ReasonIn(entry.detail)});
  return decisions;
}

}  // namespace axiscal::storage
