#include "server/storage/routines.h"

#include <algorithm>

#include "absl/strings/str_join.h"
#include "server/storage/access.h"
#include "server/storage/audit.h"
#include "server/storage/events.h"
#include "server/storage/machines.h"
#include "server/storage/refusal.h"

namespace axiscal::storage {
namespace {

using records::RoutineWork;
using records::Scope;

// A list that a person looks through, and that is gone through each minute.
constexpr int64_t kMostRoutines = 128;

constexpr char kSelectRoutine[] =
    "SELECT r.id, r.name, r.scope, r.scope_name, r.principal, r.within_hours, r.at_utc_minute, r.work, r.max_effects, "
    "r.budget_json, r.monte_carlo_runs, r.monte_carlo_seed, r.approve_within_um, r.is_enabled, r.note, r.etag, "
    "r.created_by, r.created_at_utc_us, r.changed_by, r.changed_at_utc_us FROM routine AS r INDEXED BY routine_name "
    "WHERE r.removed_at_utc_us IS NULL ";
// routine_text.list. Never renumber.
constexpr int kSessions = 1, kCheckSessions = 2, kDeclared = 3;

std::optional<int> OptionalInt(const Statement& row, int column) {
  if (row.IsNull(column)) return std::nullopt;
  return static_cast<int>(row.Int(column));
}

absl::StatusOr<std::vector<std::string>> ReadTexts(Connection& connection, RoutineId id, int list) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT text FROM routine_text WHERE routine_id = ?1 AND list = ?2 "
                                                 "ORDER BY position",
                                                 id, list));
  std::vector<std::string> texts;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return texts;
    texts.push_back(row.Text(0));
  }
}

absl::StatusOr<RoutineRecord> ReadRoutine(Connection& connection, const Statement& row) {
  RoutineRecord record;
  record.id = RoutineId(row.Int(0));
  Routine& routine = record.content;
  routine.name = row.Text(1);
  routine.scope = {row.As<Scope::Kind>(2), row.Text(3)};
  routine.principal = row.Text(4);
  routine.within_hours = static_cast<int>(row.Int(5));
  routine.at_utc_minute = OptionalInt(row, 6);
  routine.work = row.As<RoutineWork>(7);
  routine.max_effects = OptionalInt(row, 8);
  routine.budget_json = row.Text(9);
  routine.monte_carlo_runs = OptionalInt(row, 10);
  routine.monte_carlo_seed = static_cast<uint64_t>(row.Int(11));
  routine.approve_within_um = row.OptionalReal(12);
  routine.is_enabled = row.Bool(13);
  routine.note = row.Text(14);
  record.etag = row.Int(15);
  record.created_by = row.Text(16);
  record.created_at = row.Time(17);
  record.changed_by = row.Text(18);
  record.changed_at = row.Time(19);
  ASSIGN_OR_RETURN(routine.sessions, ReadTexts(connection, record.id, kSessions));
  ASSIGN_OR_RETURN(routine.check_sessions, ReadTexts(connection, record.id, kCheckSessions));
  ASSIGN_OR_RETURN(routine.declared, ReadTexts(connection, record.id, kDeclared));
  ASSIGN_OR_RETURN(Statement stop,
                   connection.Ask("SELECT m.name, s.by, s.note, s.at_utc_us FROM routine_stop AS s JOIN machine AS m "
                                  "ON m.id = s.machine_id WHERE s.routine_id = ?1",
                                  record.id));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, stop.Step());
    if (!more) break;
    record.stops.push_back({MachineId(stop.Text(0)), stop.Text(1), stop.Text(2), stop.Time(3)});
  }
  std::sort(record.stops.begin(), record.stops.end(),
            [](const RoutineStop& a, const RoutineStop& b) { return a.machine < b.machine; });
  return record;
}

absl::StatusOr<std::vector<RoutineRecord>> ReadRoutines(Connection& connection, Statement row) {
  std::vector<RoutineRecord> routines;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return routines;
    ASSIGN_OR_RETURN(RoutineRecord routine, ReadRoutine(connection, row));
    routines.push_back(std::move(routine));
  }
}

absl::StatusOr<std::optional<RoutineRecord>> FindRoutine(Connection& connection, const std::string& name) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask(std::string(kSelectRoutine) + "AND r.name = ?1", name));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return std::nullopt;
  ASSIGN_OR_RETURN(RoutineRecord record, ReadRoutine(connection, row));
  return record;
}

absl::StatusOr<int64_t> NewestSessionId(Connection& connection) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT id FROM session WHERE id > 0 ORDER BY id DESC LIMIT 1"));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  return found ? row.Int(0) : 0;
}

