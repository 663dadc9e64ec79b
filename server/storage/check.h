// Whether a database holds what was written into it: its structure, its references, and the checksums of readings,
// programs, jobs, descriptions, calibrations and the audit.
#ifndef AXISCAL_SERVER_STORAGE_CHECK_H_
#define AXISCAL_SERVER_STORAGE_CHECK_H_

#include <functional>
#include <string>

#include "server/storage/records.h"
#include "server/storage/sqlite_connection.h"

namespace axiscal::storage {

// Looks at everything, in one consistent state, however much of it is damaged. Takes about as long as reading the whole
// file. `go_on`, which may be empty, is asked now and then: its error ends the look, and is returned. Other errors only
// where nothing can be read at all.
absl::StatusOr<CheckReport> CheckStore(SqliteConnection& connection,
                                       const std::function<absl::Status()>& go_on = nullptr);

// The same of the rows alone, on any engine: whether they are what their checksums say.
CheckReport CheckRows(Connection& connection);

// CheckStore() of a file that no server has, which is left as it was; only a log that a crash has left is merged into
// it.
//   UNAVAILABLE STORE_LOCKED, NOT_FOUND (no such file), FAILED_PRECONDITION SCHEMA_NEWER, NOT_A_DATABASE. Of a file of
//   an older schema only structure and references are compared.
absl::StatusOr<CheckReport> CheckStoreFile(const std::string& path);

// The same of a database of PostgreSQL, which is only read, in one snapshot: axiscald may work on it meanwhile. Of the
// structure it compares what a server tells of it (postgres_check.h); the server's own programs look at pages.
//   UNAVAILABLE STORE_DOWN, also where the connection is lost on the way; FAILED_PRECONDITION NOT_A_DATABASE,
//   SCHEMA_NEWER, SCHEMA_CHANGED. Of an older schema only the references are looked at.
absl::StatusOr<CheckReport> CheckStoreOnServer(const std::string& url);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_CHECK_H_
