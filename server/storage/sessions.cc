#include "server/storage/sessions.h"

#include <algorithm>
#include <set>

#include "core/session/checksum.h"
#include "server/storage/access.h"
#include "server/storage/audit.h"
#include "server/storage/machines.h"
#include "server/storage/page_token.h"
#include "server/storage/refusal.h"
#include "server/storage/request.h"
#include "server/storage/session_remarks.h"
#include "server/storage/up_time.h"

namespace axiscal::storage {
namespace {

constexpr char kSelectSession[] =
    "SELECT s.id, m.name, s.name, s.instrument, s.measured_at_utc_us, s.state, s.next_seq, s.reading_count, s.hash, "
    "s.created_by, "
    "s.created_at_utc_us, s.last_seen_at_utc_us, s.closed_at_utc_us FROM session AS s JOIN machine AS m ON m.id = "
    "s.machine_id ";

// As its indices have it.
constexpr char kMeasuredAt[] = "coalesce(measured_at_utc_us, created_at_utc_us)";
constexpr char kWithLabel[] =
    "SELECT session_id FROM session_label INDEXED BY session_with_label WHERE label = ?1 AND session_id < ?2 AND "
    "session_id > ?3 ORDER BY session_id DESC LIMIT ?4";

std::string Place(SessionId id) { return absl::StrCat("session ", id.number()); }

SessionRecord ReadSession(const Statement& row) {
  SessionRecord session;
  session.id = SessionId(row.Int(0));
  session.machine = MachineId(row.Text(1));
  session.name = row.Text(2);
  session.instrument = row.Text(3);
  session.measured_at = row.OptionalTime(4);
  session.state = row.As<SessionState>(5);
  session.next_seq = row.Int(6);
  session.reading_count = row.Int(7);
  session.hash = row.Text(8);
  session.created_by = row.Text(9);
  session.created_at = row.Time(10);
  session.last_seen_at = row.Time(11);
  session.closed_at = row.OptionalTime(12);
  return session;
}

absl::Status DamagedBody(SessionId id) {
  return base::Error(absl::StatusCode::kDataLoss,
                     Place(id) +
                         " is damaged: its header or columns are not what was stored; restore a "
                         "backup, or send the session again",
                     {"SESSION_DAMAGED", {{"session", std::to_string(id.number())}}});
}

// None where the disk has lost them.
absl::StatusOr<std::vector<ColumnSpec>> ReadColumns(Connection& connection, SessionId id) {
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask("SELECT name, is_text FROM session_column WHERE session_id = ?1 ORDER BY position", id));
  std::vector<ColumnSpec> columns;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return columns;
    columns.push_back({row.Text(0), row.Bool(1)});
  }
}

absl::Status ReadLists(Connection& connection, SessionRecord& session) {
  ASSIGN_OR_RETURN(session.columns, ReadColumns(connection, session.id));
  ASSIGN_OR_RETURN(session.remark, ReadRemark(connection, session.id));
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask("SELECT key, text FROM session_header WHERE session_id = ?1 ORDER BY position", session.id));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return absl::OkStatus();
    session.header.push_back({row.Text(0), row.Text(1)});
  }
}

// Of a NewSession or of the record made of it.
template <typename Session>
std::string HashBody(const Session& session) {
  BodyHash hash;
  hash.Add(session.machine.text()).Add(session.name).Add(session.instrument);
  hash.Add(session.measured_at.has_value() ? base::ToUtcUs(*session.measured_at) : -1).Add(session.header.size());
  for (const session::HeaderEntry& entry : session.header) hash.Add(entry.key).Add(entry.value);
  for (const ColumnSpec& column : session.columns) hash.Add(column.name).Add(column.is_text ? 1 : 0);
  return hash.Hex();
}