bool IsSame(const Routine& a, const Routine& b) {
  return a.name == b.name && a.scope == b.scope && a.principal == b.principal && a.sessions == b.sessions &&
         a.check_sessions == b.check_sessions && a.within_hours == b.within_hours &&
         a.at_utc_minute == b.at_utc_minute && a.work == b.work && a.declared == b.declared &&
         a.max_effects == b.max_effects && a.budget_json == b.budget_json && a.monte_carlo_runs == b.monte_carlo_runs &&
         a.monte_carlo_seed == b.monte_carlo_seed && a.approve_within_um == b.approve_within_um &&
         a.is_enabled == b.is_enabled && a.note == b.note;
}

// For the audit.
std::string TextOf(const Routine& routine) {
  std::string text = absl::StrCat(routine.is_enabled ? "" : "disabled; ", "for ", records::TextOf(routine.scope),
                                  " as ", routine.principal, "; sessions ", absl::StrJoin(routine.sessions, ", "),
                                  " within ", routine.within_hours, " h");
  if (routine.at_utc_minute) {
    absl::StrAppendFormat(&text, " at %02d:%02d UTC", *routine.at_utc_minute / 60, *routine.at_utc_minute % 60);
  }
  text += routine.work == RoutineWork::kFit ? "; identify" : "; close the loop";
  if (!routine.check_sessions.empty())
    absl::StrAppend(&text, " proved on ", absl::StrJoin(routine.check_sessions, ", "));
  if (!routine.declared.empty()) absl::StrAppend(&text, " errors ", absl::StrJoin(routine.declared, " "));
  if (routine.max_effects) absl::StrAppend(&text, " at most ", *routine.max_effects, " effects");
  if (!routine.budget_json.empty()) absl::StrAppend(&text, " budget of ", routine.budget_json.size(), " bytes");
  if (routine.monte_carlo_runs)
    absl::StrAppend(&text, " Monte Carlo ", *routine.monte_carlo_runs, " seed ", routine.monte_carlo_seed);
  text +=
      routine.approve_within_um ? absl::StrCat("; approve within ", *routine.approve_within_um, " um") : "; propose";
  if (!routine.note.empty()) absl::StrAppend(&text, "; ", routine.note);
  return text;
}

absl::Status WriteTexts(Connection& connection, RoutineId id, const Routine& routine) {
  RETURN_IF_ERROR(connection.Run("DELETE FROM routine_text WHERE routine_id = ?1", id));
  for (const auto& [list, texts] : {std::pair(kSessions, &routine.sessions),
                                    {kCheckSessions, &routine.check_sessions},
                                    {kDeclared, &routine.declared}}) {
    for (size_t i = 0; i < texts->size(); ++i) {
      RETURN_IF_ERROR(
          connection.Run("INSERT INTO routine_text (routine_id, list, position, text) VALUES (?1, ?2, ?3, ?4)", id,
                         list, static_cast<int64_t>(i), (*texts)[i]));
    }
  }
  return absl::OkStatus();
}

// A routine that nobody has said more of: what it acts as and works for must be there.
absl::Status CheckNames(Connection& connection, const Routine& routine) {
  ASSIGN_OR_RETURN(const std::optional<Holder> holder, FindHolderOfName(connection, routine.principal));
  if (!holder) return NotFound("principal", "PRINCIPAL", routine.principal);
  if (holder->is_revoked)
    return FailedPrecondition("principal " + routine.principal + " was revoked", "PRINCIPAL_REVOKED");
  if (routine.scope.kind == Scope::Kind::kMachine)
    return LiveMachineKey(connection, MachineId(routine.scope.name)).status();
  ASSIGN_OR_RETURN(const std::vector<int64_t> machines, MachinesIn(connection, {routine.scope}));
  if (machines.empty()) return NotFound("group", "GROUP", routine.scope.name);
  return absl::OkStatus();
}

std::string Place(const std::string& name) { return "routines/" + name; }

}  // namespace

absl::StatusOr<RoutineRecord> GetRoutine(Connection& connection, const std::string& name) {
  ASSIGN_OR_RETURN(std::optional<RoutineRecord> record, FindRoutine(connection, name));
  if (!record) return NotFound("routine", "ROUTINE", name);
  return *std::move(record);
}

