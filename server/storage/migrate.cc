#include "server/storage/migrate.h"

#include <sys/stat.h>

#include "core/base/error_detail.h"
#include "core/base/sha256.h"
#include "server/storage/transaction.h"

namespace axiscal::storage {
namespace {

absl::Status Refuse(const std::string& message, const std::string& reason) {
  return base::Error(absl::StatusCode::kFailedPrecondition, message, {reason, {}});
}

absl::StatusOr<int64_t> ReadNumber(Connection& connection, const std::string& sql) {
  ASSIGN_OR_RETURN(Statement statement, connection.Ask(sql));
  RETURN_IF_ERROR(statement.Step().status());
  return statement.Int(0);
}

absl::Status CheckChecksums(Connection& connection, const std::vector<Migration>& migrations) {
  for (const Migration& migration : migrations) {
    ASSIGN_OR_RETURN(Statement row,
                     connection.Ask("SELECT sha256 FROM migration WHERE version = ?1", migration.version));
    ASSIGN_OR_RETURN(const bool applied, row.Step());
    if (applied && row.Text(0) != base::Sha256Hex(migration.sql)) {
      return Refuse(absl::StrCat("migration ", migration.name, " is not the one that made this file"),
                    "SCHEMA_CHANGED");
    }
  }
  return absl::OkStatus();
}

absl::Status CheckConnection(Connection& connection, const std::vector<Migration>& migrations) {
  ASSIGN_OR_RETURN(const int64_t version, ReadNumber(connection, "PRAGMA user_version"));
  ASSIGN_OR_RETURN(const int64_t application, ReadNumber(connection, "PRAGMA application_id"));
  ASSIGN_OR_RETURN(const int64_t tables, ReadNumber(connection, "SELECT count(*) FROM sqlite_schema"));
  if (tables == 0 && version == 0 && (application == 0 || application == kApplicationId)) return absl::OkStatus();
  if (application != kApplicationId) return Refuse("not an Axiscal database", "NOT_A_DATABASE");
  const int ours = static_cast<int>(migrations.size());
  if (version > ours) {
    return Refuse(absl::StrCat("schema version ", version, " is newer than this program, which knows version ", ours),
                  "SCHEMA_NEWER");
  }
  return CheckChecksums(connection, migrations);
}

absl::Status Apply(Connection& connection, const Migration& migration, base::UtcTime now) {
  ASSIGN_OR_RETURN(Transaction transaction, Transaction::BeginWrite(connection));
  RETURN_IF_ERROR(connection.Execute(migration.sql));
  const std::string sha256 = base::Sha256Hex(migration.sql);
  RETURN_IF_ERROR(
      connection.Run("INSERT INTO migration (version, name, sha256, applied_at_utc_us) VALUES (?1, ?2, ?3, ?4)",
                     migration.version, migration.name, sha256, now));
  RETURN_IF_ERROR(connection.Execute(absl::StrCat("PRAGMA application_id = ", kApplicationId)));
  RETURN_IF_ERROR(connection.Execute(absl::StrCat("PRAGMA user_version = ", migration.version)));
  {
    ASSIGN_OR_RETURN(Statement broken, connection.Ask("SELECT \"table\" FROM pragma_foreign_key_check LIMIT 1"));
    ASSIGN_OR_RETURN(const bool found, broken.Step());
    if (found) return Refuse("leaves a broken reference in table " + broken.Text(0), "SCHEMA_CHANGED");
  }
  return transaction.Commit();
}

}  // namespace

absl::Status CheckFile(const std::string& path, const std::vector<Migration>& migrations) {
  struct stat info;
  if (stat(path.c_str(), &info) != 0 || info.st_size == 0) return absl::OkStatus();
  absl::StatusOr<std::unique_ptr<Connection>> connection = Connection::Open(path, Access::kReadOnly);
  const absl::Status status = connection.ok() ? CheckConnection(**connection, migrations) : connection.status();
  return base::Within(path, status);
}

absl::Status Migrate(Connection& connection, const std::vector<Migration>& migrations, base::UtcTime now) {
  RETURN_IF_ERROR(CheckConnection(connection, migrations));
  ASSIGN_OR_RETURN(const int64_t version, ReadNumber(connection, "PRAGMA user_version"));
  if (version == static_cast<int64_t>(migrations.size())) return absl::OkStatus();
  // Tables may be rebuilt; references are checked as a whole before each COMMIT.
  RETURN_IF_ERROR(connection.Execute("PRAGMA foreign_keys = OFF"));
  for (const Migration& migration : migrations) {
    if (migration.version <= version) continue;
    RETURN_IF_ERROR(base::Within("migration " + migration.name, Apply(connection, migration, now)));
  }
  return connection.Execute("PRAGMA foreign_keys = ON");
}

}  // namespace axiscal::storage
