#include "server/storage/marks.h"

#include "server/storage/audit.h"
#include "server/storage/events.h"
#include "server/storage/machines.h"
#include "server/storage/page_token.h"
#include "server/storage/refusal.h"
#include "server/storage/request.h"

namespace axiscal::storage {
namespace {

constexpr char kSelectMark[] =
    "SELECT k.id, m.name, k.at_utc_us, k.kind, k.note, k.created_by, k.created_at_utc_us, k.withdrawn_by, "
    "k.withdrawn_at_utc_us FROM mark AS k JOIN machine AS m ON m.id = k.machine_id ";

// Clocks of a shop differ by as much: a mark may be so far ahead of ours.
constexpr std::chrono::minutes kAhead(10);

absl::StatusOr<Mark> ReadMark(Connection& connection, const Statement& row) {
  Mark mark;
  mark.id = MarkId(row.Int(0));
  mark.content = {MachineId(row.Text(1)), row.Time(2), row.As<records::MarkKind>(3), {}, row.Text(4)};
  mark.created_by = row.Text(5);
  mark.created_at = row.Time(6);
  mark.withdrawn_by = row.Text(7);
  mark.withdrawn_at = row.OptionalTime(8);
  ASSIGN_OR_RETURN(Statement symbol,
                   connection.Ask("SELECT symbol FROM mark_symbol WHERE mark_id = ?1 ORDER BY position", mark.id));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, symbol.Step());
    if (!more) return mark;
    mark.content.symbols.push_back(symbol.Text(0));
  }
}

std::string HashOf(const NewMark& mark) {
  BodyHash hash;
  hash.Add("mark 1").Add(mark.machine.text()).Add(base::ToUtcUs(mark.at)).Add(static_cast<int64_t>(mark.kind));
  hash.Add(mark.note).Add(static_cast<int64_t>(mark.symbols.size()));
  for (const std::string& symbol : mark.symbols) hash.Add(symbol);
  return hash.Hex();
}

std::string NameOf(records::MarkKind kind) {
  switch (kind) {
    case records::MarkKind::kCollision:
      return "collision";
    case records::MarkKind::kService:
      return "service";
    case records::MarkKind::kRefixturing:
      return "re-fixturing";
  }
  return "";
}

}  // namespace

absl::StatusOr<Mark> PutMark(Connection& connection, UtcTime now, const NewMark& mark, const Caller& caller) {
  const std::string body = HashOf(mark);
  ASSIGN_OR_RETURN(const std::optional<int64_t> present, FindRequest(connection, "mark", caller, body));
  if (present) return GetMark(connection, MarkId(*present));
  if (base::ToUtcUs(mark.at) < 0 || mark.at > now + kAhead)
    return InvalidArgument("the time of a mark must lie between 1970 and now", "MARK_INVALID");
  ASSIGN_OR_RETURN(const int64_t machine_key, LiveMachineKey(connection, mark.machine));
  ASSIGN_OR_RETURN(
      const int64_t number,
      connection.Insert("INSERT INTO mark (machine_id, at_utc_us, kind, note, created_by, request_id, body_sha256, "
                        "created_at_utc_us) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
                        machine_key, mark.at, static_cast<int>(mark.kind), mark.note, caller.principal,
                        RequestId(caller), body, now));
  const MarkId id(number);
  for (size_t i = 0; i < mark.symbols.size(); ++i) {
    RETURN_IF_ERROR(connection.Run("INSERT INTO mark_symbol (mark_id, position, symbol) VALUES (?1, ?2, ?3)", id,
                                   static_cast<int64_t>(i), mark.symbols[i]));
  }
  RETURN_IF_ERROR(NoteChange(connection, machine_key));
  RETURN_IF_ERROR(AuditChange(connection, now, caller, "mark.put", absl::StrCat("marks/", id.number()), "",
                              absl::StrCat(NameOf(mark.kind), " of machines/", mark.machine.text())));
  return GetMark(connection, id);
}

absl::StatusOr<Mark> GetMark(Connection& connection, MarkId id) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask(std::string(kSelectMark) + "WHERE k.id = ?1", id));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NotFound("mark", "MARK", std::to_string(id.number()));
  return ReadMark(connection, row);
}

absl::StatusOr<Mark> WithdrawMark(Connection& connection, UtcTime now, MarkId id, const Caller& caller) {
  ASSIGN_OR_RETURN(const Mark present, GetMark(connection, id));
  if (present.withdrawn_at) return present;
  RETURN_IF_ERROR(connection.Run("UPDATE mark SET withdrawn_by = ?2, withdrawn_at_utc_us = ?3 WHERE id = ?1", id,
                                 caller.principal, now));
  ASSIGN_OR_RETURN(const int64_t machine_key, MachineKey(connection, present.content.machine));
  RETURN_IF_ERROR(NoteChange(connection, machine_key));
  RETURN_IF_ERROR(AuditChange(connection, now, caller, "mark.withdraw", absl::StrCat("marks/", id.number()),
                              NameOf(present.content.kind), "withdrawn"));
  return GetMark(connection, id);
}

absl::StatusOr<Page<Mark>> ListMarks(Connection& connection, const MachineId& machine, const PageRequest& request) {
  ASSIGN_OR_RETURN(const PageStart start, StartPageById(request, "marks|" + machine.text()));
  ASSIGN_OR_RETURN(const int64_t machine_key, MachineKey(connection, machine));
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask(std::string(kSelectMark) + "WHERE k.machine_id = ?2 AND k.id < ?1 ORDER BY k.id DESC LIMIT ?3",
                     start.before_id, machine_key, start.row_limit()));
  Page<Mark> page;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) break;
    ASSIGN_OR_RETURN(Mark mark, ReadMark(connection, row));
    page.rows.push_back(std::move(mark));
  }
  EndPage(
      start, [](const Mark& mark) { return std::to_string(mark.id.number()); },
      [](const Mark& mark) {
        size_t bytes = mark.content.note.size();
        for (const std::string& symbol : mark.content.symbols) bytes += symbol.size() + 2;
        return bytes;
      },
      page);
  return page;
}

}  // namespace axiscal::storage
