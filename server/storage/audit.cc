#include "server/storage/audit.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "server/storage/page_token.h"
#include "server/storage/refusal.h"
#include "server/storage/request.h"
#include "server/storage/up_time.h"

namespace axiscal::storage {
namespace {

// What retention has removed.
constexpr char kExpireAction[] = "audit.expire";
constexpr char kReason[] = "reason: ";  // before what the caller said
constexpr char kAuditColumns[] =
    "a.id, a.at_utc_us, a.principal, a.peer, a.action, a.resource, a.outcome, a.was, a.became, "
    "a.detail";

AuditEntry ReadEntry(const Statement& row) {
  return {row.Int(0),  row.Time(1), row.Text(2), row.Text(3), row.Text(4),
          row.Text(5), row.Text(6), row.Text(7), row.Text(8), row.Text(9)};
}

std::string HashOf(const AuditEntry& entry, const std::string& before) {
  BodyHash hash;
  hash.Add("audit 1").Add(before).Add(entry.id).Add(base::ToUtcUs(entry.at)).Add(entry.principal).Add(entry.peer);
  hash.Add(entry.action).Add(entry.resource).Add(entry.outcome).Add(entry.was).Add(entry.became).Add(entry.detail);
  return hash.Hex();
}

absl::Status Damaged(int64_t id, const std::string& what) {
  return base::Error(absl::StatusCode::kDataLoss, absl::StrCat("audit entry ", id, ": ", what),
                     {"AUDIT_DAMAGED", {{"audit", std::to_string(id)}}});
}

struct Anchor {
  AuditHead head;  // the last row that was removed
  bool is_chained = false;
};

absl::StatusOr<Anchor> ReadAnchor(Connection& connection) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT audit_id, sha256, is_chained FROM audit_anchor WHERE id = 1"));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return Damaged(1, "the chain has no anchor");
  return Anchor{{row.Int(0), row.Text(1)}, row.Bool(2)};
}

// A row together with the link that it was given and the one of the row before, as they are joined by kLinks.
constexpr char kLinks[] =
    " FROM audit AS a LEFT JOIN audit_chain AS c ON c.audit_id = a.id "
    "LEFT JOIN audit_chain AS p ON p.audit_id = a.id - 1";

// What a row of a list says: what was written, or that it is damaged and nothing else. Its moment stays, by which lists
// are ordered.
AuditEntry ShownEntry(const Statement& row, const Anchor& anchor) {
  const AuditEntry entry = ReadEntry(row);
  const std::string link = row.IsNull(10) ? "" : row.Text(10);
  std::string before = row.IsNull(11) ? "" : row.Text(11);
  if (row.IsNull(11) && entry.id == anchor.head.id + 1) before = anchor.head.sha256;
  if (link == HashOf(entry, before)) return entry;
  AuditEntry shown;
  shown.id = entry.id;
  shown.at = entry.at;
  shown.action = "damaged";
  shown.resource = absl::StrCat("audit/", entry.id);
  shown.outcome = absl::StatusCodeToString(absl::StatusCode::kDataLoss);
  shown.detail = "AUDIT_DAMAGED: this entry is not what was written, or the one before it is missing; it is not shown";
  return shown;
}

// As the entry of its removal says it.
std::string TextOf(const AuditHead& anchor) {
  return absl::StrCat("entry ", anchor.id, " had the hash ", anchor.sha256);
}

// The last link, or what the chain begins with.
absl::StatusOr<AuditHead> LastLink(Connection& connection) {
  {
    ASSIGN_OR_RETURN(
        Statement row,
        connection.Ask("SELECT audit_id, sha256 FROM audit_chain WHERE audit_id > 0 ORDER BY audit_id DESC LIMIT 1"));
    ASSIGN_OR_RETURN(const bool found, row.Step());
    if (found) return AuditHead{row.Int(0), row.Text(1)};
  }
  ASSIGN_OR_RETURN(const Anchor anchor, ReadAnchor(connection));
  return anchor.head;
}

absl::Status AddLink(Connection& connection, const AuditEntry& entry, AuditHead& head) {
  head = {entry.id, HashOf(entry, head.sha256)};
  return connection.Run("INSERT INTO audit_chain (audit_id, sha256) VALUES (?1, ?2)", head.id, head.sha256);
}

// The greatest id that was ever given.
absl::StatusOr<int64_t> LastId(Connection& connection) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT seq FROM sqlite_sequence WHERE name = 'audit'"));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  return found ? row.Int(0) : 0;
}

}  // namespace

