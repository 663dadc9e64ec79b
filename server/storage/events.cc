#include "server/storage/events.h"

#include <algorithm>
#include <set>

#include "server/storage/access.h"
#include "server/storage/audit.h"
#include "server/storage/machines.h"
#include "server/storage/page_token.h"
#include "server/storage/refusal.h"

namespace axiscal::storage {
namespace {

constexpr char kSelectEvent[] =
    "SELECT e.id, m.name, e.kind, e.subject, e.text, e.advice, e.certainty, e.calibration_id, e.from_utc_us, "
    "e.to_utc_us, e.raised_at_utc_us, e.cleared_at_utc_us, e.cleared_why, e.acknowledged_at_utc_us, "
    "e.acknowledged_by, e.acknowledged_note, e.shelved_until_utc_us, e.shelved_by, e.shelved_note FROM event AS e ";
constexpr char kOfMachine[] = "JOIN machine AS m ON m.id = e.machine_id ";

// Longer nobody remembers why.
constexpr auto kLongestShelf = std::chrono::days(366);
// Of one page of changes, seen or not.
constexpr int kChangesRead = 500;

absl::StatusOr<Event> ReadEvent(Connection& connection, const Statement& row) {
  Event event;
  event.id = EventId(row.Int(0));
  event.machine = MachineId(row.Text(1));
  EventContent& content = event.content;
  content.kind = row.As<EventKind>(2);
  content.subject = row.Text(3);
  content.text = row.Text(4);
  content.advice = row.Text(5);
  content.certainty = row.OptionalReal(6);
  if (!row.IsNull(7)) content.calibration = CalibrationId(row.Int(7));
  content.from = row.OptionalTime(8);
  content.to = row.OptionalTime(9);
  event.raised_at = row.Time(10);
  event.cleared_at = row.OptionalTime(11);
  event.cleared_why = row.Text(12);
  event.acknowledged_at = row.OptionalTime(13);
  event.acknowledged_by = row.Text(14);
  event.acknowledged_note = row.Text(15);
  event.shelved_until = row.OptionalTime(16);
  event.shelved_by = row.Text(17);
  event.shelved_note = row.Text(18);
  ASSIGN_OR_RETURN(Statement amount, connection.Ask("SELECT symbol, unit, size_um_urad, sigma_um_urad FROM "
                                                    "event_amount WHERE event_id = ?1 ORDER BY position",
                                                    event.id));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, amount.Step());
    if (!more) return event;
    content.amounts.push_back({amount.Text(0), amount.As<EstimateUnit>(1), amount.Real(2), amount.Real(3)});
  }
}

absl::StatusOr<std::vector<Event>> ReadEvents(Connection& connection, Statement row) {
  std::vector<Event> events;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return events;
    ASSIGN_OR_RETURN(Event event, ReadEvent(connection, row));
    events.push_back(std::move(event));
  }
}

absl::Status AddChange(Connection& connection, UtcTime now, EventId id, EventChangeKind what, const std::string& by,
                       const std::string& note) {
  return connection.Run("INSERT INTO event_change (event_id, what, at_utc_us, by, note) VALUES (?1, ?2, ?3, ?4, ?5)",
                        id, static_cast<int>(what), now, by, note);
}

absl::Status WriteAmounts(Connection& connection, EventId id, const EventContent& content) {
  RETURN_IF_ERROR(connection.Run("DELETE FROM event_amount WHERE event_id = ?1", id));
  for (size_t i = 0; i < content.amounts.size(); ++i) {
    const records::DriftAmount& amount = content.amounts[i];
    RETURN_IF_ERROR(connection.Run(
        "INSERT INTO event_amount (event_id, position, symbol, unit, size_um_urad, sigma_um_urad) "
        "VALUES (?1, ?2, ?3, ?4, ?5, ?6)",
        id, static_cast<int64_t>(i), amount.symbol, static_cast<int>(amount.unit), amount.size, amount.sigma));
  }
  return absl::OkStatus();
}

