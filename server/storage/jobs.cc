#include "server/storage/jobs.h"

#include "server/storage/access.h"
#include "server/storage/audit.h"
#include "server/storage/machines.h"
#include "server/storage/page_token.h"
#include "server/storage/refusal.h"
#include "server/storage/request.h"

namespace axiscal::storage {
namespace {

// Without the report, which may be large: NULL stands in its place.
constexpr char kReport[] = "j.result", kNoReport[] = "NULL";

std::string Select(const char* report) {
  return absl::StrCat(
      "SELECT j.id, j.kind, m.name, j.params, j.input_hash, j.priority, j.state, j.attempt, j.max_attempts, "
      "j.lease_token, "
      "j.cancel_requested, j.progress_stage, j.progress_fraction, j.progress_detail, ",
      report,
      ", j.error_code, "
      "j.error_reason, "
      "j.error_message, j.created_by, j.created_at_utc_us, j.started_at_utc_us, j.ended_at_utc_us, "
      "j.version, "
      "(SELECT c.id FROM calibration AS c WHERE c.job_id = j.id), j.result_sha256, j.deadline_at_utc_us, "
      "coalesce(j.request_id, ''), j.trace FROM job AS j "
      "LEFT JOIN machine AS m "
      "ON m.id = "
      "j.machine_id ");
}

JobRecord ReadJob(const Statement& row) {
  JobRecord job;
  job.id = JobId(row.Int(0));
  job.kind = row.Text(1);
  if (!row.IsNull(2)) job.machine = MachineId(row.Text(2));
  job.params = row.Text(3);
  job.input_hash = row.Text(4);
  job.priority = static_cast<int>(row.Int(5));
  job.state = row.As<JobState>(6);
  job.attempt = static_cast<int>(row.Int(7));
  job.max_attempts = static_cast<int>(row.Int(8));
  job.running_attempt = job.state == JobState::kRunning ? row.Int(9) : 0;
  job.cancel_requested = row.Bool(10);
  job.progress = {row.Text(11), row.Real(12), row.Text(13)};
  job.result = row.Text(14);
  if (!row.IsNull(15)) job.error = JobError{row.As<absl::StatusCode>(15), row.Text(16), row.Text(17)};
  job.created_by = row.Text(18);
  job.created_at = row.Time(19);
  job.started_at = row.OptionalTime(20);
  job.ended_at = row.OptionalTime(21);
  job.version = row.Int(22);
  if (!row.IsNull(23)) job.calibration = CalibrationId(row.Int(23));
  job.deadline = row.OptionalTime(25);
  job.request_id = row.Text(26);
  job.trace = row.Text(27);
  return job;
}

absl::Status ReadPrograms(Connection& connection, JobRecord& job) {
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT program_id FROM job_program WHERE job_id = ?1 ORDER BY position", job.id));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return absl::OkStatus();
    job.programs.push_back(ProgramId(row.Int(0)));
  }
}

// Of a NewJob or of the record made of it.
template <typename Job>
std::string HashBody(const Job& job) {
  BodyHash hash;
  hash.Add(job.kind).Add(job.machine.has_value() ? job.machine->text() : "").Add(job.params).Add(job.input_hash);
  hash.Add(job.priority).Add(job.max_attempts);
  if (job.deadline) hash.Add(base::ToUtcUs(*job.deadline));
  return hash.Hex();
}

absl::StatusOr<int64_t> Count(Connection& connection, const std::string& sql, const auto& whose) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask(sql, whose));
  RETURN_IF_ERROR(row.Step().status());
  return row.Int(0);
}

absl::Status QueueFull(int64_t jobs, const std::string& whose, int most) {
  return base::Error(
      absl::StatusCode::kResourceExhausted,
      absl::StrCat(jobs, " jobs", whose, " wait", whose.empty() ? "" : " or run", ", at most ", most, " may"),
      {"QUEUE_FULL", {{"max_queued", std::to_string(most)}}});
}

