#include "server/storage/migration.h"

#include <algorithm>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "core/base/sha256.h"
#include "server/storage/refusal.h"

namespace axiscal::storage {

int OldestProgram(const Migration& migration) {
  constexpr absl::string_view kStated = "-- oldest program: ";
  const absl::string_view first = absl::string_view(migration.sql).substr(0, migration.sql.find('\n'));
  int number = 0;
  if (!absl::StartsWith(first, kStated) || !absl::SimpleAtoi(first.substr(kStated.size()), &number))
    return migration.version;
  return std::min(number, migration.version);
}

absl::Status CheckMigrations(Connection& connection, const std::vector<Migration>& migrations, int64_t version) {
  const int ours = migrations.empty() ? 0 : migrations.back().version;
  if (version > ours) {
    return FailedPrecondition(
        absl::StrCat("schema version ", version, " is newer than this program, which knows version ", ours),
        "SCHEMA_NEWER");
  }
  for (const Migration& migration : migrations) {
    ASSIGN_OR_RETURN(Statement row,
                     connection.Ask("SELECT sha256 FROM migration WHERE version = ?1", migration.version));
    ASSIGN_OR_RETURN(const bool applied, row.Step());
    if (applied && row.Text(0) != base::Sha256Hex(migration.sql)) {
      return FailedPrecondition(absl::StrCat("migration ", migration.name, " is not the one that made this database"),
                                "SCHEMA_CHANGED");
    }
  }
  return absl::OkStatus();
}

absl::Status NoteMigration(Connection& connection, const Migration& migration, base::UtcTime now) {
  return connection.Run("INSERT INTO migration (version, name, sha256, applied_at_utc_us) VALUES (?1, ?2, ?3, ?4)",
                        migration.version, migration.name, base::Sha256Hex(migration.sql), now);
}

}  // namespace axiscal::storage