// Whether there was none yet.
absl::StatusOr<bool> Raise(Connection& connection, UtcTime now, int64_t machine_key, const EventContent& content) {
  ASSIGN_OR_RETURN(
      const std::optional<int64_t> number,
      connection.InsertIfNew(
          "INSERT INTO event (machine_id, kind, subject, text, advice, certainty, calibration_id, from_utc_us, "
          "to_utc_us, raised_at_utc_us, cleared_why, acknowledged_by, acknowledged_note, shelved_by, shelved_note) "
          "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, '', '', '', '', '') ON CONFLICT DO NOTHING",
          machine_key, static_cast<int>(content.kind), content.subject, content.text, content.advice, content.certainty,
          content.calibration, content.from, content.to, now));
  if (!number) return false;
  const EventId id(*number);
  RETURN_IF_ERROR(WriteAmounts(connection, id, content));
  RETURN_IF_ERROR(AddChange(connection, now, id, EventChangeKind::kRaised, "", ""));
  return true;
}

absl::StatusOr<bool> Update(Connection& connection, UtcTime now, const EventChanges::Update& update) {
  const EventContent& content = update.content;
  RETURN_IF_ERROR(connection.Run(
      "UPDATE event SET text = ?2, advice = ?3, certainty = ?4, calibration_id = ?5, from_utc_us = ?6, to_utc_us = ?7 "
      "WHERE id = ?1 AND cleared_at_utc_us IS NULL",
      update.event, content.text, content.advice, content.certainty, content.calibration, content.from, content.to));
  if (connection.changed_rows() == 0) return false;
  RETURN_IF_ERROR(WriteAmounts(connection, update.event, content));
  RETURN_IF_ERROR(AddChange(connection, now, update.event, EventChangeKind::kUpdated, "", ""));
  return true;
}

absl::StatusOr<bool> Clear(Connection& connection, UtcTime now, EventId id, const std::string& why) {
  RETURN_IF_ERROR(
      connection.Run("UPDATE event SET cleared_at_utc_us = ?2, cleared_why = ?3, shelved_until_utc_us = NULL "
                     "WHERE id = ?1 AND cleared_at_utc_us IS NULL",
                     id, now, why));
  if (connection.changed_rows() == 0) return false;
  RETURN_IF_ERROR(AddChange(connection, now, id, EventChangeKind::kCleared, "", why));
  return true;
}

bool IsSame(const Expectations& a, const Expectations& b) {
  const auto is_same_limit = [](const records::DriftLimit& x, const records::DriftLimit& y) {
    return x.symbol == y.symbol && x.low == y.low && x.high == y.high;
  };
  const auto is_same_session = [](const records::ExpectedSession& x, const records::ExpectedSession& y) {
    return x.name == y.name && x.every_hours == y.every_hours;
  };
  return a.calibration_days == b.calibration_days && a.counts_candidates == b.counts_candidates &&
         std::equal(a.tolerances.begin(), a.tolerances.end(), b.tolerances.begin(), b.tolerances.end(),
                    is_same_limit) &&
         std::equal(a.sessions.begin(), a.sessions.end(), b.sessions.begin(), b.sessions.end(), is_same_session);
}

// As it is read: in order of symbol and name.
Expectations InOrder(Expectations expected) {
  std::sort(expected.tolerances.begin(), expected.tolerances.end(),
            [](const auto& a, const auto& b) { return a.symbol < b.symbol; });
  std::sort(expected.sessions.begin(), expected.sessions.end(),
            [](const auto& a, const auto& b) { return a.name < b.name; });
  return expected;
}

