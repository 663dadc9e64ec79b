#include "server/storage/migrate.h"

#include <sys/stat.h>

#include "server/storage/refusal.h"
#include "server/storage/transaction.h"

namespace axiscal::storage {
namespace {

absl::StatusOr<int64_t> ReadNumber(SqliteConnection& connection, const std::string& sql) {
  ASSIGN_OR_RETURN(Statement statement, connection.Ask(sql));
  RETURN_IF_ERROR(statement.Step().status());
  return statement.Int(0);
}

absl::Status CheckConnection(SqliteConnection& connection, const std::vector<Migration>& migrations) {
  ASSIGN_OR_RETURN(const int64_t version, ReadNumber(connection, "PRAGMA user_version"));
  ASSIGN_OR_RETURN(const int64_t application, ReadNumber(connection, "PRAGMA application_id"));
  ASSIGN_OR_RETURN(const int64_t tables, ReadNumber(connection, "SELECT count(*) FROM sqlite_schema"));
  if (tables == 0 && version == 0 && (application == 0 || application == kApplicationId)) return absl::OkStatus();
  if (application != kApplicationId) return FailedPrecondition("not an Axiscal database", "NOT_A_DATABASE");
  return CheckMigrations(connection, migrations, version);
}

absl::Status Apply(SqliteConnection& connection, const Migration& migration, base::UtcTime now) {
  ASSIGN_OR_RETURN(Transaction transaction, Transaction::BeginWrite(connection));
  RETURN_IF_ERROR(connection.Execute(migration.sql));
  RETURN_IF_ERROR(NoteMigration(connection, migration, now));
  RETURN_IF_ERROR(connection.Execute(absl::StrCat("PRAGMA application_id = ", kApplicationId)));
  RETURN_IF_ERROR(connection.Execute(absl::StrCat("PRAGMA user_version = ", migration.version)));
  {
    ASSIGN_OR_RETURN(Statement broken, connection.Ask("SELECT \"table\" FROM pragma_foreign_key_check LIMIT 1"));
    ASSIGN_OR_RETURN(const bool found, broken.Step());
    if (found) return FailedPrecondition("leaves a broken reference in table " + broken.Text(0), "SCHEMA_CHANGED");
  }
  return transaction.Commit();
}

}  // namespace

absl::Status CheckFile(const std::string& path, const std::vector<Migration>& migrations) {
  struct stat info;
  if (stat(path.c_str(), &info) != 0 || info.st_size == 0) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::unique_ptr<SqliteConnection> connection, SqliteConnection::Open(path, Access::kReadOnly));
  return base::Within(path, CheckConnection(*connection, migrations));
}

absl::StatusOr<FileLock> LockStoreFile(const std::string& path, const std::vector<Migration>& migrations) {
  ASSIGN_OR_RETURN(FileLock lock, FileLock::Take(path));
  RETURN_IF_ERROR(CheckFile(lock.path(), migrations));
  return lock;
}

absl::Status Migrate(SqliteConnection& connection, const std::vector<Migration>& migrations, base::UtcTime now) {
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
