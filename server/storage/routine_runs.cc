#include "server/storage/routine_runs.h"

#include <algorithm>

#include "server/storage/access.h"
#include "server/storage/audit.h"
#include "server/storage/events.h"
#include "server/storage/machines.h"
#include "server/storage/page_token.h"
#include "server/storage/refusal.h"
#include "server/storage/routines.h"

namespace axiscal::storage {
namespace {

constexpr char kSelectRun[] =
    "SELECT u.id, r.name, u.routine_etag, m.name, u.principal, u.state, u.job_id, u.calibration_id, u.text, "
    "u.began_at_utc_us, u.ended_at_utc_us, u.routine_id FROM routine_run AS u CROSS JOIN routine AS r ON r.id = "
    "u.routine_id CROSS JOIN machine AS m ON m.id = u.machine_id ";

absl::Status ReadSessions(Connection& connection, RoutineRun& run) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT is_check, session_id FROM routine_run_session WHERE run_id = "
                                                 "?1 ORDER BY position",
                                                 run.id));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return absl::OkStatus();
    (row.Bool(0) ? run.check_sessions : run.sessions).push_back(SessionId(row.Int(1)));
  }
}

absl::StatusOr<std::vector<RoutineRun>> ReadRuns(Connection& connection, Statement row) {
  std::vector<RoutineRun> runs;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return runs;
    RoutineRun run;
    run.id = RunId(row.Int(0));
    run.routine = row.Text(1);
    run.routine_etag = row.Int(2);
    run.machine = MachineId(row.Text(3));
    run.principal = row.Text(4);
    run.state = row.As<RunState>(5);
    if (!row.IsNull(6)) run.job = JobId(row.Int(6));
    if (!row.IsNull(7)) run.calibration = CalibrationId(row.Int(7));
    run.text = row.Text(8);
    run.began_at = row.Time(9);
    run.ended_at = row.OptionalTime(10);
    run.routine_id = RoutineId(row.Int(11));
    RETURN_IF_ERROR(ReadSessions(connection, run));
    runs.push_back(std::move(run));
  }
}

// ABORTED ETAG_MISMATCH where the newest run of the routine on the machine still goes on, or has had these sessions:
// another process was faster.
absl::Status CheckNotBegun(Connection& connection, const RoutineRecord& routine, int64_t machine_key,
                           const std::vector<SessionId>& sessions) {
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask("SELECT id, state FROM routine_run WHERE routine_id = ?1 AND machine_id = ?2 ORDER BY "
                     "id DESC LIMIT 1",
                     routine.id, machine_key));
  ASSIGN_OR_RETURN(const bool has_run, row.Step());
  if (!has_run) return absl::OkStatus();
  const int64_t run = row.Int(0);
  bool is_begun = records::IsOpen(row.As<RunState>(1));
  for (const SessionId session : sessions) {
    ASSIGN_OR_RETURN(
        Statement had,
        connection.Ask("SELECT 1 FROM routine_run_session WHERE run_id = ?1 AND session_id = ?2", run, session));
    ASSIGN_OR_RETURN(const bool is_had, had.Step());
    is_begun = is_begun || is_had;
  }
  if (!is_begun) return absl::OkStatus();
  return base::Error(absl::StatusCode::kAborted,
                     absl::StrCat("routine ", routine.content.name, " has begun a run on these sessions meanwhile"),
                     {"ETAG_MISMATCH", {{"run", std::to_string(run)}}});
}

absl::StatusOr<RoutineRun> GetRun(Connection& connection, RunId id) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask(std::string(kSelectRun) + "WHERE u.id = ?1", id));
  ASSIGN_OR_RETURN(std::vector<RoutineRun> runs, ReadRuns(connection, std::move(row)));
  if (runs.empty()) return NotFound("run", "RUN", std::to_string(id.number()));
  return std::move(runs[0]);
}

}  // namespace

absl::StatusOr<std::vector<RoutineRun>> NewestRuns(Connection& connection, const MachineId& machine) {
  ASSIGN_OR_RETURN(const int64_t key, MachineKey(connection, machine));
  // A seek for each routine that is not removed; and what is open of those that were.
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask(
          std::string(kSelectRun) +
              "WHERE u.id IN (SELECT (SELECT n.id FROM routine_run AS n WHERE n.routine_id = q.id AND "
              "n.machine_id = ?1 ORDER BY n.id DESC LIMIT 1) FROM routine AS q INDEXED BY routine_name WHERE "
              "q.removed_at_utc_us IS NULL UNION SELECT o.id FROM routine_run AS o INDEXED BY run_open_of_machine "
              "WHERE "
              "o.machine_id = ?1 AND o.state <= 2) ORDER BY u.id",
          key));
  return ReadRuns(connection, std::move(row));
}

