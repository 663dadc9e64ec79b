#include "server/storage/postgres_migrate.h"

#include <algorithm>

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

// Beside the numbers that are given without gaps.
constexpr char kOldestProgram[] = "oldest_program";

// The oldest program that may run on a database at schema `version`: where nothing is remembered, that of the schema.
// Whoever has the store open is no older.
absl::StatusOr<int64_t> OldestOf(Connection& connection, int64_t version) {
  if (version == 0) return 0;
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT seq FROM given_number WHERE name = ?1", std::string(kOldestProgram)));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  return found ? row.Int(0) : version;
}

absl::Status ApplyToServer(Connection& connection, const Migration& migration, base::UtcTime now) {
  ASSIGN_OR_RETURN(Transaction transaction, Transaction::BeginWrite(connection));
  // Another process may have been faster: where several share the store, one writes at a time.
  ASSIGN_OR_RETURN(const int64_t version, PresentVersion(connection));
  if (version >= migration.version) return absl::OkStatus();
  ASSIGN_OR_RETURN(const int64_t present, OldestOf(connection, version));
  const int64_t needed = OldestProgram(migration);
  if (connection.has_others() && needed > present) {
    return base::Error(absl::StatusCode::kUnavailable,
                       absl::StrCat("axiscald of an older version have the database: programs of version ", present,
                                    " may be among them, it needs ", needed, "; stop them first"),
                       {"STORE_LOCKED", {}});
  }
  RETURN_IF_ERROR(connection.Execute(migration.sql));
  RETURN_IF_ERROR(NoteMigration(connection, migration, now));
  RETURN_IF_ERROR(
      connection.Run("INSERT INTO given_number (name, seq) VALUES (?1, ?2) ON CONFLICT (name) DO UPDATE "
                     "SET seq = excluded.seq",
                     std::string(kOldestProgram), std::max(present, needed)));
  return transaction.Commit();
}

// `version` is what the database has.
absl::Status CheckApplied(Connection& connection, const std::vector<Migration>& migrations, int64_t version,
                          NewerSchema newer) {
  const int64_t ours = migrations.empty() ? 0 : migrations.back().version;
  int64_t checked = version;
  if (version > ours && newer == NewerSchema::kRunOn) {
    ASSIGN_OR_RETURN(const int64_t oldest, OldestOf(connection, version));
    if (oldest <= ours) checked = ours;
  }
  return version > 0 ? CheckMigrations(connection, migrations, checked) : absl::OkStatus();
}

}  // namespace

absl::Status CheckPostgresSchema(Connection& connection, const std::vector<Migration>& migrations) {
  ASSIGN_OR_RETURN(const int64_t version, PresentVersion(connection));
  if (const int ours = migrations.back().version; version < ours) {
    return FailedPrecondition(absl::StrCat("schema version ", version, " is older than ", ours,
                                           ", with which this program has run: start it again, which brings it up to "
                                           "date"),
                              "SCHEMA_OLDER");
  }
  return CheckApplied(connection, migrations, version, NewerSchema::kRunOn);
}

absl::Status MigratePostgres(Connection& connection, const std::vector<Migration>& migrations, base::UtcTime now,
                             NewerSchema newer) {
  RETURN_IF_ERROR(CheckEncoding(connection));
  ASSIGN_OR_RETURN(const int64_t version, PresentVersion(connection));
  RETURN_IF_ERROR(CheckApplied(connection, migrations, version, newer));
  for (const Migration& migration : migrations) {
    if (migration.version <= version) continue;
    RETURN_IF_ERROR(base::Within("migration postgresql/" + migration.name, ApplyToServer(connection, migration, now)));
  }
  return absl::OkStatus();
}

}  // namespace axiscal::storage