absl::Status WriteLists(Connection& connection, int64_t machine_key, const Expectations& expected) {
  RETURN_IF_ERROR(connection.Run("DELETE FROM expected_tolerance WHERE machine_id = ?1", machine_key));
  RETURN_IF_ERROR(connection.Run("DELETE FROM expected_session WHERE machine_id = ?1", machine_key));
  for (const records::DriftLimit& limit : expected.tolerances) {
    RETURN_IF_ERROR(
        connection.Run("INSERT INTO expected_tolerance (machine_id, symbol, low_um_urad, high_um_urad) "
                       "VALUES (?1, ?2, ?3, ?4)",
                       machine_key, limit.symbol, limit.low, limit.high));
  }
  for (const records::ExpectedSession& session : expected.sessions) {
    RETURN_IF_ERROR(connection.Run("INSERT INTO expected_session (machine_id, name, every_hours) VALUES (?1, ?2, ?3)",
                                   machine_key, session.name, session.every_hours));
  }
  return absl::OkStatus();
}

// For the audit.
std::string TextOf(const Expectations& expected) {
  std::string text;
  for (const records::DriftLimit& limit : expected.tolerances)
    absl::StrAppend(&text, limit.symbol, "=", limit.low, "..", limit.high, " ");
  for (const records::ExpectedSession& session : expected.sessions)
    absl::StrAppend(&text, session.name, " every ", session.every_hours, " h ");
  if (expected.calibration_days) absl::StrAppend(&text, "calibration of ", *expected.calibration_days, " days ");
  if (expected.counts_candidates) text += "candidates count ";
  if (!text.empty()) text.pop_back();
  return text;
}

std::string Place(EventId id) { return absl::StrCat("events/", id.number()); }

}  // namespace

absl::Status NoteChange(Connection& connection, int64_t machine_key) {
  return connection.Run(
      "INSERT INTO event_look (machine_id, changes, looked_at, looked_by) VALUES (?1, 1, 0, '') "
      "ON CONFLICT (machine_id) DO UPDATE SET changes = event_look.changes + 1",
      machine_key);
}

absl::StatusOr<ExpectationsRecord> GetExpectations(Connection& connection, const MachineId& machine) {
  ASSIGN_OR_RETURN(const int64_t key, MachineKey(connection, machine));
  ExpectationsRecord record;
  record.content.machine = machine;
  {
    ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT etag, calibration_days, counts_candidates, changed_by, "
                                                   "changed_at_utc_us FROM expectation WHERE machine_id = ?1",
                                                   key));
    ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return record;
    record.etag = row.Int(0);
    if (!row.IsNull(1)) record.content.calibration_days = static_cast<int>(row.Int(1));
    record.content.counts_candidates = row.Bool(2);
    record.changed_by = row.Text(3);
    record.changed_at = row.Time(4);
  }
  {
    ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT symbol, low_um_urad, high_um_urad FROM expected_tolerance "
                                                   "WHERE machine_id = ?1 ORDER BY symbol",
                                                   key));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      record.content.tolerances.push_back({row.Text(0), row.Real(1), row.Real(2)});
    }
  }
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask("SELECT name, every_hours FROM expected_session WHERE machine_id = ?1 ORDER BY name", key));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return record;
    record.content.sessions.push_back({row.Text(0), static_cast<int>(row.Int(1))});
  }
}

absl::StatusOr<ExpectationsRecord> SetExpectations(Connection& connection, UtcTime now, const Expectations& expected,
                                                   int64_t expected_etag, const Caller& caller) {
  ASSIGN_OR_RETURN(const int64_t key, LiveMachineKey(connection, expected.machine));
  ASSIGN_OR_RETURN(const ExpectationsRecord present, GetExpectations(connection, expected.machine));
  RETURN_IF_ERROR(CheckEtag("what is expected of machine " + expected.machine.text(), expected_etag, present.etag));
  if (present.etag > 0 && IsSame(present.content, InOrder(expected))) return present;
  RETURN_IF_ERROR(connection.Run(
      "INSERT INTO expectation (machine_id, etag, calibration_days, counts_candidates, changed_by, changed_at_utc_us) "
      "VALUES (?1, 1, ?2, ?3, ?4, ?5) ON CONFLICT (machine_id) DO UPDATE SET etag = expectation.etag + 1, "
      "calibration_days = ?2, "
      "counts_candidates = ?3, changed_by = ?4, changed_at_utc_us = ?5",
      key, expected.calibration_days, expected.counts_candidates, caller.principal, now));
  RETURN_IF_ERROR(WriteLists(connection, key, expected));
  RETURN_IF_ERROR(NoteChange(connection, key));
  RETURN_IF_ERROR(AuditChange(connection, now, caller, "expectations.set", "machines/" + expected.machine.text(),
                              TextOf(present.content), TextOf(InOrder(expected))));
  return GetExpectations(connection, expected.machine);
}