absl::StatusOr<std::optional<NamedSession>> NewSessionFor(Connection& connection, RoutineId routine,
                                                          const MachineId& machine, const std::string& name) {
  ASSIGN_OR_RETURN(const int64_t key, MachineKey(connection, machine));
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask("SELECT id, measured_at_utc_us, closed_at_utc_us FROM session WHERE machine_id = ?1 AND name = ?2 "
                     "AND state = 2 AND id > (SELECT after_session_id FROM routine WHERE id = ?3) AND id > coalesce(("
                     "SELECT max(s.session_id) FROM routine_run_session AS s WHERE s.name = ?2 AND s.run_id = (SELECT "
                     "u.id FROM routine_run AS u WHERE u.routine_id = ?3 AND u.machine_id = ?1 ORDER BY u.id DESC "
                     "LIMIT 1)), 0) AND NOT EXISTS (SELECT 1 FROM session_remark AS x WHERE x.session_id = session.id "
                     "AND x.is_rejected = 1) ORDER BY id DESC LIMIT 1",
                     key, name, routine));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return std::nullopt;
  const UtcTime came = row.Time(2);
  return NamedSession{SessionId(row.Int(0)), row.IsNull(1) ? came : std::min(came, row.Time(1)), came};
}

absl::StatusOr<RoutineRun> BeginRun(Connection& connection, UtcTime now, const RoutineRecord& routine,
                                    const MachineId& machine, const std::vector<SessionId>& sessions,
                                    const std::vector<SessionId>& check_sessions) {
  ASSIGN_OR_RETURN(const RoutineRecord present, GetRoutine(connection, routine.content.name));
  RETURN_IF_ERROR(CheckEtag("routine " + routine.content.name, routine.etag, present.etag));
  ASSIGN_OR_RETURN(const int64_t key, LiveMachineKey(connection, machine));
  RETURN_IF_ERROR(CheckNotBegun(connection, routine, key, sessions));
  ASSIGN_OR_RETURN(const int64_t number,
                   connection.Insert("INSERT INTO routine_run (routine_id, routine_etag, machine_id, principal, state, "
                                     "text, began_at_utc_us) VALUES "
                                     "(?1, ?2, ?3, ?4, 1, '', ?5)",
                                     routine.id, routine.etag, key, routine.content.principal, now));
  const RunId id(number);
  int64_t position = 0;
  const auto add = [&](const std::vector<std::string>& names, const std::vector<SessionId>& ids,
                       bool is_check) -> absl::Status {
    for (size_t i = 0; i < ids.size(); ++i) {
      RETURN_IF_ERROR(connection.Run(
          "INSERT INTO routine_run_session (run_id, position, is_check, name, session_id) VALUES (?1, ?2, ?3, ?4, ?5)",
          id, position++, is_check, names.at(i), ids[i]));
    }
    return absl::OkStatus();
  };
  RETURN_IF_ERROR(add(routine.content.sessions, sessions, false));
  RETURN_IF_ERROR(add(routine.content.check_sessions, check_sessions, true));
  return GetRun(connection, id);
}

absl::StatusOr<RoutineRun> ChangeRun(Connection& connection, UtcTime now, const RunChange& change) {
  const bool is_open = records::IsOpen(change.state);
  RETURN_IF_ERROR(connection.Run(
      "UPDATE routine_run SET state = ?2, job_id = ?3, calibration_id = ?4, text = ?5, ended_at_utc_us = ?6 WHERE id = "
      "?1",
      change.run, static_cast<int>(change.state), change.job, change.calibration, change.text,
      is_open ? std::nullopt : std::optional(now)));
  ASSIGN_OR_RETURN(RoutineRun run, GetRun(connection, change.run));
  if (is_open) return run;
  ASSIGN_OR_RETURN(const int64_t key, MachineKey(connection, run.machine));
  RETURN_IF_ERROR(NoteChange(connection, key));
  return run;
}