absl::Status AppendAudit(Connection& connection, const AuditEntry& given) {
  AuditEntry entry = given;
  ASSIGN_OR_RETURN(entry.id,
                   connection.Insert(
                       "INSERT INTO audit (at_utc_us, principal, peer, action, resource, outcome, was, became, detail) "
                       "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)",
                       given.at, given.principal, given.peer, given.action, given.resource, given.outcome, given.was,
                       given.became, given.detail));
  ASSIGN_OR_RETURN(AuditHead head, LastLink(connection));
  return AddLink(connection, entry, head);
}

absl::Status AuditChange(Connection& connection, UtcTime now, const Caller& caller, const std::string& action,
                         const std::string& resource, const std::string& was, const std::string& became) {
  std::string detail = caller.request_id.empty() ? "" : "request_id " + caller.request_id;
  if (!caller.reason.empty()) absl::StrAppend(&detail, detail.empty() ? "" : "; ", kReason, caller.reason);
  return AppendAudit(connection, {0, now, caller.principal, caller.peer, action, resource, "OK", was, became, detail});
}

std::string ReasonIn(const std::string& detail) {
  const size_t at = absl::StartsWith(detail, kReason) ? 0 : detail.find(absl::StrCat("; ", kReason));
  return at == std::string::npos ? "" : detail.substr(detail.find(kReason, at) + std::strlen(kReason));
}

absl::StatusOr<Page<AuditEntry>> ListAudit(Connection& connection, const AuditFilter& filter,
                                           const PageRequest& request) {
  const int64_t from = filter.from ? base::ToUtcUs(*filter.from) : std::numeric_limits<int64_t>::min();
  const int64_t to = filter.to ? base::ToUtcUs(*filter.to) : std::numeric_limits<int64_t>::max();
  const bool is_of_actions = !filter.actions[0].empty() || !filter.actions[1].empty();
  std::string list = absl::StrCat("audit|", filter.principal, "|", filter.resource, "|", from, "|", to);
  if (is_of_actions) absl::StrAppend(&list, "|", filter.actions[0], "|", filter.actions[1]);
  ASSIGN_OR_RETURN(const PageStart start, StartPage(request, list));
  int64_t before_at = to, before_id = 0;
  if (start.after) {
    const std::vector<std::string> key = absl::StrSplit(*start.after, ' ');
    if (key.size() != 2 || !absl::SimpleAtoi(key[0], &before_at) || !absl::SimpleAtoi(key[1], &before_id))
      return InvalidArgument("page_token: is not one that a list has given", "PAGE_INVALID");
  }
  ASSIGN_OR_RETURN(const Anchor anchor, ReadAnchor(connection));
  std::string sql = absl::StrCat("SELECT ", kAuditColumns, ", c.sha256, p.sha256", kLinks,
                                 " WHERE (a.at_utc_us, a.id) < (?1, ?2) AND a.at_utc_us >= ?3");
  if (!filter.principal.empty()) sql += " AND a.principal = ?4";
  if (!filter.resource.empty()) sql += " AND a.resource = ?5";
  if (is_of_actions) sql += " AND a.action IN (?7, ?8)";
  ASSIGN_OR_RETURN(Statement row, connection.Ask(sql + " ORDER BY a.at_utc_us DESC, a.id DESC LIMIT ?6", before_at,
                                                 before_id, from, filter.principal, filter.resource, start.row_limit(),
                                                 filter.actions[0], filter.actions[1]));
  Page<AuditEntry> page;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) break;
    page.rows.push_back(ShownEntry(row, anchor));
  }
  EndPage(
      start, [](const AuditEntry& entry) { return absl::StrCat(base::ToUtcUs(entry.at), " ", entry.id); },
      [](const AuditEntry& entry) {
        return entry.principal.size() + entry.peer.size() + entry.action.size() + entry.resource.size() +
               entry.was.size() + entry.became.size() + entry.detail.size();
      },
      page);
  return page;
}