absl::StatusOr<RoutineRecord> PutRoutine(Connection& connection, UtcTime now, const Routine& routine,
                                         int64_t expected_etag, const Caller& caller) {
  ASSIGN_OR_RETURN(const std::optional<RoutineRecord> present, FindRoutine(connection, routine.name));
  RETURN_IF_ERROR(CheckEtag("routine " + routine.name, expected_etag, present ? present->etag : 0));
  if (present && IsSame(present->content, routine)) return *present;
  RETURN_IF_ERROR(CheckNames(connection, routine));
  const bool begins_anew = !present || (routine.is_enabled && !present->content.is_enabled) ||
                           present->content.scope != routine.scope || present->content.sessions != routine.sessions ||
                           present->content.check_sessions != routine.check_sessions;
  ASSIGN_OR_RETURN(const int64_t newest_session, NewestSessionId(connection));
  RoutineId id;
  if (present) {
    id = present->id;
  } else {
    ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT count(*) FROM routine WHERE removed_at_utc_us IS NULL"));
    RETURN_IF_ERROR(row.Step().status());
    if (row.Int(0) >= kMostRoutines) {
      return base::Error(absl::StatusCode::kResourceExhausted,
                         absl::StrCat("there are ", kMostRoutines, " routines, no more are kept: remove one"),
                         {"TOO_MANY_ROUTINES", {}});
    }
    ASSIGN_OR_RETURN(
        const int64_t number,
        connection.Insert(
            "INSERT INTO routine (name, scope, scope_name, principal, within_hours, work, budget_json, "
            "monte_carlo_seed, "
            "is_enabled, note, after_session_id, etag, created_by, created_at_utc_us, changed_by, changed_at_utc_us, "
            "removed_by) VALUES (?1, 3, '', '', 1, 1, '', 1, 0, '', ?2, 1, ?3, ?4, '', 0, '')",
            routine.name, newest_session, caller.principal, now));
    id = RoutineId(number);
  }
  RETURN_IF_ERROR(connection.Run(
      "UPDATE routine SET scope = ?2, scope_name = ?3, principal = ?4, within_hours = ?5, at_utc_minute = ?6, work = "
      "?7, max_effects = ?8, budget_json = ?9, monte_carlo_runs = ?10, monte_carlo_seed = ?11, approve_within_um = "
      "?12, is_enabled = ?13, note = ?14, after_session_id = CASE WHEN ?15 = 1 THEN ?16 ELSE after_session_id END, "
      "etag = ?17, changed_by = "
      "?18, changed_at_utc_us = ?19 WHERE id = ?1",
      id, static_cast<int>(routine.scope.kind), routine.scope.name, routine.principal, routine.within_hours,
      routine.at_utc_minute, static_cast<int>(routine.work), routine.max_effects, routine.budget_json,
      routine.monte_carlo_runs, static_cast<int64_t>(routine.monte_carlo_seed), routine.approve_within_um,
      routine.is_enabled, routine.note, begins_anew, newest_session, present ? present->etag + 1 : 1, caller.principal,
      now));
  RETURN_IF_ERROR(WriteTexts(connection, id, routine));
  RETURN_IF_ERROR(AuditChange(connection, now, caller, "routine.put", Place(routine.name),
                              present ? TextOf(present->content) : "", TextOf(routine)));
  return GetRoutine(connection, routine.name);
}

absl::StatusOr<RoutineRecord> RemoveRoutine(Connection& connection, UtcTime now, const std::string& name,
                                            int64_t expected_etag, const Caller& caller) {
  ASSIGN_OR_RETURN(const RoutineRecord present, GetRoutine(connection, name));
  RETURN_IF_ERROR(CheckEtag("routine " + name, expected_etag, present.etag));
  RETURN_IF_ERROR(connection.Run("UPDATE routine SET removed_by = ?2, removed_at_utc_us = ?3 WHERE id = ?1", present.id,
                                 caller.principal, now));
  // Its events are over.
  std::vector<int64_t> machines;
  {
    ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT machine_id FROM event INDEXED BY event_open WHERE "
                                                   "cleared_at_utc_us IS NULL AND kind IN (?1, ?2) AND subject = ?3",
                                                   static_cast<int>(EventKind::kRoutineFailed),
                                                   static_cast<int>(EventKind::kRoutineProposes), name));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      machines.push_back(row.Int(0));
    }
  }
  for (const int64_t machine : machines) RETURN_IF_ERROR(NoteChange(connection, machine));
  RETURN_IF_ERROR(
      AuditChange(connection, now, caller, "routine.remove", Place(name), TextOf(present.content), "removed"));
  return present;
}