absl::StatusOr<std::vector<std::pair<MachineId, int64_t>>> MachinesWithEvents(Connection& connection, int most) {
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask("SELECT min(m.name) AS name, count(*) AS events FROM event AS e INDEXED BY event_open_of_machine "
                     "CROSS JOIN machine AS m ON m.id = e.machine_id WHERE e.cleared_at_utc_us IS NULL AND "
                     "e.acknowledged_at_utc_us IS NULL AND e.shelved_until_utc_us IS NULL AND "
                     "m.deleted_at_utc_us IS NULL GROUP BY e.machine_id ORDER BY events DESC, name "
                     "LIMIT ?1",
                     most));
  std::vector<std::pair<MachineId, int64_t>> machines;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return machines;
    machines.emplace_back(MachineId(row.Text(0)), row.Int(1));
  }
}

absl::StatusOr<Event> GetEvent(Connection& connection, EventId id) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask(std::string(kSelectEvent) + kOfMachine + "WHERE e.id = ?1", id));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NotFound("event", "EVENT", std::to_string(id.number()));
  return ReadEvent(connection, row);
}

absl::StatusOr<Page<Event>> ListEvents(Connection& connection, const EventFilter& filter, const PageRequest& request,
                                       const Visible& visible) {
  const std::string machine = filter.machine ? filter.machine->text() : "";
  ASSIGN_OR_RETURN(const PageStart start,
                   StartPageById(request, absl::StrCat("events|", machine, "|", filter.is_open_only ? 1 : 0)));
  const std::string open = filter.is_open_only ? " AND e.cleared_at_utc_us IS NULL" : "";
  int64_t machine_key = 0;
  std::string ids, index = filter.is_open_only ? "INDEXED BY event_open " : "", where;
  if (filter.machine) {
    ASSIGN_OR_RETURN(machine_key, MachineKey(connection, *filter.machine));
    index = filter.is_open_only ? "INDEXED BY event_open_of_machine " : "";
    where = " AND e.machine_id = ?3";
  } else if (!visible.everything) {
    ASSIGN_OR_RETURN(const std::vector<int64_t> machines, MachinesIn(connection, visible.scopes));
    const std::string of_machine = "SELECT id FROM event AS e WHERE e.machine_id = ?1 AND e.id < ?2 AND e.id > ?3" +
                                   open + " ORDER BY e.id DESC LIMIT ?4";
    ASSIGN_OR_RETURN(const std::vector<int64_t> newest,
                     NewestIds(connection, of_machine, machines, start.before_id, start.row_limit(), 0));
    ids = JsonOf(newest);
    index = "";
    where = " AND e.id IN (SELECT value FROM json_each(?4))";
  }
  const std::string sql = std::string(kSelectEvent) + index + kOfMachine + "WHERE e.id < ?1" + open + where +
                          " ORDER BY e.id DESC LIMIT ?2";
  ASSIGN_OR_RETURN(Statement row, connection.Ask(sql, start.before_id, start.row_limit(), machine_key, ids));
  Page<Event> page;
  ASSIGN_OR_RETURN(page.rows, ReadEvents(connection, std::move(row)));
  EndPage(
      start, [](const Event& event) { return std::to_string(event.id.number()); },
      [](const Event& event) {
        return event.content.text.size() + event.content.advice.size() + event.cleared_why.size() +
               event.acknowledged_note.size() + event.shelved_note.size() + 60 * event.content.amounts.size();
      },
      page);
  return page;
}

