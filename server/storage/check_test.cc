#include "server/storage/check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/base/error_detail.h"
#include "server/storage/backup.h"
#include "server/storage/migration.h"
#include "server/storage/sqlite_connection.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// A file with one of everything; closed.
class CheckTest : public testing::Test {
 protected:
  void SetUp() override {
    const SessionId session = StoreSession(*database_, 3);
    const ProgramId program = database_->BeginProgram({"nc", "O1", Cell("")})->id;
    ASSERT_TRUE(database_->AppendProgram(program, 0, "G01 X1.0000\n").ok());
    ASSERT_TRUE(database_->FinishProgram(program, 12, "").ok());
    NewJob job;
    job.kind = "identify";
    job.machine = MachineId("mt");
    job.params = "params";
    job.caller = Cell("");
    ASSERT_TRUE(database_->CreateJob(job, 10).ok());
    NewCalibration calibration = TestCalibration(database_.clock.UtcNow(), 1.0);
    calibration.sessions = {session};
    const auto claimed = database_->ClaimJob(std::chrono::seconds(30));
    ASSERT_TRUE(database_->SucceedJob(ClaimOf(**claimed), {"result", calibration, {program}}).ok());
    // Open and given up ones.
    const SessionId open = database_->CreateSession(TestSession("open"))->id;
    ASSERT_TRUE(Append(*database_, open, 0, TestColumns(0, 10)).ok());
    ASSERT_TRUE(database_->AbortSession(database_->CreateSession(TestSession("given up"))->id).ok());
    ASSERT_TRUE(database_->BeginProgram({"nc", "O2", Cell("open")}).ok());
    database_.Close();
  }
  std::string Bytes() const {
    std::ifstream file(database_.path(), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  // What is named after something has changed the file, behind the store and past its triggers.
  std::vector<std::string> NamedAfter(const std::string& sql) {
    {
      const std::unique_ptr<SqliteConnection> connection = *SqliteConnection::Open(database_.path(), Access::kWrite);
      EXPECT_TRUE(connection->Execute("PRAGMA foreign_keys = OFF").ok());
      std::string triggers;
      for (const char* const trigger :
           {"chunk_is_never_changed", "complete_session_keeps_its_chunks", "audit_is_never_changed"}) {
        {
          Statement row = *connection->Ask("SELECT sql FROM sqlite_schema WHERE name = ?1", std::string(trigger));
          EXPECT_TRUE(*row.Step());
          absl::StrAppend(&triggers, row.Text(0), ";\n");
        }
        EXPECT_TRUE(connection->Execute(absl::StrCat("DROP TRIGGER ", trigger)).ok());
      }
      const absl::Status done = connection->Execute(sql);
      EXPECT_TRUE(done.ok()) << sql << ": " << done;
      EXPECT_TRUE(connection->Execute(triggers).ok());
    }
    const auto report = CheckStoreFile(database_.path());
    EXPECT_TRUE(report.ok()) << report.status();
    std::vector<std::string> named;
    if (!report.ok()) return named;
    for (const Damage& damage : report->damages) named.push_back(damage.resource);
    EXPECT_EQ(report->damage_count, static_cast<int64_t>(named.size()));
    return named;
  }

  TempDatabase database_;
};

TEST_F(CheckTest, AWholeFileIsWholeAndStaysAsItWas) {
  const std::string before = Bytes();
  const auto report = CheckStoreFile(database_.path());
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_THAT(report->damages, IsEmpty()) << report->damages[0].text;
  EXPECT_EQ(report->sessions, 3);
  EXPECT_EQ(report->chunks, 4);
  EXPECT_EQ(report->jobs, 1);
  EXPECT_EQ(report->calibrations, 1);
  EXPECT_EQ(report->programs, 2);
  EXPECT_EQ(report->descriptions, 1);
  EXPECT_EQ(report->audit.id, 2);
  EXPECT_EQ(Bytes(), before);
}

TEST_F(CheckTest, EachDamageIsNamed) {
  const std::pair<std::string, std::string> damages[] = {
      {"UPDATE chunk SET content = CAST('x' AS BLOB) WHERE session_id = 1 AND seq = 1", "sessions/1/chunks/1"},
      {"UPDATE session_header SET text = '3.0' WHERE session_id = 1 AND key = 'sigma_um'", "sessions/1"},
      {"UPDATE session SET reading_count = 11 WHERE id = 2", "sessions/2"},
      {"INSERT INTO chunk SELECT 3, seq, reading_count, crc32c, content FROM chunk WHERE session_id = 2", "sessions/3"},
      {"UPDATE job SET result = CAST('other' AS BLOB)", "jobs/1"},
      {"UPDATE program_part SET crc32c = 1", "programs/1"},
      {"UPDATE machine_revision SET description_json = '{ }'", "machines/mt, revision 1"},
      {"UPDATE estimate_week SET sum_um_urad = sum_um_urad + 0.001 WHERE symbol = 'EX0C'",
       "machines/mt, history of EX0C, week 2810"},
      {"UPDATE estimate_week SET last_sigma_um_urad = 7 WHERE symbol = 'EA0B'",
       "machines/mt, history of EA0B, week 2810"},
      {"DELETE FROM estimate_week WHERE symbol = 'EC0C'", "machines/mt, history of EC0C, week 2810"},
      {"UPDATE audit SET principal = 'eve' WHERE id = 1", "audit"},
      {"UPDATE job SET machine_id = 77", "file"},
  };
  std::vector<std::string> all;
  for (const auto& [damage, resource] : damages) {
    const std::vector<std::string> named = NamedAfter(damage);
    EXPECT_THAT(named, testing::Contains(resource)) << damage;
    EXPECT_GT(named.size(), all.size()) << damage;  // the ones before are named as well
    all = named;
  }
  EXPECT_THAT(all, testing::Contains("calibrations/1"));  // of a description that is damaged
}

// What is rejected is no part of the sums over weeks, nor is what nobody could tell.
TEST_F(CheckTest, WeeksOfRejectedCalibrationsAreWhole) {
  database_.Open();
  const auto now = database_.clock.UtcNow();
  for (const double ea0b_urad : {0.1, 0.2, 0.7}) {
    const CalibrationRecord made = *database_->CreateCalibration(TestCalibration(now, ea0b_urad));
    if (ea0b_urad == 0.2) DEMAND(database_->RetireCalibration(made.id, 0, Cell("")).ok());
  }
  const auto alone = database_->CreateCalibration(TestCalibration(now + std::chrono::hours(24 * 30), 1.0));
  ASSERT_TRUE(database_->RetireCalibration(alone->id, 0, Cell("")).ok());
  database_.Close();
  const auto report = CheckStoreFile(database_.path());
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_THAT(report->damages, IsEmpty()) << report->damages[0].resource << ": " << report->damages[0].text;
}

// A rule of the file that was changed, is missing or was put in: what it shall refuse would pass.
TEST_F(CheckTest, AChangedSchemaIsNamed) {
  const auto named_after = [&](const std::string& sql) {
    {
      const std::unique_ptr<SqliteConnection> connection = *SqliteConnection::Open(database_.path(), Access::kWrite);
      const absl::Status done = connection->Execute(sql);
      EXPECT_TRUE(done.ok()) << sql << ": " << done;
    }
    const auto report = CheckStoreFile(database_.path());
    EXPECT_TRUE(report.ok()) << report.status();
    std::string all;
    for (const Damage& damage : report->damages) absl::StrAppend(&all, damage.resource, ": ", damage.text, "\n");
    return all;
  };
  const std::string changed = "schema: trigger audit_is_never_changed is not what the migrations made\n";
  EXPECT_EQ(named_after("PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql = replace(sql, 'ABORT', 'FAIL') "
                        "WHERE name = 'audit_is_never_changed'; PRAGMA writable_schema = OFF"),
            changed);
  const std::string missing = "schema: trigger chunk_is_never_changed is not there\n";
  EXPECT_EQ(named_after("DROP TRIGGER chunk_is_never_changed"), changed + missing);
  EXPECT_EQ(named_after("CREATE TABLE more (id INTEGER)"),
            changed + missing + "schema: table more is none of the migrations'\n");
}

// One bit of the page that a table begins with.
TEST_F(CheckTest, ADamagedStructureIsNamed) {
  std::string bytes = Bytes();
  int64_t page = 0;
  {
    const std::unique_ptr<SqliteConnection> connection = *SqliteConnection::Open(database_.path(), Access::kReadOnly);
    Statement row = *connection->Ask("SELECT rootpage FROM sqlite_schema WHERE name = 'session_header'");
    ASSERT_TRUE(*row.Step());
    page = row.Int(0);
  }
  bytes[static_cast<size_t>(page - 1) * 4096 + 4] ^= 1;  // the number of its cells
  std::ofstream(database_.path(), std::ios::binary) << bytes;
  const auto report = CheckStoreFile(database_.path());
  ASSERT_TRUE(report.ok()) << report.status();
  ASSERT_GT(report->damage_count, 0);
  EXPECT_EQ(report->damages[0].resource, "file");
}

TEST_F(CheckTest, WhatCannotBeLookedAtIsRefused) {
  EXPECT_EQ(CheckStoreFile(database_.path() + ".none").status().code(), absl::StatusCode::kNotFound);
  database_.Open();
  EXPECT_EQ(base::ErrorReason(CheckStoreFile(database_.path()).status()), "STORE_LOCKED");
  database_.Close();
  std::filesystem::remove(database_.path() + ".lock");
  std::ofstream(database_.path(), std::ios::binary) << std::string(4096, 'x');
  EXPECT_EQ(base::ErrorReason(CheckStoreFile(database_.path()).status()), "NOT_A_DATABASE");
  EXPECT_EQ(base::ErrorReason(CompactStore(database_.path()).status()), "NOT_A_DATABASE");
  SqliteOptions options;
  options.path = database_.path();
  EXPECT_EQ(base::ErrorReason(OpenSqlite(options).status()), "NOT_A_DATABASE");
  EXPECT_FALSE(std::filesystem::exists(database_.path() + ".lock"));
}

// The same of a database of PostgreSQL, on which its store works on. Of the run with --store=postgresql alone.
class PostgresCheck : public testing::Test {
 protected:
  void SetUp() override {
    if (TestServer::present == nullptr) GTEST_SKIP() << "needs storage_test --store=postgresql";
    database_ = std::make_unique<TempDatabase>();
    const SessionId session = StoreSession(**database_, 3);
    NewCalibration calibration = TestCalibration(database_->clock.UtcNow(), 1.0);
    calibration.sessions = {session};
    ASSERT_TRUE((*database_)->CreateCalibration(calibration).ok());
  }
  // All that is named after something was done past the guards.
  std::string NamedAfter(const std::string& sql) {
    const absl::Status done = database_->PastGuards()->Execute(sql);
    EXPECT_TRUE(done.ok()) << sql << ": " << done;
    const auto report = CheckStoreOnServer(database_->url());
    EXPECT_TRUE(report.ok()) << report.status();
    std::string all;
    if (!report.ok()) return all;
    for (const Damage& damage : report->damages) absl::StrAppend(&all, damage.resource, ": ", damage.text, "\n");
    return all;
  }

  std::unique_ptr<TempDatabase> database_;
};

TEST_F(PostgresCheck, AWholeOneIsWholeWhileAStoreHasIt) {
  const auto report = CheckStoreOnServer(database_->url());
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_THAT(report->damages, IsEmpty()) << report->damages[0].resource << ": " << report->damages[0].text;
  EXPECT_EQ(report->schema_version, PostgresMigrations().back().version);
  EXPECT_EQ(report->sessions, 1);
  EXPECT_EQ(report->chunks, 3);
  EXPECT_EQ(report->calibrations, 1);
  EXPECT_TRUE((*database_)->CreateSession(TestSession("goes on")).ok());
}

TEST_F(PostgresCheck, EachDamageOfARowIsNamed) {
  EXPECT_THAT(NamedAfter("UPDATE chunk SET content = 'x' WHERE seq = 1"), HasSubstr("sessions/1/chunks/1: "));
  EXPECT_THAT(NamedAfter("UPDATE estimate_week SET sum_um_urad = sum_um_urad + 0.001 WHERE symbol = 'EX0C'"),
              HasSubstr("machines/mt, history of EX0C, week 2810: "));
  EXPECT_THAT(NamedAfter("UPDATE audit SET principal = 'eve' WHERE id = 1"), HasSubstr("audit: "));
  EXPECT_THAT(NamedAfter("UPDATE calibration SET machine_id = 77"),
              HasSubstr("file: table calibration: 1 rows name a row of machine that is not there\n"));
  // What was found before is found still: no damage hides another one.
  const std::string all = NamedAfter("SELECT 1");
  for (const std::string place : {"sessions/1/chunks/1: ", "week 2810: ", "audit: "})
    EXPECT_THAT(all, HasSubstr(place));
}

// A rule that lets through what it shall refuse.
TEST_F(PostgresCheck, AChangedSchemaIsNamed) {
  const auto adds = [&](const std::string& sql, const std::string& line) {
    EXPECT_THAT(NamedAfter(sql), HasSubstr("schema: " + line + "\n")) << sql;
  };
  adds("ALTER TABLE audit DISABLE TRIGGER audit_is_never_changed",
       "trigger audit_is_never_changed of table audit is switched off or not valid");
  adds("DROP TRIGGER chunk_is_never_changed ON chunk", "trigger chunk_is_never_changed is not there");
  adds("CREATE OR REPLACE FUNCTION refuse() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN RETURN NEW; END $$",
       "function refuse is not what the migrations made");
  adds("DROP INDEX job_by_machine", "index job_by_machine is not there");
  adds("CREATE TABLE more (id BIGINT)", "table more is none of the migrations'");
}

// A statement that fails in the middle, as one on a page that the disk has changed does, hides nothing behind it.
TEST_F(PostgresCheck, WhatCannotBeReadHidesNothingElse) {
  const std::string all =
      NamedAfter("ALTER TABLE session_header RENAME TO elsewhere; UPDATE audit SET principal = 'eve' WHERE id = 1");
  EXPECT_THAT(all, HasSubstr("sessions/1: "));
  EXPECT_THAT(all, HasSubstr("schema: table session_header is not there\n"));
  EXPECT_THAT(all, HasSubstr("audit: "));
  EXPECT_THAT(all, testing::Not(HasSubstr("current transaction is aborted")));
}

TEST_F(PostgresCheck, RefusesWhatIsNoneOfOurs) {
  const std::string empty = TestServer::present->MakeDatabase(false);
  EXPECT_EQ(base::ErrorReason(CheckStoreOnServer(empty).status()), "NOT_A_DATABASE");
  TestServer::present->DropDatabase(empty);
  EXPECT_EQ(base::ErrorReason(CheckStoreOnServer(empty).status()), "STORE_DOWN");
  ASSERT_TRUE(database_->PastGuards()
                  ->Execute("INSERT INTO migration SELECT version + 1, 'newer', sha256, applied_at_utc_us FROM "
                            "migration ORDER BY version DESC LIMIT 1")
                  .ok());
  EXPECT_EQ(base::ErrorReason(CheckStoreOnServer(database_->url()).status()), "SCHEMA_NEWER");
}

}  // namespace
}  // namespace axiscal::storage
