// PostgreSQL's errors as the statuses that database.h promises.
#ifndef AXISCAL_SERVER_STORAGE_POSTGRES_ERROR_H_
#define AXISCAL_SERVER_STORAGE_POSTGRES_ERROR_H_

#include <string>

#include "absl/status/status.h"

namespace axiscal::storage {

// `sqlstate` (docs of PostgreSQL, appendix A): five characters; empty where the connection was lost or never made.
// `message` is the server's or libpq's, met while doing `what`.
absl::Status PostgresError(const std::string& sqlstate, const std::string& message, const std::string& what);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_POSTGRES_ERROR_H_
