// Chunks of each 65,536 sessions in a table of their own, taken out as a whole and put back. Of the run with
// --store=postgresql alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "server/storage/copy_store.h"
#include "server/storage/postgres_migrate.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// What a query gives, each row as its columns with blanks between.
std::vector<std::string> Rows(Connection& connection, const std::string& sql) {
  std::vector<std::string> rows;
  absl::StatusOr<Statement> row = connection.Ask(sql);
  EXPECT_TRUE(row.ok()) << row.status();
  while (row.ok()) {
    const absl::StatusOr<bool> has_row = row->Step();
    EXPECT_TRUE(has_row.ok()) << has_row.status();
    if (!has_row.ok() || !*has_row) break;
    rows.push_back(row->Text(0));
  }
  return rows;
}
constexpr char kWhere[] =
    "SELECT DISTINCT CAST(CAST(tableoid AS regclass) AS TEXT) || ' ' || CAST(session_id AS TEXT) FROM chunk ORDER BY 1";

SessionId Store(Database& database, const std::string& request_id) {
  DEMAND(database.CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
  const auto session = database.CreateSession(TestSession(request_id));
  DEMAND(session.ok());
  std::vector<uint32_t> crcs;
  for (int seq = 0; seq < 3; ++seq) {
    crcs.push_back(session::ChunkCrc32c(TestColumns(seq, 10)));
    DEMAND(Append(database, session->id, seq, TestColumns(seq, 10)).ok());
  }
  DEMAND(database.FinishSession(session->id, {3, 30, session::SessionHash(crcs)}).ok());
  return session->id;
}

class PostgresRanges : public testing::Test {
 protected:
  void SetUp() override {
    if (TestServer::present == nullptr) GTEST_SKIP() << "needs storage_test --store=postgresql";
    database_ = std::make_unique<TempDatabase>();
    server_ = database_->Beside();
  }
  Database& database() { return **database_; }
  // The next session has this number.
  void GoOnAt(int64_t id) {
    ASSERT_TRUE(
        server_->Execute(absl::StrCat("SELECT setval(pg_get_serial_sequence('session', 'id'), ", id - 1, ")")).ok());
  }
  std::string Detach(const std::string& table) { return "ALTER TABLE chunk DETACH PARTITION " + table; }

  std::unique_ptr<TempDatabase> database_;
  std::unique_ptr<Connection> server_;
};

TEST_F(PostgresRanges, EachRangeOfSessionsHasATable) {
  Store(database(), "a");
  GoOnAt(65535);
  Store(database(), "b");
  Store(database(), "c");
  GoOnAt(400000);
  const SessionId last = Store(database(), "d");
  EXPECT_THAT(Rows(*server_, kWhere),
              ElementsAre("chunk_range_0 1", "chunk_range_0 65535", "chunk_range_1 65536", "chunk_range_6 400000"));
  EXPECT_TRUE(database().ReadSession(last).ok());
  // What is never changed, and what a complete session keeps, is so in each of them.
  for (const char* const sql : {"UPDATE chunk_range_1 SET crc32c = 1", "TRUNCATE chunk_range_1",
                                "DELETE FROM chunk_range_1", "INSERT INTO chunk_range_1 VALUES (7, 0, 1, 1, '')"})
    EXPECT_FALSE(server_->Execute(sql).ok()) << sql;
  const CheckReport report = database_->Check();
  EXPECT_THAT(report.damages, IsEmpty()) << report.damages[0].text;
  // One that is switched off is found.
  ASSERT_TRUE(server_->Execute("ALTER TABLE chunk_range_1 DISABLE TRIGGER chunk_is_never_changed").ok());
  ASSERT_EQ(database_->Check().damages.size(), 1u);
  EXPECT_THAT(database_->Check().damages[0].text, HasSubstr("chunk_is_never_changed of table chunk_range_1"));
}

TEST_F(PostgresRanges, WhatWasDetachedIsSaidSoAndComesBack) {
  const SessionId old = Store(database(), "old");
  NewCalibration calibration = TestCalibration(database_->clock.UtcNow(), 1.0);
  calibration.sessions = {old};
  ASSERT_TRUE(database().CreateCalibration(calibration).ok());
  GoOnAt(65536);
  const SessionId young = Store(database(), "young");
  const auto before = database().ReadSession(old);
  ASSERT_TRUE(before.ok());
  ASSERT_TRUE(server_->Execute(Detach("chunk_range_0")).ok());

  const absl::Status gone = database().ReadSession(old).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(gone)) << gone;
  EXPECT_EQ(base::ErrorReason(gone), "READINGS_DETACHED");
  EXPECT_TRUE(database().ReadSession(young).ok());
  // All else of it is there; who sends it again hears that it is.
  EXPECT_EQ(database().GetSession(old)->state, SessionState::kComplete);
  EXPECT_TRUE(database().GetCalibration(CalibrationId(1)).ok());
  EXPECT_EQ(database().CreateSession(TestSession("old"))->id, old);
  EXPECT_EQ(base::ErrorReason(Append(database(), old, 0, TestColumns(0, 10)).status()), "READINGS_DETACHED");
  EXPECT_TRUE(database_->damages.empty());
  CheckReport report = database_->Check();
  EXPECT_THAT(report.damages, IsEmpty()) << report.damages[0].text;
  EXPECT_EQ(report.sessions, 1);
  EXPECT_EQ(report.chunks, 3);

  ASSERT_TRUE(server_->Execute("ALTER TABLE chunk ATTACH PARTITION chunk_range_0 FOR VALUES FROM (0) TO (65536)").ok());
  EXPECT_TRUE(*database().ReadSession(old) == *before);
  report = database_->Check();
  EXPECT_THAT(report.damages, IsEmpty()) << report.damages[0].text;
  EXPECT_EQ(report.sessions, 2);
  EXPECT_EQ(report.chunks, 6);
}

