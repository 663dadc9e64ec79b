#include "server/storage/postgres_migrate.h"

#include "server/storage/refusal.h"
#include "server/storage/transaction.h"

namespace axiscal::storage {
namespace {

absl::Status CheckEncoding(Connection& connection) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT CAST(current_setting('server_encoding') AS TEXT)"));
  RETURN_IF_ERROR(row.Step().status());
  if (row.Text(0) == "UTF8") return absl::OkStatus();
  return FailedPrecondition(
      absl::StrCat("the database keeps texts as ", row.Text(0), ", must be UTF8 (createdb -E UTF8 -T template0)"),
      "NOT_A_DATABASE");
}

// Of the last migration that was applied; 0: none.
absl::StatusOr<int64_t> PresentVersion(Connection& connection) {
  bool is_ours = false;
  int64_t tables = 0;
  {
    ASSIGN_OR_RETURN(Statement row,
                     connection.Ask("SELECT to_regclass('migration') IS NOT NULL, (SELECT count(*) FROM pg_class AS c "
                                    "JOIN pg_namespace AS n ON n.oid = c.relnamespace WHERE n.nspname = "
                                    "current_schema() AND c.relkind IN ('r', 'p'))"));
    RETURN_IF_ERROR(row.Step().status());
    is_ours = row.Bool(0);
    tables = row.Int(1);
  }
  if (!is_ours && tables == 0) return 0;
  if (!is_ours) return FailedPrecondition("not an Axiscal database", "NOT_A_DATABASE");
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT coalesce(max(version), 0) FROM migration"));
  RETURN_IF_ERROR(row.Step().status());
  return row.Int(0);
}

absl::Status ApplyToServer(Connection& connection, const Migration& migration, base::UtcTime now) {
  ASSIGN_OR_RETURN(Transaction transaction, Transaction::BeginWrite(connection));
  // Another process may have been faster: where several share the store, one writes at a time.
  ASSIGN_OR_RETURN(const int64_t version, PresentVersion(connection));
  if (version >= migration.version) return absl::OkStatus();
  RETURN_IF_ERROR(connection.Execute(migration.sql));
  RETURN_IF_ERROR(NoteMigration(connection, migration, now));
  return transaction.Commit();
}

}  // namespace

absl::Status MigratePostgres(Connection& connection, const std::vector<Migration>& migrations, base::UtcTime now) {
  RETURN_IF_ERROR(CheckEncoding(connection));
  ASSIGN_OR_RETURN(const int64_t version, PresentVersion(connection));
  if (version > 0) RETURN_IF_ERROR(CheckMigrations(connection, migrations, version));
  for (const Migration& migration : migrations) {
    if (migration.version <= version) continue;
    RETURN_IF_ERROR(base::Within("migration postgresql/" + migration.name, ApplyToServer(connection, migration, now)));
  }
  return absl::OkStatus();
}

}  // namespace axiscal::storage
