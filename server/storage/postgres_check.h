// Whether the tables of a database of PostgreSQL are those that the migrations made, and its rows name rows that are
// there: what a server does not look at again once it has said yes.
#ifndef AXISCAL_SERVER_STORAGE_POSTGRES_CHECK_H_
#define AXISCAL_SERVER_STORAGE_POSTGRES_CHECK_H_

#include <functional>
#include <string>

#include "server/storage/migration.h"

namespace axiscal::storage {

// Told each damage: of what ("schema", "file"), and what it is.
using NoteDamage = std::function<void(const std::string&, const std::string&)>;

// Tables, indexes, triggers and functions by their names: none is missing or more, each is on its table, valid and
// switched on, and a function's text stands in the migrations. (What a server writes of conditions in its own words is
// not compared.)
absl::Status CheckPostgresObjects(Connection& connection, const std::vector<Migration>& migrations,
                                  const NoteDamage& tell);
// Rows whose foreign keys name no row: made past the triggers, or by a damaged index.
absl::Status CheckPostgresReferences(Connection& connection, const NoteDamage& tell);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_POSTGRES_CHECK_H_