absl::Status CheckNew(const NewSession& session) {
  if (session.columns.empty()) return InvalidArgument("a session without columns", "SESSION_INVALID");
  std::set<std::string> names;
  for (const ColumnSpec& column : session.columns) {
    if (column.name.empty()) return InvalidArgument("a column without a name", "SESSION_INVALID");
    if (!names.insert(column.name).second)
      return InvalidArgument("column " + column.name + " twice", "SESSION_INVALID");
  }
  return absl::OkStatus();
}

absl::Status InsertLists(Connection& connection, SessionId id, const NewSession& session) {
  for (size_t i = 0; i < session.header.size(); ++i) {
    RETURN_IF_ERROR(
        connection.Run("INSERT INTO session_header (session_id, position, key, text) VALUES (?1, ?2, ?3, ?4)", id,
                       static_cast<int64_t>(i), session.header[i].key, session.header[i].value));
  }
  for (size_t i = 0; i < session.columns.size(); ++i) {
    RETURN_IF_ERROR(
        connection.Run("INSERT INTO session_column (session_id, position, name, is_text) VALUES (?1, ?2, ?3, ?4)", id,
                       static_cast<int64_t>(i), session.columns[i].name, session.columns[i].is_text));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> HashChunks(Connection& connection, SessionId id) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT crc32c FROM chunk WHERE session_id = ?1 ORDER BY seq", id));
  std::vector<uint32_t> crcs;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return session::SessionHash(crcs);
    crcs.push_back(static_cast<uint32_t>(row.Int(0)));
  }
}

absl::Status CheckTotals(const SessionRecord& session, const std::string& hash, const SessionTotals& totals) {
  if (totals.chunk_count == session.next_seq && totals.reading_count == session.reading_count && totals.hash == hash) {
    return absl::OkStatus();
  }
  const std::string message = absl::StrFormat("%s: totals say %d chunks, %d readings, hash %s; stored are %d, %d, %s",
                                              Place(session.id), totals.chunk_count, totals.reading_count, totals.hash,
                                              session.next_seq, session.reading_count, hash);
  return base::Error(absl::StatusCode::kFailedPrecondition, message,
                     {"TOTALS_MISMATCH", {{"next_seq", std::to_string(session.next_seq)}}});
}

absl::Status GiveUp(Connection& connection, UtcTime now, SessionId id, SessionState state) {
  RETURN_IF_ERROR(connection.Run("DELETE FROM chunk WHERE session_id = ?1", id));
  return connection.Run(
      "UPDATE session SET state = ?2, next_seq = 0, reading_count = 0, closed_at_utc_us = ?3 WHERE id = ?1", id,
      static_cast<int>(state), now);
}

// The session that the same request has made, by whomever it was sent: a session is its machine and content. One that
// was given up, or which the disk has changed, can be sent again.
absl::StatusOr<std::optional<SessionRecord>> FindSame(Connection& connection, const Caller& caller,
                                                      const std::string& body_sha256,
                                                      const std::vector<SessionId>& damaged) {
  if (caller.request_id.empty()) return std::nullopt;
  std::vector<SessionId> same;  // complete ones before open ones
  {
    ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT id, body_sha256, created_by, state FROM session "
                                                   "WHERE request_id = ?1 ORDER BY id",
                                                   caller.request_id));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      const auto state = row.As<SessionState>(3);
      if (std::find(damaged.begin(), damaged.end(), SessionId(row.Int(0))) != damaged.end()) continue;
      if (row.Text(1) != body_sha256) {
        if (row.Text(2) == caller.principal) return RequestIdReused(caller, "session");
      } else if (state == SessionState::kComplete) {
        same.insert(same.begin(), SessionId(row.Int(0)));
      } else if (state == SessionState::kOpen) {
        same.push_back(SessionId(row.Int(0)));
      }
    }
  }
  for (const SessionId id : same) {
    absl::StatusOr<SessionRecord> session = GetSession(connection, id);
    const absl::Status body = session.ok() ? CheckSessionBody(connection, *session) : session.status();
    if (body.ok()) return *std::move(session);
    if (!absl::IsDataLoss(body)) return body;
  }
  return std::nullopt;
}

}  // namespace