absl::StatusOr<RoutineRecord> StopRoutine(Connection& connection, UtcTime now, const std::string& name,
                                          const MachineId& machine, bool stops, const std::string& note,
                                          const Caller& caller) {
  ASSIGN_OR_RETURN(const RoutineRecord present, GetRoutine(connection, name));
  ASSIGN_OR_RETURN(const int64_t key, MachineKey(connection, machine));
  const bool is_stopped = std::any_of(present.stops.begin(), present.stops.end(),
                                      [&](const auto& stop) { return stop.machine == machine; });
  if (is_stopped == stops) return present;
  if (stops) {
    RETURN_IF_ERROR(
        connection.Run("INSERT INTO routine_stop (routine_id, machine_id, by, note, at_utc_us) VALUES (?1, ?2, ?3, ?4, "
                       "?5)",
                       present.id, key, caller.principal, note, now));
  } else {
    RETURN_IF_ERROR(
        connection.Run("DELETE FROM routine_stop WHERE routine_id = ?1 AND machine_id = ?2", present.id, key));
  }
  RETURN_IF_ERROR(NoteChange(connection, key));
  RETURN_IF_ERROR(
      AuditChange(connection, now, caller, stops ? "routine.stop" : "routine.resume", Place(name),
                  absl::StrCat("machines/", machine.text(), stops ? "" : " stopped"),
                  absl::StrCat("machines/", machine.text(), stops ? " stopped" : "", note.empty() ? "" : ": " + note)));
  return GetRoutine(connection, name);
}

absl::StatusOr<std::vector<RoutineRecord>> ListRoutines(Connection& connection, const Visible& visible) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask(std::string(kSelectRoutine) + "ORDER BY r.name"));
  ASSIGN_OR_RETURN(std::vector<RoutineRecord> routines, ReadRoutines(connection, std::move(row)));
  if (visible.everything) return routines;
  ASSIGN_OR_RETURN(const std::vector<int64_t> seen, MachinesIn(connection, visible.scopes));
  std::vector<RoutineRecord> shown;
  for (RoutineRecord& routine : routines) {
    ASSIGN_OR_RETURN(const std::vector<int64_t> its, MachinesIn(connection, {routine.content.scope}));
    const auto is_seen = [&](int64_t key) { return std::find(seen.begin(), seen.end(), key) != seen.end(); };
    if (!std::any_of(its.begin(), its.end(), is_seen)) continue;
    std::vector<RoutineStop> stops;
    for (RoutineStop& stop : routine.stops) {
      ASSIGN_OR_RETURN(const int64_t key, MachineKey(connection, stop.machine));
      if (is_seen(key)) stops.push_back(std::move(stop));
    }
    routine.stops = std::move(stops);
    shown.push_back(std::move(routine));
  }
  return shown;
}

absl::StatusOr<std::vector<MachineId>> MachinesWithRoutines(Connection& connection) {
  std::vector<int64_t> keys;
  {
    ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT scope, scope_name FROM routine INDEXED BY routine_name "
                                                   "WHERE removed_at_utc_us IS NULL AND is_enabled = 1"));
    std::vector<Scope> scopes;
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      scopes.push_back({row.As<Scope::Kind>(0), row.Text(1)});
    }
    if (!scopes.empty()) {
      ASSIGN_OR_RETURN(keys, MachinesIn(connection, scopes));
    }
  }
  ASSIGN_OR_RETURN(
      Statement open,
      connection.Ask("SELECT machine_id FROM routine_run INDEXED BY run_open_of_machine WHERE state <= 2"));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, open.Step());
    if (!more) break;
    keys.push_back(open.Int(0));
  }
  std::vector<MachineId> machines;
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT m.name FROM json_each(?1) CROSS JOIN machine AS m ON m.id = "
                                                 "json_each.value",
                                                 JsonOf(keys)));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) break;
    machines.push_back(MachineId(row.Text(0)));
  }
  std::sort(machines.begin(), machines.end());
  machines.erase(std::unique(machines.begin(), machines.end()), machines.end());
  return machines;
}

absl::StatusOr<std::vector<RoutineRecord>> RoutinesOf(Connection& connection, const MachineId& machine) {
  ASSIGN_OR_RETURN(const int64_t key, MachineKey(connection, machine));
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask(std::string(kSelectRoutine) +
                                      "AND ((r.scope = 3 AND r.scope_name = ?2) OR (r.scope = 2 AND r.scope_name IN "
                                      "(SELECT name FROM machine_group WHERE machine_id = ?1))) ORDER BY r.name",
                                  key, machine.text()));
  return ReadRoutines(connection, std::move(row));
}

}  // namespace axiscal::storage
