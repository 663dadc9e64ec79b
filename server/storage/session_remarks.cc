#include "server/storage/session_remarks.h"

#include "absl/strings/str_join.h"
#include "server/storage/audit.h"
#include "server/storage/events.h"
#include "server/storage/machines.h"
#include "server/storage/refusal.h"
#include "server/storage/sessions.h"

namespace axiscal::storage {
namespace {

using records::SessionRemark;

std::string TextOf(SessionId id) { return absl::StrCat("session ", id.number()); }
std::string ResourceOf(SessionId id) { return absl::StrCat("sessions/", id.number()); }

// Only of what jobs may take can be said that they may not.
absl::StatusOr<SessionRecord> CompleteSession(Connection& connection, SessionId id) {
  ASSIGN_OR_RETURN(SessionRecord session, GetSession(connection, id));
  if (session.state != SessionState::kComplete)
    return FailedPrecondition(TextOf(id) + " is not complete", "SESSION_NOT_COMPLETE");
  return session;
}

absl::Status StoreRemark(Connection& connection, UtcTime now, SessionId id, const SessionRemark& remark,
                         const Caller& caller) {
  return connection.Run(
      "INSERT INTO session_remark (session_id, note, is_rejected, reason, etag, changed_by, changed_at_utc_us) "
      "VALUES (?1, ?2, ?3, ?4, 1, ?5, ?6) ON CONFLICT (session_id) DO UPDATE SET note = ?2, is_rejected = ?3, "
      "reason = ?4, etag = session_remark.etag + 1, changed_by = ?5, changed_at_utc_us = ?6",
      id, remark.note, remark.is_rejected, remark.reason, caller.principal, now);
}

absl::StatusOr<std::vector<CalibrationId>> StandingOn(Connection& connection, SessionId id) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT DISTINCT calibration_id FROM calibration_session WHERE "
                                                 "session_id = ?1 ORDER BY calibration_id",
                                                 id));
  std::vector<CalibrationId> calibrations;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return calibrations;
    calibrations.push_back(CalibrationId(row.Int(0)));
  }
}

}  // namespace

absl::StatusOr<std::optional<SessionRemark>> ReadRemark(Connection& connection, SessionId id) {
  SessionRemark remark;
  {
    ASSIGN_OR_RETURN(Statement row,
                     connection.Ask("SELECT note, is_rejected, reason, etag, changed_by, changed_at_utc_us FROM "
                                    "session_remark WHERE session_id = ?1",
                                    id));
    ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return std::nullopt;
    remark.note = row.Text(0);
    remark.is_rejected = row.Bool(1);
    remark.reason = row.Text(2);
    remark.etag = row.Int(3);
    remark.changed_by = row.Text(4);
    remark.changed_at = row.Time(5);
  }
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT label FROM session_label WHERE session_id = ?1 ORDER BY label", id));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return remark;
    remark.labels.push_back(row.Text(0));
  }
}

absl::StatusOr<std::vector<SessionId>> RejectedSessionsOf(Connection& connection, CalibrationId calibration) {
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT c.session_id FROM calibration_session AS c CROSS JOIN session_remark AS r ON "
                                  "r.session_id = c.session_id WHERE c.calibration_id = ?1 AND r.is_rejected = 1 "
                                  "ORDER BY c.position",
                                  calibration));
  std::vector<SessionId> rejected;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return rejected;
    rejected.push_back(SessionId(row.Int(0)));
  }
}

absl::StatusOr<SessionRecord> AnnotateSession(Connection& connection, UtcTime now, SessionId id,
                                              const std::string& note, const std::vector<std::string>& labels,
                                              int64_t expected_etag, const Caller& caller) {
  ASSIGN_OR_RETURN(const SessionRecord session, CompleteSession(connection, id));
  SessionRemark remark = session.remark.value_or(SessionRemark{});
  if (expected_etag != 0) RETURN_IF_ERROR(CheckEtag("the remark on " + TextOf(id), expected_etag, remark.etag));
  const std::string was = absl::StrCat("[", absl::StrJoin(remark.labels, " "), "] ", remark.note);
  remark.note = note;
  RETURN_IF_ERROR(StoreRemark(connection, now, id, remark, caller));
  RETURN_IF_ERROR(connection.Run("DELETE FROM session_label WHERE session_id = ?1", id));
  for (const std::string& label : labels)
    RETURN_IF_ERROR(connection.Run("INSERT INTO session_label (session_id, label) VALUES (?1, ?2)", id, label));
  RETURN_IF_ERROR(AuditChange(connection, now, caller, "session.annotate", ResourceOf(id), was,
                              absl::StrCat("[", absl::StrJoin(labels, " "), "] ", note)));
  return GetSession(connection, id);
}

absl::StatusOr<RejectedSession> RejectSession(Connection& connection, UtcTime now, SessionId id, bool is_rejected,
                                              const std::string& reason, const Caller& caller) {
  ASSIGN_OR_RETURN(const SessionRecord session, CompleteSession(connection, id));
  RejectedSession rejected;
  ASSIGN_OR_RETURN(rejected.calibrations, StandingOn(connection, id));
  SessionRemark remark = session.remark.value_or(SessionRemark{});
  const bool was_rejected = remark.is_rejected;
  if (was_rejected != is_rejected) {
    remark.is_rejected = is_rejected;
    remark.reason = reason;
    RETURN_IF_ERROR(StoreRemark(connection, now, id, remark, caller));
    ASSIGN_OR_RETURN(const int64_t machine_key, MachineKey(connection, session.machine));
    RETURN_IF_ERROR(NoteChange(connection, machine_key));
    Caller with_reason = caller;
    with_reason.reason = reason;
    RETURN_IF_ERROR(AuditChange(connection, now, with_reason, "session.reject", ResourceOf(id),
                                was_rejected ? "rejected" : "counts", is_rejected ? "rejected" : "counts"));
  }
  ASSIGN_OR_RETURN(rejected.session, GetSession(connection, id));
  return rejected;
}

}  // namespace axiscal::storage
