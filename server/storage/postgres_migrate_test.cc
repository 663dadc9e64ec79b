#include "server/storage/postgres_migrate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "absl/strings/str_cat.h"
#include "core/base/error_detail.h"
#include "core/base/sha256.h"
#include "server/storage/migrate.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

// Of the run with --store=postgresql alone.
class PostgresMigrate : public testing::Test {
 protected:
  void SetUp() override {
    if (TestServer::present == nullptr) GTEST_SKIP() << "needs storage_test --store=postgresql";
    url_ = TestServer::present->MakeDatabase(false);
  }
  void TearDown() override {
    if (!url_.empty()) TestServer::present->DropDatabase(url_);
  }
  std::unique_ptr<PostgresConnection> Connect() { return *PostgresConnection::Open(url_, Access::kWrite); }
  std::string RefusalOf(const std::vector<Migration>& migrations) {
    return base::ErrorReason(MigratePostgres(*Connect(), migrations, base::FromUtcUs(1)));
  }

  std::string url_;
};

// "table.column type", "not null" behind it.
std::set<std::string> ColumnsOf(Connection& connection, const std::string& sql) {
  std::set<std::string> columns;
  absl::StatusOr<Statement> row = connection.Ask(sql);
  while (*row->Step()) columns.insert(row->Text(0) + "." + row->Text(1) + " " + row->Text(2) + row->Text(3));
  return columns;
}

TEST_F(PostgresMigrate, TablesAndColumnsAreThoseOfSqlite) {
  const std::unique_ptr<PostgresConnection> connection = Connect();
  ASSERT_TRUE(MigratePostgres(*connection, PostgresMigrations(), base::FromUtcUs(1)).ok());
  std::set<std::string> found = ColumnsOf(
      *connection,
      "SELECT CAST(table_name AS TEXT), CAST(column_name AS TEXT), CASE CAST(data_type AS TEXT) WHEN 'bigint' THEN "
      "'INTEGER' WHEN 'text' THEN 'TEXT' WHEN 'bytea' THEN 'BLOB' WHEN 'double precision' THEN 'REAL' ELSE 'other' "
      "END, "
      "CASE WHEN CAST(is_nullable AS TEXT) = 'NO' THEN ' not null' ELSE '' END FROM information_schema.columns WHERE "
      "table_schema = 'public' AND table_name <> 'given_number'");
  const std::unique_ptr<SqliteConnection> file = *SqliteConnection::Open(":memory:", Access::kWrite);
  ASSERT_TRUE(Migrate(*file, EmbeddedMigrations(), base::FromUtcUs(1)).ok());
  const std::set<std::string> expected = ColumnsOf(
      *file,
      "SELECT t.name, c.name, c.type, CASE WHEN c.\"notnull\" = 1 OR c.pk > 0 THEN ' not null' ELSE '' END FROM "
      "sqlite_schema AS t JOIN pragma_table_info(t.name) AS c WHERE t.type = 'table' AND t.name NOT LIKE 'sqlite%'");
  EXPECT_GT(expected.size(), 200u);
  EXPECT_THAT(found, testing::ContainerEq(expected));
  EXPECT_EQ(PostgresMigrations().back().version, EmbeddedMigrations().back().version);
}

// As SQLite's lists find their pages: both have the same indices, each on the same columns.
TEST_F(PostgresMigrate, IndicesAndTriggersAreThoseOfSqlite) {
  const std::unique_ptr<PostgresConnection> connection = Connect();
  ASSERT_TRUE(MigratePostgres(*connection, PostgresMigrations(), base::FromUtcUs(1)).ok());
  const std::set<std::string> found =
      ColumnsOf(*connection,
                "SELECT CAST(tablename AS TEXT), CAST(indexname AS TEXT), 'index', '' FROM pg_indexes WHERE schemaname "
                "= 'public' AND indexname NOT LIKE '%_pkey' AND indexname NOT LIKE '%_key' UNION SELECT "
                "CAST(event_object_table AS TEXT), CAST(trigger_name AS TEXT), 'trigger', '' FROM "
                "information_schema.triggers WHERE trigger_name NOT IN ('audit_is_numbered', 'session_has_a_range')");
  const std::unique_ptr<SqliteConnection> file = *SqliteConnection::Open(":memory:", Access::kWrite);
  ASSERT_TRUE(Migrate(*file, EmbeddedMigrations(), base::FromUtcUs(1)).ok());
  EXPECT_THAT(found, testing::ContainerEq(ColumnsOf(
                         *file,
                         "SELECT tbl_name, name, type, '' FROM sqlite_schema WHERE type IN ('index', 'trigger') AND "
                         "name NOT LIKE 'sqlite%'")));
}

