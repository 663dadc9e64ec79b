// The append-only list of who changed what.
#ifndef AXISCAL_SERVER_STORAGE_AUDIT_H_
#define AXISCAL_SERVER_STORAGE_AUDIT_H_

#include <string>

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

absl::Status AppendAudit(Connection& connection, const AuditEntry& entry);
// A change that succeeds with the transaction it is part of.
absl::Status AuditChange(Connection& connection, UtcTime now, const Caller& caller, const std::string& action,
                         const std::string& resource);
absl::StatusOr<Page<AuditEntry>> ListAudit(Connection& connection, const PageRequest& request);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_AUDIT_H_
