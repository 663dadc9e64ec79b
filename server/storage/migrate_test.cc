#include "server/storage/migrate.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/base/error_detail.h"
#include "server/storage/sqlite_connection.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

const Migration kFirst = {
    1, "0001_first",
    "CREATE TABLE migration (version INTEGER PRIMARY KEY, name TEXT NOT NULL, sha256 TEXT NOT NULL, "
    "applied_at_utc_us INTEGER NOT NULL) STRICT; CREATE TABLE a (x INTEGER PRIMARY KEY) STRICT;"
    "INSERT INTO a VALUES (7);"};
const Migration kSecond = {2, "0002_second", "ALTER TABLE a ADD COLUMN y TEXT NOT NULL DEFAULT 'old';"};
const Migration kBroken = {2, "0002_broken", "CREATE TABLE b (z INTEGER) STRICT; INSERT INTO nowhere VALUES (1);"};
const Migration kDangling = {2, "0002_dangling",
                             "CREATE TABLE b (x INTEGER REFERENCES a (x)) STRICT; INSERT INTO b VALUES (8);"};

class Migrations : public testing::Test {
 protected:
  absl::Status Apply(const std::vector<Migration>& migrations) {
    RETURN_IF_ERROR(CheckFile(path, migrations));
    ASSIGN_OR_RETURN(const std::unique_ptr<SqliteConnection> connection, SqliteConnection::Open(path, Access::kWrite));
    return Migrate(*connection, migrations, base::FromUtcUs(1));
  }
  std::string Ask(const std::string& sql) {
    const auto connection = SqliteConnection::Open(path, Access::kReadOnly);
    DEMAND(connection.ok());
    auto row = (*connection)->Ask(sql);
    DEMAND(row.ok() && row->Step().ok());
    return row->Text(0);
  }
  std::string FileBytes() {
    std::ostringstream bytes;
    bytes << std::ifstream(path, std::ios::binary).rdbuf();
    return bytes.str();
  }

  TempDirectory directory;
  const std::string path = directory.File("m.db");
};

TEST_F(Migrations, AnOldFileIsBroughtForwardWithItsRows) {
  ASSERT_TRUE(Apply({kFirst}).ok());
  const absl::Status upgraded = Apply({kFirst, kSecond});
  ASSERT_TRUE(upgraded.ok()) << upgraded;
  EXPECT_EQ(Ask("SELECT x || y FROM a"), "7old");
  EXPECT_EQ(Ask("PRAGMA user_version"), "2");
  EXPECT_EQ(Ask("SELECT group_concat(name, ' ') FROM migration"), "0001_first 0002_second");
  EXPECT_TRUE(Apply({kFirst, kSecond}).ok());
}

TEST_F(Migrations, ANewerFileIsRefusedAndNamesBothVersions) {
  ASSERT_TRUE(Apply({kFirst, kSecond}).ok());
  const std::string before = FileBytes();
  const absl::Status refused = Apply({kFirst});
  EXPECT_EQ(base::ErrorReason(refused), "SCHEMA_NEWER");
  EXPECT_NE(refused.message().find("version 2"), absl::string_view::npos);
  EXPECT_NE(refused.message().find("version 1"), absl::string_view::npos);
  EXPECT_EQ(FileBytes(), before);
}

TEST_F(Migrations, AReleasedMigrationMustNotChange) {
  ASSERT_TRUE(Apply({kFirst}).ok());
  Migration edited = kFirst;
  edited.sql += " -- edited";
  EXPECT_EQ(base::ErrorReason(Apply({edited, kSecond})), "SCHEMA_CHANGED");
  EXPECT_EQ(Ask("PRAGMA user_version"), "1");
}

TEST_F(Migrations, OneThatFailsLeavesNothingBehind) {
  ASSERT_TRUE(Apply({kFirst}).ok());
  EXPECT_FALSE(Apply({kFirst, kBroken}).ok());
  EXPECT_FALSE(Apply({kFirst, kDangling}).ok());
  EXPECT_EQ(Ask("SELECT count(*) FROM sqlite_schema WHERE name = 'b'"), "0");
  EXPECT_EQ(Ask("PRAGMA user_version"), "1");
}