absl::Status CheckRoom(Connection& connection, const JobRoom& room, const std::string& principal,
                       const std::optional<MachineId>& machine) {
  // No more wait than were made since the oldest of them, which costs two seeks; to count a million takes long.
  ASSIGN_OR_RETURN(const int64_t at_most, Count(connection,
                                                "SELECT coalesce((SELECT max(id) FROM job) - (SELECT min(id) FROM job "
                                                "WHERE state = ?1) + 1, 0)",
                                                1));
  if (at_most >= room.max_waiting) {
    ASSIGN_OR_RETURN(const int64_t waiting, Count(connection, "SELECT count(*) FROM job WHERE state = ?1", 1));
    if (waiting >= room.max_waiting) return QueueFull(waiting, "", room.max_waiting);
  }
  if (room.max_of_principal > 0 && records::IsAccessName(principal)) {
    ASSIGN_OR_RETURN(
        const int64_t of_principal,
        Count(connection, "SELECT count(*) FROM job WHERE created_by = ?1 AND state IN (1, 2)", principal));
    if (of_principal >= room.max_of_principal)
      return QueueFull(of_principal, " of " + principal, room.max_of_principal);
  }
  if (room.max_of_machine > 0 && machine.has_value()) {
    ASSIGN_OR_RETURN(const int64_t key, MachineKey(connection, *machine));
    ASSIGN_OR_RETURN(const int64_t of_machine,
                     Count(connection, "SELECT count(*) FROM job WHERE machine_id = ?1 AND state IN (1, 2)", key));
    if (of_machine >= room.max_of_machine)
      return QueueFull(of_machine, " of machine " + machine->text(), room.max_of_machine);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::optional<int64_t>> OptionalMachineKey(Connection& connection,
                                                          const std::optional<MachineId>& machine) {
  if (!machine.has_value()) return std::nullopt;
  ASSIGN_OR_RETURN(const int64_t key, MachineKey(connection, *machine));
  return key;
}

}  // namespace

absl::StatusOr<JobRecord> CreateJob(Connection& connection, const Moment& now, const NewJob& job, const JobRoom& room) {
  if (job.max_attempts < 1) {
    return InvalidArgument(absl::StrCat("max_attempts = ", job.max_attempts, ", must be > 0"), "JOB_INVALID");
  }
  const std::string body_sha256 = HashBody(job);
  ASSIGN_OR_RETURN(const std::optional<int64_t> same, FindRequest(connection, "job", job.caller, body_sha256));
  if (same.has_value()) return GetJob(connection, JobId(*same));
  if (job.deadline && *job.deadline <= now.utc) return InvalidArgument("the deadline is over", "JOB_INVALID");
  RETURN_IF_ERROR(CheckRoom(connection, room, job.caller.principal, job.machine));
  ASSIGN_OR_RETURN(const std::optional<int64_t> machine_key, OptionalMachineKey(connection, job.machine));
  ASSIGN_OR_RETURN(
      const int64_t number,
      connection.Insert(
          "INSERT INTO job (kind, machine_id, params, input_hash, priority, state, attempt, max_attempts, "
          "lease_token, cancel_requested, "
          "progress_stage, progress_fraction, progress_detail, created_by, request_id, body_sha256, "
          "created_at_utc_us, waits_from_up_us, wait_us, "
          "version, deadline_at_utc_us, trace) "
          "VALUES (?1, ?2, ?3, ?4, ?5, 1, 0, ?6, 0, 0, '', 0.0, '', ?7, ?8, ?9, ?10, ?11, 0, 1, ?12, ?13)",
          job.kind, machine_key, Blob{job.params}, job.input_hash, job.priority, job.max_attempts, job.caller.principal,
          RequestId(job.caller), body_sha256, now.utc, now.up_us, job.deadline, job.trace));
  const JobId id(number);
  if (job.program) RETURN_IF_ERROR(LinkProgram(connection, id, *job.program));
  return GetJob(connection, id);
}

absl::Status LinkProgram(Connection& connection, JobId job, ProgramId program) {
  return connection.Run(
      "INSERT INTO program_machine (machine_id, program_id) "
      "SELECT j.machine_id, coalesce(p.same_as, p.id) FROM job AS j CROSS JOIN program AS p ON p.id = ?2 "
      "WHERE j.id = ?1 AND j.machine_id IS NOT NULL ON CONFLICT DO NOTHING",
      job, program);
}

std::string JobResultChecksum(JobId id, const std::string& result) {
  BodyHash hash;
  return hash.Add("job result 1").Add(id.number()).Add(result).Hex();
}

absl::StatusOr<JobRecord> GetJob(Connection& connection, JobId id) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask(Select(kReport) + "WHERE j.id = ?1", id));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NotFound("job", "JOB", std::to_string(id.number()));
  JobRecord job = ReadJob(row);
  if (job.state == JobState::kSucceeded && row.Text(24) != JobResultChecksum(id, job.result)) {
    const std::string number = std::to_string(id.number());
    return base::Error(absl::StatusCode::kDataLoss,
                       "job " + number +
                           " is damaged: its result is not what was stored; restore a backup, or create the job again "
                           "under another request id",
                       {"JOB_DAMAGED", {{"job", number}}});
  }
  // A job makes them with its success, or none. Whoever claims one asks for them with each claim.
  if (job.state == JobState::kSucceeded) RETURN_IF_ERROR(ReadPrograms(connection, job));
  return job;
}

