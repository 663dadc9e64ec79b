// What putting a backup in a database's place has undone that somebody counts on: rights that were taken away meanwhile
// are there again, calibrations that were put in use or retired are not.
#ifndef AXISCAL_SERVER_STORAGE_UNDONE_H_
#define AXISCAL_SERVER_STORAGE_UNDONE_H_

#include <string>
#include <vector>

#include "core/base/status.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// Of the entries that the audit of `kept` has beyond that of `restored`, those that took rights away (principals and
// tokens that were revoked, roles, groups, four eyes), changed what is in use or what it rests on (calibrations, tables
// that were handed out, sessions that were rejected, machines), webhooks and routines; oldest first, the texts of what
// was and became left out. Nothing where one has no chain yet. Both are files that no server has. FAILED_PRECONDITION
// (NO_EARLIER_STATE) where both have a chain and `restored` is no earlier state of `kept`, or that is older than what
// `kept` keeps; the errors of a file that cannot be read.
absl::StatusOr<std::vector<AuditEntry>> UndoneByRestore(const std::string& kept, const std::string& restored);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_UNDONE_H_