TEST_F(PostgresMigrate, WhatIsNotOursOrNewerIsRefused) {
  ASSERT_TRUE(Connect()->Execute("CREATE TABLE somebodys (x BIGINT)").ok());
  EXPECT_EQ(RefusalOf(PostgresMigrations()), "NOT_A_DATABASE");
  ASSERT_TRUE(Connect()->Execute("DROP TABLE somebodys").ok());
  EXPECT_EQ(RefusalOf(PostgresMigrations()), "");
  EXPECT_EQ(RefusalOf(PostgresMigrations()), "");
  std::vector<Migration> changed = PostgresMigrations();
  changed[0].sql += " ";
  EXPECT_EQ(RefusalOf(changed), "SCHEMA_CHANGED");
  ASSERT_TRUE(Connect()->Execute("INSERT INTO migration VALUES (9999, 'later', '', 0)").ok());
  EXPECT_EQ(RefusalOf(PostgresMigrations()), "SCHEMA_NEWER");
}

TEST_F(PostgresMigrate, OneThatFailsLeavesTheOnesBefore) {
  std::vector<Migration> broken = PostgresMigrations();
  broken.push_back({9998, "9998_broken", "CREATE TABLE b (x BIGINT); INSERT INTO nowhere VALUES (1)"});
  EXPECT_EQ(RefusalOf(broken), "STORE_BUG");
  EXPECT_FALSE(Connect()->Execute("SELECT 1 FROM b").ok());
  EXPECT_EQ(RefusalOf(PostgresMigrations()), "");
}

// Expand and contract: what a newer program has added an older one runs on, what it has taken away not.
TEST_F(PostgresMigrate, AnOlderProgramRunsOnASchemaThatWasExpanded) {
  const int ours = PostgresMigrations().back().version;
  std::vector<Migration> newer = PostgresMigrations();
  newer.push_back({ours + 1, "expands",
                   absl::StrCat("-- oldest program: ", ours, "\nALTER TABLE machine ADD COLUMN later BIGINT")});
  EXPECT_EQ(RefusalOf(newer), "");
  PostgresOptions options;
  options.url = url_;
  {
    const auto older = OpenPostgres(options);
    ASSERT_TRUE(older.ok()) << older.status();
    EXPECT_TRUE((*older)->CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
    EXPECT_TRUE((*older)->GetMachine(MachineId("mt")).ok());
  }
  // Whoever copies it knows all of its tables.
  EXPECT_EQ(RefusalOf(PostgresMigrations()), "SCHEMA_NEWER");
  newer.push_back({ours + 2, "contracts", "ALTER TABLE machine DROP COLUMN later"});
  EXPECT_EQ(RefusalOf(newer), "");
  EXPECT_EQ(base::ErrorReason(OpenPostgres(options).status()), "SCHEMA_NEWER");
  // Later ones that expand do not take that back.
  newer.push_back({ours + 3, "expands again", absl::StrCat("-- oldest program: ", ours, "\nSELECT 1")});
  EXPECT_EQ(RefusalOf(newer), "");
  EXPECT_EQ(base::ErrorReason(OpenPostgres(options).status()), "SCHEMA_NEWER");
}

TEST_F(PostgresMigrate, ANewerProgramStartsBesideOlderOnesWhereItsTablesLetThem) {
  const int ours = PostgresMigrations().back().version;
  // The oldest that may be among those that are there.
  const int oldest = OldestProgram(PostgresMigrations().back());
  PostgresOptions options;
  options.url = url_;
  auto older = OpenPostgres(options);
  ASSERT_TRUE(older.ok()) << older.status();
  ASSERT_TRUE((*older)->CreateMachine(MachineId("a"), "{}", Cell("")).ok());
  ASSERT_TRUE((*older)->GetMachine(MachineId("a")).ok());
  const auto reason_beside = [&](const std::vector<Migration>& migrations) {
    const auto beside = PostgresConnection::Open(url_, Access::kWrite, Hold::kShared);
    EXPECT_TRUE(beside.ok()) << beside.status();
    return base::ErrorReason(MigratePostgres(**beside, migrations, base::FromUtcUs(1), NewerSchema::kRunOn));
  };
  std::vector<Migration> newer = PostgresMigrations();
  newer.push_back({ours + 1, "expands",
                   absl::StrCat("-- oldest program: ", oldest, "\nALTER TABLE machine ADD COLUMN later BIGINT")});
  EXPECT_EQ(reason_beside(newer), "");
  // The older one goes on, with the statements that it had prepared.
  EXPECT_TRUE((*older)->CreateMachine(MachineId("b"), "{}", Cell("")).ok());
  EXPECT_TRUE((*older)->GetMachine(MachineId("a")).ok());
  EXPECT_EQ((*older)->ListMachines({})->rows.size(), 2u);
  newer.push_back({ours + 2, "contracts", "ALTER TABLE machine DROP COLUMN later"});
  EXPECT_EQ(reason_beside(newer), "STORE_LOCKED");
  EXPECT_TRUE((*older)->GetMachine(MachineId("b")).ok());
  older->reset();
  EXPECT_EQ(reason_beside(newer), "");
  EXPECT_FALSE(Connect()->Execute("SELECT later FROM machine").ok());
}

TEST(PostgresStore, IsNotThere) {
  if (TestServer::present == nullptr) GTEST_SKIP() << "needs storage_test --store=postgresql";
  PostgresOptions options;
  options.url = "host=/nowhere dbname=none";
  EXPECT_EQ(base::ErrorReason(OpenPostgres(options).status()), "STORE_DOWN");
}

// As behind a restart of the server, or a fail-over.
TEST(PostgresStore, GoesOnWhenItsConnectionsAreLost) {
  if (TestServer::present == nullptr) GTEST_SKIP() << "needs storage_test --store=postgresql";
  TempDatabase database;
  const SessionId id = StoreSession(*database, 3);
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(database.Beside()
                    ->Execute("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE pid <> pg_backend_pid() "
                              "AND datname = current_database()")
                    .ok());
    EXPECT_TRUE(database->GetSession(id).ok());
    const auto machine = database->CreateMachine(MachineId("m" + std::to_string(i)), "{}", Cell(""));
    EXPECT_TRUE(machine.ok()) << machine.status();
  }
  EXPECT_TRUE(database->ReadSession(id).ok());
  EXPECT_TRUE(database->CheckAudit().ok());
}

