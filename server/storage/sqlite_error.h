// SQLite's result codes as the statuses that database.h promises.
#ifndef AXISCAL_SERVER_STORAGE_SQLITE_ERROR_H_
#define AXISCAL_SERVER_STORAGE_SQLITE_ERROR_H_

#include <sqlite3.h>

#include <string>

#include "absl/status/status.h"

namespace axiscal::storage {

// The last error of `db` (may be null: out of memory), met while doing `what`.
absl::Status SqliteError(sqlite3* db, const std::string& what);

// Of errno: the file may not be written, whoever asks again.
bool IsNotWritable(int system_error);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_SQLITE_ERROR_H_