absl::StatusOr<std::vector<Event>> StandingEvents(Connection& connection, const MachineId& machine) {
  ASSIGN_OR_RETURN(const int64_t key, MachineKey(connection, machine));
  const std::string select = std::string(kSelectEvent);
  ASSIGN_OR_RETURN(Statement open, connection.Ask(select + "INDEXED BY event_open_of_machine " + kOfMachine +
                                                      "WHERE e.machine_id = ?1 AND e.cleared_at_utc_us IS NULL",
                                                  key));
  ASSIGN_OR_RETURN(std::vector<Event> events, ReadEvents(connection, std::move(open)));
  ASSIGN_OR_RETURN(Statement steps, connection.Ask(select + "INDEXED BY event_step " + kOfMachine +
                                                       "WHERE e.machine_id = ?1 AND e.kind = 3 AND "
                                                       "e.cleared_at_utc_us IS NOT NULL AND "
                                                       "e.acknowledged_at_utc_us IS NOT NULL",
                                                   key));
  ASSIGN_OR_RETURN(std::vector<Event> known, ReadEvents(connection, std::move(steps)));
  events.insert(events.end(), known.begin(), known.end());
  return events;
}

absl::StatusOr<Event> AcknowledgeEvent(Connection& connection, UtcTime now, EventId id, const std::string& note,
                                       const Caller& caller) {
  ASSIGN_OR_RETURN(const Event present, GetEvent(connection, id));
  if (present.acknowledged_at) return present;
  RETURN_IF_ERROR(connection.Run(
      "UPDATE event SET acknowledged_at_utc_us = ?2, acknowledged_by = ?3, acknowledged_note = ?4 WHERE id = ?1", id,
      now, caller.principal, note));
  RETURN_IF_ERROR(AddChange(connection, now, id, EventChangeKind::kAcknowledged, caller.principal, note));
  RETURN_IF_ERROR(AuditChange(connection, now, caller, "event.acknowledge", Place(id), "", note));
  if (present.content.kind == EventKind::kStep)
    RETURN_IF_ERROR(Clear(connection, now, id, "acknowledged: a step has happened and does not end").status());
  return GetEvent(connection, id);
}

absl::StatusOr<Event> ShelveEvent(Connection& connection, UtcTime now, EventId id, std::optional<UtcTime> until,
                                  const std::string& note, const Caller& caller) {
  ASSIGN_OR_RETURN(const Event present, GetEvent(connection, id));
  if (until && (*until <= now || *until > now + kLongestShelf))
    return InvalidArgument("an event is shelved until a time ahead, within a year", "EVENT_INVALID");
  if (present.cleared_at)
    return FailedPrecondition(absl::StrCat("event ", id.number(), " is cleared"), "EVENT_CLEARED");
  if (!until && !present.shelved_until) return present;
  RETURN_IF_ERROR(
      connection.Run("UPDATE event SET shelved_until_utc_us = ?2, shelved_by = ?3, shelved_note = ?4 WHERE id = ?1", id,
                     until, caller.principal, note));
  RETURN_IF_ERROR(AddChange(connection, now, id, until ? EventChangeKind::kShelved : EventChangeKind::kBack,
                            caller.principal, note));
  RETURN_IF_ERROR(AuditChange(connection, now, caller, until ? "event.shelve" : "event.unshelve", Place(id), "", note));
  return GetEvent(connection, id);
}

absl::StatusOr<bool> HasEventToBringBack(Connection& connection, UtcTime now) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT 1 FROM event WHERE shelved_until_utc_us <= ?1 LIMIT 1", now));
  return row.Step();
}

