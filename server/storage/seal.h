// Checksums for rows that were stored before they had any.
#ifndef AXISCAL_SERVER_STORAGE_SEAL_H_
#define AXISCAL_SERVER_STORAGE_SEAL_H_

#include "server/storage/connection.h"

namespace axiscal::storage {

// Gives every machine revision, calibration and job's result without a checksum its own, as it stands now; all of them
// or, on failure, none. After Migrate(); costs nothing when all have theirs.
absl::Status SealOldRows(Connection& connection);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_SEAL_H_
