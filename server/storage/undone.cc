#include "server/storage/undone.h"

#include <memory>
#include <optional>

#include "core/base/error_detail.h"
#include "server/storage/sqlite_connection.h"

namespace axiscal::storage {
namespace {

// The hash of an entry of the chain; nothing where there is none.
absl::StatusOr<std::optional<std::string>> HashOfEntry(SqliteConnection& connection, int64_t id) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT sha256 FROM audit_chain WHERE audit_id = ?1", id));
  ASSIGN_OR_RETURN(const bool is_there, row.Step());
  if (!is_there) return std::nullopt;
  return row.Text(0);
}

}  // namespace

absl::StatusOr<std::vector<AuditEntry>> UndoneByRestore(const std::string& kept, const std::string& restored) {
  ASSIGN_OR_RETURN(const auto later, SqliteConnection::Open(kept, Access::kReadOnly));
  ASSIGN_OR_RETURN(const auto earlier, SqliteConnection::Open(restored, Access::kReadOnly));
  std::vector<AuditEntry> undone;
  // Older versions have no chain that tells whether both are of one database.
  for (SqliteConnection* const connection : {later.get(), earlier.get()}) {
    ASSIGN_OR_RETURN(const bool has_chain, connection->HasTable("audit_chain"));
    if (!has_chain) return undone;
  }
  ASSIGN_OR_RETURN(Statement last, earlier->Ask("SELECT max(audit_id) FROM audit_chain"));
  ASSIGN_OR_RETURN(const bool has_last, last.Step());
  if (!has_last || last.IsNull(0)) return undone;
  const int64_t last_id = last.Int(0);
  ASSIGN_OR_RETURN(const std::optional<std::string> ours, HashOfEntry(*earlier, last_id));
  ASSIGN_OR_RETURN(const std::optional<std::string> theirs, HashOfEntry(*later, last_id));
  if (!ours || ours != theirs) {
    return base::Error(absl::StatusCode::kFailedPrecondition,
                       restored + " is no earlier state of " + kept + ": their chains of audit entries are not one",
                       {"NO_EARLIER_STATE", {}});
  }
  ASSIGN_OR_RETURN(Statement row,
                   later->Ask("SELECT id, at_utc_us, principal, action, resource FROM audit WHERE id > ?1 AND action IN"
                              " ('principal.revoke', 'token.revoke', 'role.take', 'group.add', 'group.remove',"
                              " 'machine.four_eyes_on', 'machine.update', 'machine.delete', 'calibration.approve',"
                              " 'calibration.retire', 'table.make', 'session.reject', 'webhook.put', 'webhook.remove',"
                              " 'routine.stop', 'routine.remove') ORDER BY id",
                              last_id));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return undone;
    AuditEntry entry;
    entry.id = row.Int(0);
    entry.at = base::FromUtcUs(row.Int(1));
    entry.principal = row.Text(2);
    entry.action = row.Text(3);
    entry.resource = row.Text(4);
    undone.push_back(entry);
  }
}

}  // namespace axiscal::storage