absl::StatusOr<SessionRecord> CreateSession(Connection& connection, const Moment& now, const NewSession& session,
                                            const std::vector<SessionId>& damaged) {
  RETURN_IF_ERROR(CheckNew(session));
  const std::string body_sha256 = HashBody(session);
  ASSIGN_OR_RETURN(std::optional<SessionRecord> same, FindSame(connection, session.caller, body_sha256, damaged));
  if (same.has_value()) return *std::move(same);
  ASSIGN_OR_RETURN(const int64_t machine_key, LiveMachineKey(connection, session.machine));
  ASSIGN_OR_RETURN(
      const int64_t number,
      connection.Insert(
          "INSERT INTO session (machine_id, name, instrument, measured_at_utc_us, state, next_seq, reading_count, "
          "created_by, request_id, "
          "body_sha256, created_at_utc_us, last_seen_at_utc_us, last_seen_up_us) "
          "VALUES (?1, ?2, ?3, ?4, 1, 0, 0, ?5, ?6, ?7, ?8, ?8, ?9)",
          machine_key, session.name, session.instrument, session.measured_at, session.caller.principal,
          RequestId(session.caller), body_sha256, now.utc, now.up_us));
  const SessionId id(number);
  RETURN_IF_ERROR(InsertLists(connection, id, session));
  return GetSession(connection, id);
}

absl::StatusOr<SessionRecord> GetSession(Connection& connection, SessionId id) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask(std::string(kSelectSession) + "WHERE s.id = ?1", id));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NotFound("session", "SESSION", std::to_string(id.number()));
  SessionRecord session = ReadSession(row);
  RETURN_IF_ERROR(ReadLists(connection, session));
  if (session.columns.empty()) return DamagedBody(id);  // none was ever stored without
  return session;
}

absl::Status CheckSessionBody(Connection& connection, const SessionRecord& session) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT body_sha256 FROM session WHERE id = ?1", session.id));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (found && row.Text(0) == HashBody(session)) return absl::OkStatus();
  return DamagedBody(session.id);
}

absl::StatusOr<std::vector<ColumnSpec>> GetSessionColumns(Connection& connection, SessionId id) {
  ASSIGN_OR_RETURN(SessionRecord session, GetSession(connection, id));
  return std::move(session.columns);
}

