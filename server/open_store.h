// The store that a server works on.
#ifndef AXISCAL_SERVER_OPEN_STORE_H_
#define AXISCAL_SERVER_OPEN_STORE_H_

#include <memory>
#include <string>

#include "core/base/status.h"
#include "server/storage/database.h"

namespace axiscal::server {

// `database`: a SQLite file, or a URL of PostgreSQL. What the store tells goes into the log. The store's errors.
absl::StatusOr<std::unique_ptr<storage::Database>> OpenStore(const std::string& database);

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_OPEN_STORE_H_
