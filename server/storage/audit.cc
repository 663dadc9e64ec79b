#include "server/storage/audit.h"

#include "server/storage/page_token.h"

namespace axiscal::storage {

absl::Status AppendAudit(Connection& connection, const AuditEntry& entry) {
  return connection.Run(
      "INSERT INTO audit (at_utc_us, principal, action, resource, outcome, detail) VALUES (?1, ?2, ?3, ?4, ?5, ?6)",
      entry.at, entry.principal, entry.action, entry.resource, entry.outcome, entry.detail);
}

absl::Status AuditChange(Connection& connection, UtcTime now, const Caller& caller, const std::string& action,
                         const std::string& resource) {
  const std::string detail = caller.request_id.empty() ? "" : "request_id " + caller.request_id;
  return AppendAudit(connection, {now, caller.principal, action, resource, "OK", detail});
}

absl::StatusOr<Page<AuditEntry>> ListAudit(Connection& connection, const PageRequest& request) {
  ASSIGN_OR_RETURN(const PageStart start, StartPageById(request, "audit"));
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT id, at_utc_us, principal, action, resource, outcome, detail FROM audit "
                                  "WHERE id < ?1 ORDER BY id DESC LIMIT ?2",
                                  start.before_id, start.row_limit()));
  Page<AuditEntry> page;
  int64_t last_id = 0;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return page;
    if (page.rows.size() == static_cast<size_t>(start.size)) {
      page.next_token = MakePageToken(start, std::to_string(last_id));
      return page;
    }
    last_id = row.Int(0);
    page.rows.push_back({row.Time(1), row.Text(2), row.Text(3), row.Text(4), row.Text(5), row.Text(6)});
  }
}

}  // namespace axiscal::storage
