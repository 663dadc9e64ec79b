// Brings a database file to the schema of this program. Forward only: each migration is one transaction, remembered
// with its checksum.
#ifndef AXISCAL_SERVER_STORAGE_MIGRATE_H_
#define AXISCAL_SERVER_STORAGE_MIGRATE_H_

#include <string>
#include <vector>

#include "server/storage/file_lock.h"
#include "server/storage/migration.h"
#include "server/storage/sqlite_connection.h"

namespace axiscal::storage {

// "Axis" in the file's header: PRAGMA application_id.
inline constexpr int kApplicationId = 0x41786973;

// Whether the file at `path` is one that Migrate() may touch; only reads. A missing or empty file is.
//   FAILED_PRECONDITION SCHEMA_NEWER (written by a newer program), NOT_A_DATABASE (something else), SCHEMA_CHANGED (a
//   migration it has seen differs from ours).
absl::Status CheckFile(const std::string& path, const std::vector<Migration>& migrations);

// The file at `path`, locked and found to be one that Migrate() may touch. The errors of FileLock::Take() and of
// CheckFile().
absl::StatusOr<FileLock> LockStoreFile(const std::string& path, const std::vector<Migration>& migrations);

// Applies what is missing. On failure the file stays at the last migration that succeeded.
absl::Status Migrate(SqliteConnection& connection, const std::vector<Migration>& migrations, base::UtcTime now);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_MIGRATE_H_