absl::Status CheckJobBody(Connection& connection, const JobRecord& job) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT body_sha256 FROM job WHERE id = ?1", job.id));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (found && row.Text(0) == HashBody(job)) return absl::OkStatus();
  const std::string id = std::to_string(job.id.number());
  return base::Error(absl::StatusCode::kDataLoss,
                     "job " + id + " is damaged: what it is to do is not what was stored; create it again",
                     {"JOB_DAMAGED", {{"job", id}}});
}

absl::StatusOr<Page<JobRecord>> ListJobs(Connection& connection, const JobFilter& filter, const PageRequest& request,
                                         const Visible& visible) {
  const int state = filter.state.has_value() ? static_cast<int>(*filter.state) : 0;
  const std::string machine = filter.machine.has_value() ? filter.machine->text() : "";
  std::string list = absl::StrCat("jobs|", machine, "|", state, "|", filter.input_hash);
  const bool is_narrow = !filter.created.is_all() || !filter.kind.empty();
  if (is_narrow) absl::StrAppend(&list, "|", TokenOf(filter.created), "|", filter.kind);
  ASSIGN_OR_RETURN(const PageStart start, StartPageById(request, list));
  ASSIGN_OR_RETURN(const std::optional<int64_t> machine_key, OptionalMachineKey(connection, filter.machine));
  std::string where = "WHERE j.id < ?1";
  if (filter.machine.has_value()) where += " AND j.machine_id = ?2";
  if (filter.state.has_value()) where += " AND j.state = ?3";
  if (!filter.input_hash.empty()) where += " AND j.input_hash = ?10 AND j.input_hash <> ''";
  LookedAt looked;
  if (is_narrow) {
    Narrowing narrowing;
    if (!filter.kind.empty()) narrowing.texts.push_back({"kind", filter.kind});
    narrowing.time = "created_at_utc_us";
    narrowing.span = filter.created;
    ASSIGN_OR_RETURN(looked,
                     LookAtNarrowest(connection, "job", machine_key, visible, state, start.before_id, narrowing));
    where = HeldTo("j", looked, machine_key.has_value(), state, "+j.created_at_utc_us", filter.created);
    if (!filter.kind.empty()) where += " AND +j.kind = ?9";
    if (!filter.input_hash.empty()) where += " AND +j.input_hash = ?10 AND +j.input_hash <> ''";
  } else if (!visible.everything && !filter.machine.has_value()) {
    ASSIGN_OR_RETURN(looked.ids,
                     NewestOfMachines(connection, "job", visible.scopes, state, start.before_id, start.row_limit()));
    where += " AND j.id IN (SELECT value FROM json_each(?5))";
  }
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask(Select(kNoReport) + where + " ORDER BY j.id DESC LIMIT ?4", start.before_id,
                                  machine_key, state, start.row_limit(), looked.ids, filter.created.from,
                                  filter.created.to, looked.machines, filter.kind, filter.input_hash));
  Page<JobRecord> page;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) break;
    page.rows.push_back(ReadJob(row));
  }
  EndPage(
      start, [](const JobRecord& job) { return std::to_string(job.id.number()); },
      [](const JobRecord& job) {
        return job.params.size() + job.progress.stage.size() + job.progress.detail.size() +
               (job.error.has_value() ? job.error->reason.size() + job.error->message.size() : 0);
      },
      page);
  GoOnBelow(start, looked.last, page);
  for (JobRecord& job : page.rows) RETURN_IF_ERROR(ReadPrograms(connection, job));
  return page;
}