absl::StatusOr<RoutineRun> RetryRoutine(Connection& connection, UtcTime now, const std::string& name,
                                        const MachineId& machine, const Caller& caller) {
  ASSIGN_OR_RETURN(const RoutineRecord routine, GetRoutine(connection, name));
  ASSIGN_OR_RETURN(const int64_t key, LiveMachineKey(connection, machine));
  ASSIGN_OR_RETURN(Statement row, connection.Ask(std::string(kSelectRun) +
                                                     "WHERE u.routine_id = ?1 AND u.machine_id = ?2 ORDER BY u.id "
                                                     "DESC LIMIT 1",
                                                 routine.id, key));
  ASSIGN_OR_RETURN(const std::vector<RoutineRun> newest, ReadRuns(connection, std::move(row)));
  const RoutineRun* const run = newest.empty() ? nullptr : &newest[0];
  if (run == nullptr)
    return FailedPrecondition("routine " + name + " never ran on machine " + machine.text(), "RUN_NOT_FAILED");
  if (run->state != RunState::kFailed && run->state != RunState::kStopped) {
    return FailedPrecondition(
        absl::StrCat("run ", run->id.number(), " of routine ", name, " on machine ", machine.text(), " is ",
                     records::NameOf(run->state), ": only one that failed or was stopped is tried again"),
        "RUN_NOT_FAILED");
  }
  RETURN_IF_ERROR(AuditChange(connection, now, caller, "routine.retry", "routines/" + name,
                              absl::StrCat("run ", run->id.number(), " ", records::NameOf(run->state)),
                              absl::StrCat("machines/", machine.text(), " waiting")));
  ASSIGN_OR_RETURN(const int64_t number,
                   connection.Insert("INSERT INTO routine_run (routine_id, routine_etag, machine_id, principal, state, "
                                     "text, began_at_utc_us) VALUES "
                                     "(?1, ?2, ?3, ?4, 1, '', ?5)",
                                     routine.id, routine.etag, key, routine.content.principal, now));
  const RunId id(number);
  RETURN_IF_ERROR(connection.Run(
      "INSERT INTO routine_run_session (run_id, position, is_check, name, session_id) SELECT ?1, position, is_check, "
      "name, session_id FROM routine_run_session WHERE run_id = ?2",
      id, run->id));
  return GetRun(connection, id);
}

absl::StatusOr<Page<RoutineRun>> ListRuns(Connection& connection, const RunFilter& filter, const PageRequest& request,
                                          const Visible& visible) {
  const std::string machine = filter.machine ? filter.machine->text() : "";
  ASSIGN_OR_RETURN(const PageStart start, StartPageById(request, absl::StrCat("runs|", machine, "|", filter.routine)));
  std::vector<int64_t> routines;
  if (!filter.routine.empty()) {
    ASSIGN_OR_RETURN(const RoutineRecord routine, GetRoutine(connection, filter.routine));
    routines = {routine.id.number()};
  }
  int64_t machine_key = 0;
  std::string ids, where;
  const std::string of_routine = routines.empty() ? "" : " AND u.routine_id = ?5";
  if (filter.machine) {
    ASSIGN_OR_RETURN(machine_key, MachineKey(connection, *filter.machine));
    where = " AND u.machine_id = ?3";
  } else if (!visible.everything) {
    ASSIGN_OR_RETURN(const std::vector<int64_t> machines, MachinesIn(connection, visible.scopes));
    const std::string of_machine =
        "SELECT id FROM routine_run AS u WHERE u.machine_id = ?1 AND u.id < ?2 AND u.id > "
        "?3 " +
        of_routine + " ORDER BY u.id DESC LIMIT ?4";
    ASSIGN_OR_RETURN(const std::vector<int64_t> newest,
                     NewestIds(connection, of_machine, machines, start.before_id, start.row_limit(),
                               routines.empty() ? 0 : routines[0]));
    ids = JsonOf(newest);
    where = " AND u.id IN (SELECT value FROM json_each(?4))";
  }
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask(std::string(kSelectRun) + "WHERE u.id < ?1" + where + of_routine + " ORDER BY u.id DESC LIMIT ?2",
                     start.before_id, start.row_limit(), machine_key, ids, routines.empty() ? 0 : routines[0]));
  Page<RoutineRun> page;
  ASSIGN_OR_RETURN(page.rows, ReadRuns(connection, std::move(row)));
  EndPage(
      start, [](const RoutineRun& run) { return std::to_string(run.id.number()); },
      [](const RoutineRun& run) {
        return run.text.size() + run.routine.size() + 8 * (run.sessions.size() + run.check_sessions.size());
      },
      page);
  return page;
}

}  // namespace axiscal::storage
