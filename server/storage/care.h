// What there is to say of each machine at a glance. Database::ListCare has what it returns.
#ifndef AXISCAL_SERVER_STORAGE_CARE_H_
#define AXISCAL_SERVER_STORAGE_CARE_H_

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// A page has at most as many machines as it is asked for, and ends early where there is much to say. `now` tells which
// events are still on the shelf.
absl::StatusOr<Page<MachineCare>> ListCare(Connection& connection, UtcTime now, const PageRequest& request,
                                           const Visible& visible);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_CARE_H_