absl::StatusOr<AuditHead> CheckAudit(Connection& connection) {
  ASSIGN_OR_RETURN(const Anchor anchor, ReadAnchor(connection));
  AuditHead head = anchor.head;
  std::string removed;
  {
    ASSIGN_OR_RETURN(Statement row, connection.Ask(absl::StrCat("SELECT ", kAuditColumns,
                                                                ", c.sha256 FROM audit AS a LEFT JOIN audit_chain AS c "
                                                                "ON c.audit_id = a.id ORDER BY a.id")));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      const AuditEntry entry = ReadEntry(row);
      if (entry.id <= anchor.head.id) return Damaged(entry.id, "is there, though the anchor says that it was removed");
      if (entry.id != head.id + 1) return Damaged(head.id + 1, "is missing");
      if (row.IsNull(10) || row.Text(10) != HashOf(entry, head.sha256))
        return Damaged(entry.id, "is not what was written");
      head = {entry.id, row.Text(10)};
      if (entry.action == kExpireAction) removed = entry.became;
    }
  }
  ASSIGN_OR_RETURN(const AuditHead last, LastLink(connection));
  ASSIGN_OR_RETURN(const int64_t last_id, LastId(connection));
  if (last.id != head.id || last_id != head.id) return Damaged(head.id + 1, "is missing");
  if (anchor.head.id > 0 && removed != TextOf(anchor.head))
    return Damaged(anchor.head.id, "was not removed by retention: no entry says so");
  return head;
}

absl::Status ChainOldAudit(Connection& connection) {
  ASSIGN_OR_RETURN(const Anchor anchor, ReadAnchor(connection));
  if (anchor.is_chained) return absl::OkStatus();
  AuditHead head;
  while (true) {
    AuditEntry entry;
    {
      ASSIGN_OR_RETURN(Statement row,
                       connection.Ask(absl::StrCat("SELECT ", kAuditColumns,
                                                   " FROM audit AS a WHERE a.id > ?1 ORDER BY a.id LIMIT 1"),
                                      head.id));
      ASSIGN_OR_RETURN(const bool found, row.Step());
      if (!found) break;
      entry = ReadEntry(row);
    }
    RETURN_IF_ERROR(AddLink(connection, entry, head));
  }
  return connection.Run("UPDATE audit_anchor SET is_chained = 1 WHERE id = 1");
}

absl::StatusOr<int> ExpireAudit(Connection& connection, const Moment& now, std::chrono::microseconds age) {
  // A stall of the writer of some milliseconds.
  constexpr int64_t kMaxRows = 1000;
  ASSIGN_OR_RETURN(const AgeMark mark, MarkBefore(connection, now, age));
  ASSIGN_OR_RETURN(const Anchor anchor, ReadAnchor(connection));
  const int64_t last = std::min(mark.audit_id, anchor.head.id + kMaxRows);
  if (last <= anchor.head.id) return 0;
  AuditHead removed;
  {
    ASSIGN_OR_RETURN(Statement row,
                     connection.Ask("SELECT audit_id, sha256 FROM audit_chain WHERE audit_id = ?1", last));
    ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return Damaged(last, "is missing");
    removed = {row.Int(0), row.Text(1)};
  }
  RETURN_IF_ERROR(
      connection.Run("UPDATE audit_anchor SET audit_id = ?1, sha256 = ?2 WHERE id = 1", removed.id, removed.sha256));
  RETURN_IF_ERROR(connection.Run("DELETE FROM audit_chain WHERE audit_id <= ?1", last));
  RETURN_IF_ERROR(connection.Run("DELETE FROM audit WHERE id <= ?1", last));
  RETURN_IF_ERROR(
      AppendAudit(connection, {0, now.utc, "axiscald", "", kExpireAction, "audit", "OK",
                               absl::StrCat("entries ", anchor.head.id + 1, " to ", last), TextOf(removed), ""}));
  return static_cast<int>(last - anchor.head.id);
}

}  // namespace axiscal::storage