absl::StatusOr<int> BringBackEvents(Connection& connection, UtcTime now) {
  std::vector<EventId> due;
  {
    ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT id FROM event WHERE shelved_until_utc_us <= ?1 ORDER BY "
                                                   "shelved_until_utc_us LIMIT 1000",
                                                   now));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      due.push_back(EventId(row.Int(0)));
    }
  }
  for (const EventId id : due) {
    RETURN_IF_ERROR(connection.Run("UPDATE event SET shelved_until_utc_us = NULL WHERE id = ?1", id));
    RETURN_IF_ERROR(AddChange(connection, now, id, EventChangeKind::kBack, "", "its time on the shelf is over"));
  }
  return static_cast<int>(due.size());
}

absl::StatusOr<int> ChangeEvents(Connection& connection, UtcTime now, const EventChanges& changes) {
  ASSIGN_OR_RETURN(const int64_t key, MachineKey(connection, changes.machine));
  int count = 0;
  // First what makes room: an event that is cleared may be raised again.
  for (const EventChanges::Clearing& clearing : changes.cleared) {
    ASSIGN_OR_RETURN(const bool is_changed, Clear(connection, now, clearing.event, clearing.why));
    count += is_changed ? 1 : 0;
  }
  for (const EventChanges::Update& update : changes.updated) {
    ASSIGN_OR_RETURN(const bool is_changed, Update(connection, now, update));
    count += is_changed ? 1 : 0;
  }
  for (const EventContent& content : changes.raised) {
    ASSIGN_OR_RETURN(const bool is_changed, Raise(connection, now, key, content));
    count += is_changed ? 1 : 0;
  }
  if (changes.looked_at) {
    RETURN_IF_ERROR(
        connection.Run("INSERT INTO event_look (machine_id, changes, looked_at, looked_by) VALUES (?1, ?2, ?2, ?3) "
                       "ON CONFLICT (machine_id) DO UPDATE SET looked_at = ?2, looked_by = ?3",
                       key, *changes.looked_at, changes.looked_by));
    RETURN_IF_ERROR(connection.Run("DELETE FROM standing_finding WHERE machine_id = ?1", key));
    for (size_t i = 0; i < changes.findings.size(); ++i) {
      const StandingFinding& finding = changes.findings[i];
      RETURN_IF_ERROR(
          connection.Run("INSERT INTO standing_finding (machine_id, position, kind, at_utc_us, text) VALUES (?1, ?2, "
                         "?3, ?4, ?5)",
                         key, static_cast<int64_t>(i), static_cast<int64_t>(finding.kind), finding.at, finding.text));
    }
  }
  return count;
}

absl::StatusOr<EventChangePage> ReadEventChanges(Connection& connection, int64_t after,
                                                 const std::optional<MachineId>& machine, const Visible& visible) {
  ASSIGN_OR_RETURN(const int64_t last, LastEventChange(connection));
  if (after > last) {
    return base::Error(absl::StatusCode::kOutOfRange,
                       absl::StrCat("there was no change ", after, " of an event yet, the last is ", last,
                                    ": the database is an older one; begin anew"),
                       {"CHANGE_UNKNOWN", {{"last_change", std::to_string(last)}}});
  }
  std::set<int64_t> seen;
  const bool sees_all = visible.everything && !machine;
  if (machine) {
    ASSIGN_OR_RETURN(const int64_t key, MachineKey(connection, *machine));
    seen.insert(key);
  } else if (!visible.everything) {
    ASSIGN_OR_RETURN(const std::vector<int64_t> machines, MachinesIn(connection, visible.scopes));
    seen.insert(machines.begin(), machines.end());
  }
  EventChangePage page;
  page.up_to = after;
  std::vector<EventId> events;
  int read = 0;
  {
    // Whatever the asker may see, as many are gone through: a page costs the same.
    ASSIGN_OR_RETURN(Statement row,
                     connection.Ask("SELECT c.id, c.what, c.at_utc_us, c.by, c.note, c.event_id, e.machine_id "
                                    "FROM event_change AS c JOIN event AS e ON e.id = c.event_id WHERE c.id > ?1 "
                                    "ORDER BY c.id LIMIT ?2",
                                    after, kChangesRead));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      ++read;
      page.up_to = row.Int(0);
      if (!sees_all && !seen.contains(row.Int(6))) continue;
      page.changes.push_back({row.Int(0), row.As<EventChangeKind>(1), row.Time(2), row.Text(3), row.Text(4), {}});
      events.push_back(EventId(row.Int(5)));
    }
  }
  for (size_t i = 0; i < events.size(); ++i) {
    ASSIGN_OR_RETURN(page.changes[i].event, GetEvent(connection, events[i]));
  }
  page.is_last = read < kChangesRead;
  return page;
}