// The server was away, and those who came back first are of a newer version.
TEST(PostgresStore, RefusesASchemaThatBecameNewerWhileItWasAway) {
  if (TestServer::present == nullptr) GTEST_SKIP() << "needs storage_test --store=postgresql";
  TempDatabase database;
  const SessionId id = StoreSession(*database, 3);
  const auto change = [&](const std::string& sql) {
    const absl::Status done = database.Beside()->Execute(
        sql +
        "; SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE pid <> pg_backend_pid() AND datname = "
        "current_database()");
    ASSERT_TRUE(done.ok()) << done;
  };
  const auto expect = [&](const std::string& reason, const std::string& machine) {
    for (int i = 0; i < 2; ++i) {  // a second call meets the connection that the first one has made
      const auto created = database->CreateMachine(MachineId(machine), "{}", Cell(""));
      EXPECT_EQ(base::ErrorReason(created.status()), reason) << created.status();
      EXPECT_EQ(base::ErrorReason(database->GetSession(id).status()), reason);
      if (reason.empty()) return;
    }
  };
  const std::string ours = absl::StrCat(PostgresMigrations().back().version);
  const std::string newer = absl::StrCat(PostgresMigrations().back().version + 1);
  // Newer, but this program may run on it.
  change("INSERT INTO migration VALUES (" + newer + ", 'newer', 'x', 1)");
  change("INSERT INTO given_number VALUES ('oldest_program', " + ours +
         ") ON CONFLICT (name) DO UPDATE SET seq = " + ours);
  expect("", "m1");
  change("UPDATE given_number SET seq = " + newer + " WHERE name = 'oldest_program'");
  expect("SCHEMA_NEWER", "m2");
  // It keeps nobody off who wants the store alone.
  EXPECT_TRUE(PostgresConnection::Open(database.url(), Access::kWrite).ok());
  change("DELETE FROM migration WHERE version >= " + ours);
  expect("SCHEMA_OLDER", "m2");
  change("INSERT INTO migration VALUES (" + ours + ", 'ours', '" + base::Sha256Hex(PostgresMigrations().back().sql) +
         "', 1)");
  expect("", "m2");
}

}  // namespace
}  // namespace axiscal::storage