// Retention leaves alone what is not there: it comes back as it was.
TEST_F(PostgresRanges, WhatWasDetachedDoesNotExpire) {
  const SessionId old = Store(database(), "old");
  GoOnAt(65536);
  const SessionId young = Store(database(), "young");
  const auto days = [](int count) { return std::chrono::hours(24 * count); };
  ASSERT_TRUE(database().ExpireSessions(days(1000)).ok());
  database_->clock.Advance(days(20));
  ASSERT_TRUE(server_->Execute(Detach("chunk_range_0")).ok());
  EXPECT_EQ(*database().ExpireReadings(days(9)), 1);
  EXPECT_EQ(database().GetSession(old)->state, SessionState::kComplete);
  EXPECT_EQ(database().GetSession(young)->state, SessionState::kExpired);
}

TEST_F(PostgresRanges, ACopyWantsAllReadings) {
  Store(database(), "old");
  GoOnAt(65536);
  Store(database(), "young");
  database_->Close();
  const std::string file = database_->path();
  const auto copy = [&] {
    return CopyStoreTo(database_->url(), file, base::FromUtcUs(1),
                       [](const CopyProgress&) { return absl::OkStatus(); });
  };
  ASSERT_TRUE(server_->Execute(Detach("chunk_range_0")).ok());
  const absl::Status refused = copy().status();
  EXPECT_EQ(base::ErrorReason(refused), "COPY_DETACHED");
  EXPECT_THAT(std::string(refused.message()), HasSubstr("session 1 "));
  ASSERT_TRUE(server_->Execute("ALTER TABLE chunk ATTACH PARTITION chunk_range_0 FOR VALUES FROM (0) TO (65536)").ok());
  const auto copied = copy();
  ASSERT_TRUE(copied.ok()) << copied.status();
  // And back: the tables are made as sessions come.
  const std::string url = TestServer::present->MakeDatabase(false);
  const auto back = CopyStoreTo(file, url, base::FromUtcUs(1), [](const CopyProgress&) { return absl::OkStatus(); });
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(back->sha256, copied->sha256);
  EXPECT_THAT(Rows(**PostgresConnection::Open(url, Access::kReadOnly), kWhere),
              ElementsAre("chunk_range_0 1", "chunk_range_1 65536"));
  TestServer::present->DropDatabase(url);
}