absl::StatusOr<Page<SessionRecord>> ListSessions(Connection& connection, const SessionFilter& filter,
                                                 const PageRequest& request, const Visible& visible) {
  const int state = filter.state.has_value() ? static_cast<int>(*filter.state) : 0;
  const std::string machine = filter.machine.has_value() ? filter.machine->text() : "";
  std::string list = absl::StrCat("sessions|", machine, "|", state);
  const bool is_narrow =
      !filter.measured.is_all() || !filter.instrument.empty() || !filter.name.empty() || !filter.label.empty();
  if (is_narrow) {
    absl::StrAppend(&list, "|", TokenOf(filter.measured), "|", filter.instrument, "|", filter.name, "|", filter.label);
  }
  ASSIGN_OR_RETURN(const PageStart start, StartPageById(request, list));
  std::optional<int64_t> machine_key;
  std::string where = "WHERE s.id < ?1";
  if (filter.machine.has_value()) {
    ASSIGN_OR_RETURN(machine_key, MachineKey(connection, *filter.machine));
    where += " AND s.machine_id = ?2";
  }
  if (filter.state.has_value()) where += " AND s.state = ?3";
  LookedAt looked;
  if (is_narrow) {
    Narrowing narrowing;
    if (!filter.instrument.empty()) narrowing.texts.push_back({"instrument", filter.instrument});
    if (!filter.name.empty()) narrowing.texts.push_back({"name", filter.name});
    narrowing.time = kMeasuredAt;
    narrowing.span = filter.measured;
    if (!filter.label.empty()) {
      ASSIGN_OR_RETURN(narrowing.linked, NewestIds(connection, kWithLabel, std::vector<std::string>{filter.label},
                                                   start.before_id, kMostLookedAt, 0));
    }
    ASSIGN_OR_RETURN(looked,
                     LookAtNarrowest(connection, "session", machine_key, visible, state, start.before_id, narrowing));
    where = HeldTo("s", looked, machine_key.has_value(), state, "coalesce(s.measured_at_utc_us, s.created_at_utc_us)",
                   filter.measured);
    if (!filter.instrument.empty()) where += " AND +s.instrument = ?9";
    if (!filter.name.empty()) where += " AND +s.name = ?10";
    if (!filter.label.empty())
      where += " AND EXISTS (SELECT 1 FROM session_label AS l WHERE l.session_id = s.id AND l.label = ?11)";
  } else if (!visible.everything && !filter.machine.has_value()) {
    ASSIGN_OR_RETURN(
        looked.ids, NewestOfMachines(connection, "session", visible.scopes, state, start.before_id, start.row_limit()));
    where += " AND s.id IN (SELECT value FROM json_each(?5))";
  }
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask(kSelectSession + where + " ORDER BY s.id DESC LIMIT ?4", start.before_id, machine_key,
                                  state, start.row_limit(), looked.ids, filter.measured.from, filter.measured.to,
                                  looked.machines, filter.instrument, filter.name, filter.label));
  Page<SessionRecord> page;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) break;
    page.rows.push_back(ReadSession(row));
  }
  for (SessionRecord& session : page.rows) RETURN_IF_ERROR(ReadLists(connection, session));
  EndPage(
      start, [](const SessionRecord& session) { return std::to_string(session.id.number()); },
      [](const SessionRecord& session) {
        size_t bytes = 0;
        for (const session::HeaderEntry& entry : session.header) bytes += entry.key.size() + entry.value.size() + 8;
        for (const ColumnSpec& column : session.columns) bytes += column.name.size() + 8;
        return bytes;
      },
      page);
  GoOnBelow(start, looked.last, page);
  return page;
}

absl::StatusOr<SessionRecord> FinishSession(Connection& connection, UtcTime now, SessionId id,
                                            const SessionTotals& totals) {
  ASSIGN_OR_RETURN(const SessionRecord session, GetSession(connection, id));
  if (session.state == SessionState::kComplete) {
    RETURN_IF_ERROR(CheckTotals(session, session.hash, totals));
    return session;
  }
  if (session.state != SessionState::kOpen) return FailedPrecondition(Place(id) + " was given up", "SESSION_CLOSED");
  ASSIGN_OR_RETURN(const std::string hash, HashChunks(connection, id));
  RETURN_IF_ERROR(CheckTotals(session, hash, totals));
  if (session.reading_count == 0) return FailedPrecondition(Place(id) + " has no readings", "SESSION_EMPTY");
  RETURN_IF_ERROR(
      connection.Run("UPDATE session SET state = 2, hash = ?2, closed_at_utc_us = ?3 WHERE id = ?1", id, hash, now));
  return GetSession(connection, id);
}

absl::StatusOr<SessionRecord> AbortSession(Connection& connection, UtcTime now, SessionId id) {
  ASSIGN_OR_RETURN(const SessionRecord session, GetSession(connection, id));
  if (session.state == SessionState::kComplete) return FailedPrecondition(Place(id) + " is complete", "SESSION_CLOSED");
  if (session.state != SessionState::kOpen) return session;
  RETURN_IF_ERROR(GiveUp(connection, now, id, SessionState::kAborted));
  return GetSession(connection, id);
}

absl::StatusOr<int> ExpireSessions(Connection& connection, const Moment& now, std::chrono::microseconds idle) {
  std::vector<SessionId> left;
  {
    ASSIGN_OR_RETURN(Statement row,
                     connection.Ask("SELECT id FROM session WHERE state = 1 AND last_seen_up_us < ?1 ORDER BY id",
                                    now.up_us - static_cast<int64_t>(idle.count())));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      left.push_back(SessionId(row.Int(0)));
    }
  }
  for (const SessionId id : left) RETURN_IF_ERROR(GiveUp(connection, now.utc, id, SessionState::kExpired));
  return static_cast<int>(left.size());
}