TEST_F(Migrations, OtherFilesAreNotTouched) {
  std::ofstream(path) << "# machine: mt\nt_s,X_mm\n0,1\n" << std::string(4096, 'x');
  std::string before = FileBytes();
  EXPECT_EQ(base::ErrorReason(Apply({kFirst})), "NOT_A_DATABASE");
  EXPECT_EQ(FileBytes(), before);
  std::filesystem::remove(path);
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &other), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(other, "CREATE TABLE t (x)", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(other);
  before = FileBytes();
  EXPECT_EQ(base::ErrorReason(Apply({kFirst})), "NOT_A_DATABASE");
  EXPECT_EQ(FileBytes(), before);
}

TEST_F(Migrations, TheProgramsOwnAreNumberedFromOne) {
  const std::vector<Migration>& migrations = EmbeddedMigrations();
  ASSERT_FALSE(migrations.empty());
  for (size_t i = 0; i < migrations.size(); ++i) EXPECT_EQ(migrations[i].version, static_cast<int>(i) + 1);
}

TEST(SqliteDatabase, IsHeldByOneOnly) {
  TempDatabase database;
  SqliteOptions options;
  options.path = database.path();
  const absl::Status second = OpenSqlite(options).status();
  EXPECT_TRUE(absl::IsUnavailable(second)) << second;
  EXPECT_EQ(base::ErrorReason(second), "STORE_LOCKED");
  database.Close();
  EXPECT_TRUE(OpenSqlite(options).ok());
}

// A file is the same under every name.
// What an open connection has in memory it goes on answering from, whatever has become of the file.
TEST(SqliteDatabase, WhatIsReadAnewTellsOfAFileThatIsLost) {
  TempDatabase database;
  ASSERT_TRUE(database->CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
  ASSERT_TRUE(database->ListMachines({}).ok());
  EXPECT_TRUE(database->TryReadAnew().ok());
  {
    std::fstream file(database.path(), std::ios::in | std::ios::out | std::ios::binary);
    file.write(std::string(409'600, '\0').data(), 409'600);
    ASSERT_TRUE(file.flush().good());
  }
  std::filesystem::remove(database.path() + "-wal");
  EXPECT_TRUE(database->ListMachines({}).ok()) << "from memory";
  EXPECT_FALSE(database->TryReadAnew().ok());
}

TEST(SqliteDatabase, IsHeldByOneOnlyThroughLinksToo) {
  TempDatabase database;
  const TempDirectory elsewhere;
  SqliteOptions symbolic, hard;
  symbolic.path = elsewhere.File("symbolic.db");
  hard.path = elsewhere.File("hard.db");
  std::filesystem::create_symlink(database.path(), symbolic.path);
  std::filesystem::create_hard_link(database.path(), hard.path);
  for (const SqliteOptions& options : {symbolic, hard}) {
    const absl::Status second = OpenSqlite(options).status();
    EXPECT_EQ(base::ErrorReason(second), "STORE_LOCKED") << options.path << ": " << second;
  }
  database.Close();
  // The log would stand beside one name only.
  EXPECT_EQ(base::ErrorReason(OpenSqlite(symbolic).status()), "STORE_LINKED");
  EXPECT_EQ(base::ErrorReason(OpenSqlite(hard).status()), "STORE_LINKED");
  std::filesystem::remove(hard.path);
  const auto opened = OpenSqlite(symbolic);
  ASSERT_TRUE(opened.ok()) << opened.status();
  EXPECT_FALSE(std::filesystem::exists(symbolic.path + "-wal"));
  EXPECT_TRUE(std::filesystem::exists(database.path() + "-wal"));
}

// A refused opening leaves alone what SQLite has locked: a POSIX lock goes with any descriptor of its file that the
// process closes.
TEST(SqliteDatabase, KeepsItsLocksWhenAnotherOpeningIsRefused) {
  // Of this process alone: /proc/locks, which shows those of all, loses lines while others come and go.
  const auto locks = [] {
    int count = 0;
    for (const auto& descriptor : std::filesystem::directory_iterator("/proc/self/fdinfo")) {
      std::ifstream info(descriptor.path());
      for (std::string line; std::getline(info, line);)
        count += line.starts_with("lock:") && line.find("POSIX") != std::string::npos ? 1 : 0;
    }
    return count;
  };
  TempDatabase database;
  SqliteOptions options;
  options.path = database.path();
  ASSERT_TRUE(database->ListMachines({}).ok());
  const int before = locks();
  if (before == 0) GTEST_SKIP() << "/proc/self/fdinfo shows no locks here";
  EXPECT_EQ(base::ErrorReason(OpenSqlite(options).status()), "STORE_LOCKED");
  EXPECT_EQ(locks(), before);
}

}  // namespace
}  // namespace axiscal::storage
