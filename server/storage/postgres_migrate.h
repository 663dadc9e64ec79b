// Brings a database of PostgreSQL to the schema of this program. Forward only: each migration is one transaction,
// remembered with its checksum and the oldest program that may run on it.
#ifndef AXISCAL_SERVER_STORAGE_POSTGRES_MIGRATE_H_
#define AXISCAL_SERVER_STORAGE_POSTGRES_MIGRATE_H_

#include <vector>

#include "server/storage/migration.h"

namespace axiscal::storage {

enum class NewerSchema {
  kRefused,
  kRunOn,  // where all that it has seen lets this program run (OldestProgram()); else refused
};

// Applies what is missing, all of it where the schema is empty. `connection` writes; of several that share the store
// one applies it, the others wait. On failure the database stays at the last migration that succeeded. A newer schema
// is left as it is.
//   FAILED_PRECONDITION NOT_A_DATABASE: the schema holds something else, or texts are not kept as UTF-8; SCHEMA_NEWER,
//   SCHEMA_CHANGED as CheckMigrations().
//   UNAVAILABLE STORE_LOCKED: others have the store, and what is missing does not let all of them run.
absl::Status MigratePostgres(Connection& connection, const std::vector<Migration>& migrations, base::UtcTime now,
                             NewerSchema newer = NewerSchema::kRefused);

// Whether a program of these migrations, the last of which it has seen applied, may still run on the database: others
// may have been at it while it had lost its connection. Changes nothing.
//   FAILED_PRECONDITION NOT_A_DATABASE, SCHEMA_NEWER, SCHEMA_CHANGED as MigratePostgres(); SCHEMA_OLDER: it lacks some,
//   as an older backup does, which a program that starts applies.
absl::Status CheckPostgresSchema(Connection& connection, const std::vector<Migration>& migrations);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_POSTGRES_MIGRATE_H_