namespace {

// Whether somebody still needs the readings.
absl::StatusOr<bool> IsNeeded(Connection& connection, SessionId id) {
  {
    ASSIGN_OR_RETURN(Statement row,
                     connection.Ask("SELECT 1 FROM calibration_session WHERE session_id = ?1 LIMIT 1", id));
    ASSIGN_OR_RETURN(const bool found, row.Step());
    if (found) return true;
  }
  for (const int state : {1, 2}) {  // queued, running: what it reads is not told to the store
    ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT 1 FROM session AS s CROSS JOIN job AS j ON j.machine_id = "
                                                   "s.machine_id WHERE s.id = ?1 AND j.state = ?2 LIMIT 1",
                                                   id, state));
    ASSIGN_OR_RETURN(const bool found, row.Step());
    if (found) return true;
  }
  return false;
}

}  // namespace

absl::StatusOr<ExpiredReadings> ExpireReadings(Connection& connection, const Moment& now, std::chrono::microseconds age,
                                               SessionId after) {
  constexpr int kMaxSessions = 100;  // a stall of the writer of some milliseconds
  ASSIGN_OR_RETURN(const AgeMark mark, MarkBefore(connection, now, age));
  std::vector<SessionId> old;
  {
    ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT id FROM session INDEXED BY session_by_state WHERE state = 2 "
                                                   "AND id > ?1 AND id <= ?2 ORDER BY id LIMIT ?3",
                                                   after, mark.session_id, kMaxSessions));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      old.push_back(SessionId(row.Int(0)));
    }
  }
  ExpiredReadings expired;
  if (old.size() == kMaxSessions) expired.after = old.back();
  for (const SessionId id : old) {
    ASSIGN_OR_RETURN(const bool is_needed, IsNeeded(connection, id));
    if (is_needed) continue;
    // What was detached leaves as a whole, or comes back as it was.
    ASSIGN_OR_RETURN(const bool is_detached, connection.HasDetached(id));
    if (is_detached) continue;
    std::string was;
    {
      ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT reading_count, hash FROM session WHERE id = ?1", id));
      RETURN_IF_ERROR(row.Step().status());
      was = absl::StrCat("complete, ", row.Int(0), " readings, sha256 ", row.Text(1));
    }
    RETURN_IF_ERROR(
        connection.Run("UPDATE session SET state = 4, hash = NULL, closed_at_utc_us = ?2 WHERE id = ?1", id, now.utc));
    RETURN_IF_ERROR(AuditChange(connection, now.utc, {"axiscald", ""}, "session.expire",
                                absl::StrCat("sessions/", id.number()), was, "expired"));
    ++expired.count;
  }
  return expired;
}

absl::StatusOr<int> DropExpiredChunks(Connection& connection) {
  constexpr int64_t kMaxChunks = 200;  // some megabytes
  int64_t id = 0, next_seq = 0;
  {
    ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT id, next_seq FROM session INDEXED BY session_emptied WHERE "
                                                   "state = 4 AND next_seq > 0 AND id > 0 ORDER BY id LIMIT 1"));
    ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return 0;
    id = row.Int(0);
    next_seq = row.Int(1);
  }
  const int64_t first = std::max<int64_t>(next_seq - kMaxChunks, 0);
  RETURN_IF_ERROR(
      connection.Run("UPDATE session SET next_seq = ?2, reading_count = reading_count - coalesce((SELECT "
                     "sum(reading_count) FROM chunk WHERE session_id = ?1 AND seq >= ?2), 0) WHERE id = ?1",
                     id, first));
  RETURN_IF_ERROR(connection.Run("DELETE FROM chunk WHERE session_id = ?1 AND seq >= ?2", id, first));
  return static_cast<int>(next_seq - first);
}

}  // namespace axiscal::storage
