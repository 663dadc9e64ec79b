#include "server/storage/postgres_url.h"

#include <algorithm>

namespace axiscal::storage {

bool IsPostgresUrl(const std::string& database) {
  return database.starts_with("postgresql://") || database.starts_with("postgres://");
}

std::string WithoutPassword(const std::string& database) {
  if (!IsPostgresUrl(database)) return database;
  std::string shown = database;
  // postgresql://user:password@host/name?password=...
  const size_t user = shown.find("://") + 3, end = shown.find_first_of("/?", user);
  const size_t at = shown.rfind('@', end == std::string::npos ? end : end - 1);
  const size_t colon = shown.find(':', user);
  if (at != std::string::npos && at > user && colon < at) shown.replace(colon + 1, at - colon - 1, "***");
  // Of the certificate's key too: sslpassword.
  const std::string key = "password=";
  for (size_t found = shown.find(key); found != std::string::npos; found = shown.find(key, found + key.size())) {
    const size_t value = found + key.size();
    shown.replace(value, std::min(shown.find('&', value), shown.size()) - value, "***");
  }
  return shown;
}

}  // namespace axiscal::storage
