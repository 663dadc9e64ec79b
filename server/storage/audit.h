// The append-only list of who changed what, and of what was denied. Each row has a hash over its text and the hash of
// the row before: a row that was changed, taken out or put in is found. Retention removes the oldest rows only; the
// last one's hash stays as the anchor that the chain begins with, and is told by an entry of the chain itself.
#ifndef AXISCAL_SERVER_STORAGE_AUDIT_H_
#define AXISCAL_SERVER_STORAGE_AUDIT_H_

#include <chrono>
#include <string>

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// `entry.id` is given by it.
absl::Status AppendAudit(Connection& connection, const AuditEntry& entry);
// A change that succeeds with the transaction it is part of: what was there before it, and what is there after it.
absl::Status AuditChange(Connection& connection, UtcTime now, const Caller& caller, const std::string& action,
                         const std::string& resource, const std::string& was = "", const std::string& became = "");
// The caller's reason in the `detail` of such an entry; empty: none was given.
std::string ReasonIn(const std::string& detail);
// Newest first. In the place of an entry that is not what was written stands "damaged", with its number and moment.
absl::StatusOr<Page<AuditEntry>> ListAudit(Connection& connection, const AuditFilter& filter,
                                           const PageRequest& request);
// The last row and its hash. DATA_LOSS AUDIT_DAMAGED (fact audit) names the first row that is not what was written, or
// after which one is missing.
absl::StatusOr<AuditHead> CheckAudit(Connection& connection);
// Removes the oldest rows of at least this age of up time, some at a time. How many: 0 when there are none.
absl::StatusOr<int> ExpireAudit(Connection& connection, const Moment& now, std::chrono::microseconds age);
// Gives their hashes to rows of a file that an older version has written: once. Within a transaction.
absl::Status ChainOldAudit(Connection& connection);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_AUDIT_H_
