// What a user calls a database: a file, or a URL of PostgreSQL.
#ifndef AXISCAL_SERVER_STORAGE_POSTGRES_URL_H_
#define AXISCAL_SERVER_STORAGE_POSTGRES_URL_H_

#include <string>

namespace axiscal::storage {

// "postgresql://..." or "postgres://...".
bool IsPostgresUrl(const std::string& database);
// For logs: with "***" in place of a password. A file's name as it is.
std::string WithoutPassword(const std::string& database);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_POSTGRES_URL_H_