absl::StatusOr<EventChange> GetEventChange(Connection& connection, int64_t id) {
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT what, at_utc_us, by, note, event_id FROM event_change WHERE id = ?1", id));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NotFound("change", "CHANGE", std::to_string(id));
  EventChange change = {id, row.As<EventChangeKind>(0), row.Time(1), row.Text(2), row.Text(3), {}};
  ASSIGN_OR_RETURN(change.event, GetEvent(connection, EventId(row.Int(4))));
  return change;
}

absl::StatusOr<int64_t> LastEventChange(Connection& connection) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT id FROM event_change WHERE id > 0 ORDER BY id DESC LIMIT 1"));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  return found ? row.Int(0) : 0;
}

absl::StatusOr<LookStand> GetLookStand(Connection& connection, const MachineId& machine) {
  ASSIGN_OR_RETURN(const int64_t key, MachineKey(connection, machine));
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT changes, looked_at, looked_by FROM event_look WHERE machine_id = ?1", key));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  return found ? LookStand{row.Int(0), row.Int(1), row.Text(2)} : LookStand{};
}

absl::StatusOr<std::vector<MachineId>> MachinesToLookAt(Connection& connection, const std::string& version) {
  std::set<MachineId> machines;
  for (const char* const sql :
       {"SELECT m.name FROM event_look AS l INDEXED BY event_look_due JOIN machine AS m ON m.id = l.machine_id WHERE "
        "l.changes <> l.looked_at AND m.deleted_at_utc_us IS NULL",
        "SELECT m.name FROM event_look AS l JOIN machine AS m ON m.id = l.machine_id WHERE l.looked_by < ?1 AND "
        "m.deleted_at_utc_us IS NULL",
        "SELECT m.name FROM event_look AS l JOIN machine AS m ON m.id = l.machine_id WHERE l.looked_by > ?1 AND "
        "m.deleted_at_utc_us IS NULL",
        "SELECT m.name FROM cell CROSS JOIN machine AS m ON m.id = cell.machine_id WHERE m.deleted_at_utc_us IS NULL",
        "SELECT m.name FROM expectation CROSS JOIN machine AS m ON m.id = expectation.machine_id WHERE "
        "m.deleted_at_utc_us IS NULL"}) {
    ASSIGN_OR_RETURN(Statement row, connection.Ask(sql, version));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      machines.insert(MachineId(row.Text(0)));
    }
  }
  return std::vector<MachineId>(machines.begin(), machines.end());
}

absl::StatusOr<std::optional<UtcTime>> NewestSession(Connection& connection, const MachineId& machine,
                                                     const std::string& name) {
  ASSIGN_OR_RETURN(const int64_t key, MachineKey(connection, machine));
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT measured_at_utc_us, closed_at_utc_us FROM session "
                                                 "WHERE machine_id = ?1 AND name = ?2 AND state = 2 AND NOT EXISTS "
                                                 "(SELECT 1 FROM session_remark AS x WHERE x.session_id = "
                                                 "session.id AND x.is_rejected = 1) ORDER BY id DESC LIMIT 1",
                                                 key, name));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return std::nullopt;
  // A file of last year that comes today is no new one, and no clock of a cell makes one of tomorrow.
  const UtcTime came = row.Time(1);
  return row.IsNull(0) ? came : std::min(came, row.Time(0));
}

}  // namespace axiscal::storage