absl::StatusOr<bool> HoldWaiting(Connection& connection, JobId id) {
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT 1 FROM job WHERE id = ?1 AND state = 1 /*! FOR UPDATE */", id));
  return row.Step();
}

absl::StatusOr<JobRecord> CancelJob(Connection& connection, UtcTime now, JobId id, const Caller& caller) {
  RETURN_IF_ERROR(HoldWaiting(connection, id).status());
  ASSIGN_OR_RETURN(const JobRecord job, GetJob(connection, id));
  if (IsTerminal(job.state) || job.cancel_requested) return job;
  if (job.state == JobState::kQueued) {
    RETURN_IF_ERROR(connection.Run(
        "UPDATE job SET state = 5, cancel_requested = 1, ended_at_utc_us = ?2, version = version + 1 WHERE id = ?1", id,
        now));
  } else {
    RETURN_IF_ERROR(connection.Run("UPDATE job SET cancel_requested = 1, version = version + 1 WHERE id = ?1", id));
  }
  RETURN_IF_ERROR(AuditChange(connection, now, caller, "job.cancel", absl::StrCat("jobs/", id.number()),
                              job.state == JobState::kQueued ? "queued" : "running",
                              job.state == JobState::kQueued ? "cancelled" : "asked to stop"));
  return GetJob(connection, id);
}

absl::StatusOr<JobRecord> RequeueJob(Connection& connection, const Moment& now, JobId id, const JobRoom& room,
                                     const Caller& caller) {
  ASSIGN_OR_RETURN(const JobRecord job, GetJob(connection, id));
  if (!IsTerminal(job.state) || job.state == JobState::kSucceeded) {
    return FailedPrecondition(absl::StrCat("job ", id.number(), " has not failed"), "JOB_NOT_ENDED");
  }
  if (job.deadline && *job.deadline <= now.utc) {
    return FailedPrecondition(absl::StrCat("the deadline of job ", id.number(), " is over: create it anew"),
                              "JOB_TOO_LATE");
  }
  RETURN_IF_ERROR(CheckRoom(connection, room, job.created_by, job.machine));
  RETURN_IF_ERROR(connection.Run(
      "UPDATE job SET state = 1, attempt = 0, lost = 0, cancel_requested = 0, waits_from_up_us = ?2, wait_us = 0, "
      "progress_stage = '', progress_fraction = 0.0, progress_detail = '', version = version + 1 WHERE id = ?1",
      id, now.up_us));
  RETURN_IF_ERROR(
      AuditChange(connection, now.utc, caller, "job.requeue", absl::StrCat("jobs/", id.number()), "ended", "queued"));
  return GetJob(connection, id);
}

}  // namespace axiscal::storage
