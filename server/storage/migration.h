// The steps that brought a database to the schema of this program, as built into it; a table of the database itself
// says which of them it has seen.
#ifndef AXISCAL_SERVER_STORAGE_MIGRATION_H_
#define AXISCAL_SERVER_STORAGE_MIGRATION_H_

#include <string>
#include <vector>

#include "server/storage/connection.h"

namespace axiscal::storage {

struct Migration {
  int version = 0;  // rising
  std::string name;
  std::string sql;
};

// migrations/*.sql: of SQLite, 1, 2, ...
const std::vector<Migration>& EmbeddedMigrations();
// migrations/postgresql/*.sql: the first one makes all that SQLite has by the migration of the same number.
const std::vector<Migration>& PostgresMigrations();

// The oldest version of the program, told by the number of its last migration, that may run on a database that has seen
// this one: N of "-- oldest program: N", the first line of its text; its own number where that says nothing.
int OldestProgram(const Migration& migration);

// Whether a database at schema `version` is one that these migrations have made, as far as it is.
//   FAILED_PRECONDITION SCHEMA_NEWER (written by a newer program), SCHEMA_CHANGED (one that it has seen differs).
absl::Status CheckMigrations(Connection& connection, const std::vector<Migration>& migrations, int64_t version);
// Remembers in the database that it has seen this one.
absl::Status NoteMigration(Connection& connection, const Migration& migration, base::UtcTime now);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_MIGRATION_H_