// A database of before: its readings become the range of its newest session and stay where they are, and a program of
// before goes on beside this one with the statements that it has.
TEST_F(PostgresRanges, ADatabaseOfBeforeIsTakenOverWhileAnOlderProgramWorks) {
  const std::string url = TestServer::present->MakeDatabase(false);
  std::vector<Migration> before = PostgresMigrations();
  while (before.back().version >= 24) before.pop_back();
  {
    const std::unique_ptr<PostgresConnection> older = *PostgresConnection::Open(url, Access::kWrite, Hold::kShared);
    ASSERT_TRUE(MigratePostgres(*older, before, base::FromUtcUs(1)).ok());
    ASSERT_TRUE(older->LetOthersIn().ok());
    const auto open = [&](int64_t id) {
      return older->Run(
          "INSERT INTO session (id, machine_id, name, instrument, state, next_seq, reading_count, created_by, "
          "body_sha256, created_at_utc_us, last_seen_at_utc_us) VALUES (?1, 1, 's', 'touch', 1, 1, 10, 'u', '', 0, 0)",
          id);
    };
    const auto append = [&](int64_t id) {
      return older->Run("INSERT INTO chunk (session_id, seq, reading_count, crc32c, content) VALUES (?1, 0, 1, 2, ?2)",
                        id, Blob{"x"});
    };
    const auto add = [&](int64_t id) {
      absl::Status added = open(id);
      if (added.ok()) added = append(id);
      EXPECT_TRUE(added.ok()) << added;
    };
    ASSERT_TRUE(older->Run("INSERT INTO machine (id, name, revision, created_at_utc_us) VALUES (1, 'mt', 1, 0)").ok());
    add(5);
    add(70000);
    ASSERT_TRUE(open(131072).ok());  // has no chunk yet
    const std::string node = "SELECT CAST(pg_relation_filenode('chunk_range_2') AS TEXT)";
    const std::vector<std::string> file = Rows(*older, "SELECT CAST(pg_relation_filenode('chunk') AS TEXT)");
    const std::unique_ptr<PostgresConnection> newer = *PostgresConnection::Open(url, Access::kWrite, Hold::kShared);
    const absl::Status migrated =
        MigratePostgres(*newer, PostgresMigrations(), base::FromUtcUs(1), NewerSchema::kRunOn);
    ASSERT_TRUE(migrated.ok()) << migrated;
    EXPECT_EQ(Rows(*older, node), file);
    add(80000);  // its number was taken before
    add(140000);
    const absl::Status goes_on = append(131072);
    EXPECT_TRUE(goes_on.ok()) << goes_on;
    add(200000);
    EXPECT_THAT(Rows(*newer, kWhere),
                ElementsAre("chunk_range_2 131072", "chunk_range_2 140000", "chunk_range_2 5", "chunk_range_2 70000",
                            "chunk_range_2 80000", "chunk_range_3 200000"));
    EXPECT_EQ(Rows(*older, "SELECT 'x' FROM chunk").size(), 6u);
    EXPECT_FALSE(*newer->HasDetached(SessionId(5)));
    ASSERT_TRUE(newer->Execute(Detach("chunk_range_2")).ok());
    EXPECT_TRUE(*newer->HasDetached(SessionId(5)));
    EXPECT_TRUE(*newer->HasDetached(SessionId(70000)));
    EXPECT_FALSE(*newer->HasDetached(SessionId(200000)));
  }
  TestServer::present->DropDatabase(url);
}

}  // namespace
}  // namespace axiscal::storage
