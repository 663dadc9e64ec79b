#include "server/storage/copy_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/base/error_detail.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

using testing::HasSubstr;

// Of the run with --store=postgresql alone: from a file to a server's database, and back into another file.
class CopyStore : public testing::Test {
 protected:
  void SetUp() override {
    if (TestServer::present == nullptr) GTEST_SKIP() << "needs storage_test --store=postgresql";
    url_ = TestServer::present->MakeDatabase(false);
    const std::unique_ptr<Database> database = OpenFile("a.db");
    ASSERT_NE(database, nullptr);
    session_ = StoreSession(*database, 40);
    for (int day = 0; day < 20; ++day)
      ASSERT_TRUE(database->CreateCalibration(TestCalibration(base::FromUtcUs(day * 86'400'000'000), day)).ok());
    ASSERT_TRUE(database->RetireCalibration(CalibrationId(3), 0, Cell("")).ok());
    ASSERT_TRUE(database->CreatePrincipal("ann", "", Cell("")).ok());
    for (int i = 0; i < 30; ++i) {
      AuditEntry entry;
      entry.principal = "ann";
      entry.action = absl::StrCat("action ", i);
      entry.outcome = "OK";
      ASSERT_TRUE(database->AppendAudit(entry).ok());
    }
    // Of two programs with the same bytes the one that was begun first names the other.
    const auto first = database->BeginProgram(TestProgram("1")), second = database->BeginProgram(TestProgram("2"));
    for (const auto& program : {second, first}) {
      ASSERT_TRUE(program.ok()) << program.status();
      ASSERT_TRUE(database->AppendProgram(program->id, 0, "G1 X1\n").ok());
      ASSERT_TRUE(database->FinishProgram(program->id, 6, "").ok());
    }
  }
  void TearDown() override {
    if (!url_.empty()) TestServer::present->DropDatabase(url_);
  }
  static NewProgram TestProgram(const std::string& request_id) {
    NewProgram program;
    program.kind = "nc";
    program.name = "a.nc";
    program.caller = Cell(request_id);
    return program;
  }
  std::unique_ptr<Database> OpenFile(const std::string& name) {
    SqliteOptions options;
    options.path = File(name);
    absl::StatusOr<std::unique_ptr<Database>> database = OpenSqlite(options);
    EXPECT_TRUE(database.ok()) << database.status();
    return database.ok() ? *std::move(database) : nullptr;
  }
  std::string File(const std::string& name) const { return directory_.File(name); }
  absl::StatusOr<CopyResult> Copy(const std::string& from, const std::string& to, int64_t most_rows = 1 << 30) {
    return CopyStoreTo(from, to, base::FromUtcUs(1), [&](const CopyProgress& progress) {
      return progress.rows <= most_rows ? absl::OkStatus() : absl::CancelledError("enough");
    });
  }

  TempDirectory directory_;
  std::string url_;
  SessionId session_;
};

TEST_F(CopyStore, ThereAndBackItIsTheSame) {
  const auto there = Copy(File("a.db"), url_);
  ASSERT_TRUE(there.ok()) << there.status();
  EXPECT_GT(there->rows, 200);
  const auto back = Copy(url_, File("b.db"));
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(back->rows, there->rows);
  EXPECT_EQ(back->sha256, there->sha256);
  // Structure, references, checksums, the chain of the audit.
  const auto check = CheckStoreFile(File("b.db"));
  ASSERT_TRUE(check.ok()) << check.status();
  EXPECT_EQ(check->damage_count, 0) << check->damages[0].resource << ": " << check->damages[0].text;
  EXPECT_EQ(check->audit.sha256, CheckStoreFile(File("a.db"))->audit.sha256);
}

TEST_F(CopyStore, WorkGoesOnAtTheNewPlace) {
  ASSERT_TRUE(Copy(File("a.db"), url_).ok());
  PostgresOptions options;
  options.url = url_;
  const auto database = OpenPostgres(options);
  ASSERT_TRUE(database.ok()) << database.status();
  const auto former = OpenFile("a.db");
  EXPECT_TRUE(*(*database)->ReadSession(session_) == *former->ReadSession(session_));
  // Numbers go on behind those that were given.
  EXPECT_EQ((*database)->BeginProgram(TestProgram("3"))->id, former->BeginProgram(TestProgram("3"))->id);
  EXPECT_EQ((*database)->CreateSession(TestSession("r-2"))->id, former->CreateSession(TestSession("r-2"))->id);
  AuditEntry entry;
  entry.principal = "ann";
  entry.action = "one more";
  entry.outcome = "OK";
  ASSERT_TRUE((*database)->AppendAudit(entry).ok());
  // The same request is the same row.
  EXPECT_EQ((*database)->BeginProgram(TestProgram("1"))->id, former->BeginProgram(TestProgram("1"))->id);
}

// Where axiscald has worked, things of its own stand beside the numbers of tables: no copy takes them for one.
TEST_F(CopyStore, AStoreInUseGoesFromServerToServerAndIntoAFileAndBack) {
  ASSERT_TRUE(Copy(File("a.db"), url_).ok());
  {
    PostgresOptions options;
    options.url = url_;
    const auto server = OpenPostgres(options);
    ASSERT_TRUE(server.ok()) << server.status();
    (*server)->Follow([](const News&) {});
    EXPECT_TRUE((*server)->IsCaretaker());
    (*server)->StopFollowing();
  }
  const std::string second = TestServer::present->MakeDatabase(false), third = TestServer::present->MakeDatabase(false);
  EXPECT_TRUE(Copy(url_, second).ok());
  EXPECT_TRUE(Copy(second, File("b.db")).ok());
  EXPECT_TRUE(Copy(File("b.db"), third).ok());
  TestServer::present->DropDatabase(second);
  TestServer::present->DropDatabase(third);
}

TEST_F(CopyStore, OneThatIsBrokenOffGoesOnAndIsNoStoreMeanwhile) {
  const auto whole = Copy(File("a.db"), File("whole.db"));
  ASSERT_TRUE(whole.ok()) << whole.status();
  for (int64_t most = 0; most < whole->rows; most += 37) {
    ASSERT_TRUE(absl::IsCancelled(Copy(File("a.db"), url_, most).status()));
    PostgresOptions options;
    options.url = url_;
    EXPECT_EQ(base::ErrorReason(OpenPostgres(options).status()), "COPY_UNFINISHED");
    EXPECT_EQ(base::ErrorReason(Copy(url_, File("c.db")).status()), "COPY_UNFINISHED");
  }
  const auto rest = Copy(File("a.db"), url_);
  ASSERT_TRUE(rest.ok()) << rest.status();
  EXPECT_GT(rest->rows_before, 0);
  EXPECT_EQ(rest->sha256, whole->sha256);
}

TEST_F(CopyStore, WhatIsNoNewDatabaseOrHasChangedIsRefused) {
  OpenFile("b.db")->CreateMachine(MachineId("other"), "{}", Cell("")).IgnoreError();
  EXPECT_EQ(base::ErrorReason(Copy(File("a.db"), File("b.db")).status()), "COPY_NOT_EMPTY");
  EXPECT_TRUE(absl::IsNotFound(Copy(File("none.db"), url_).status()));
  ASSERT_TRUE(absl::IsCancelled(Copy(File("a.db"), url_, 250).status()));
  EXPECT_EQ(base::ErrorReason(Copy(File("b.db"), url_).status()), "COPY_NOT_EMPTY") << "of another source";
  {
    const std::unique_ptr<Database> held = OpenFile("a.db");
    EXPECT_EQ(base::ErrorReason(Copy(File("a.db"), url_).status()), "STORE_LOCKED");
    ASSERT_TRUE(held->RetireCalibration(CalibrationId(1), 0, Cell("")).ok());
  }
  EXPECT_EQ(base::ErrorReason(Copy(File("a.db"), url_).status()), "COPY_DIFFERS");
}

// The audit begins where age has left it, and its chain at the anchor.
TEST_F(CopyStore, AnAuditWhoseStartHasLeftIsCarriedOver) {
  TempDirectory other;
  SqliteOptions options;
  options.path = other.File("aged.db");
  base::FakeClock clock;
  options.clock = &clock;
  {
    const std::unique_ptr<Database> database = *OpenSqlite(options);
    const auto keep_house = [&] { ASSERT_TRUE(database->ExpireSessions(std::chrono::hours(24'000)).ok()); };
    for (int day = 0; day < 6; ++day) {
      ASSERT_TRUE(database->CreateMachine(MachineId(absl::StrCat("m", day)), "{}", Cell("")).ok());
      keep_house();
      clock.Advance(std::chrono::hours(24));
    }
    keep_house();
    ASSERT_GT(*database->ExpireAudit(std::chrono::hours(48)), 0);
  }
  const auto there = Copy(options.path, url_);
  ASSERT_TRUE(there.ok()) << there.status();
  const auto back = Copy(url_, other.File("back.db"));
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(back->sha256, there->sha256);
  const auto check = CheckStoreFile(other.File("back.db"));
  ASSERT_TRUE(check.ok()) << check.status();
  EXPECT_EQ(check->damage_count, 0);
  EXPECT_EQ(check->audit.sha256, CheckStoreFile(options.path)->audit.sha256);
}

// Nothing is changed, and no lock is left beside what is no file of ours.
TEST_F(CopyStore, WhatIsNoStoreIsLeftAsItWas) {
  std::ofstream(File("words")) << std::string(5000, 'x');
  std::ofstream(File("empty")) << "";
  for (const auto& [from, to] : {std::pair("words", "c.db"), {"empty", "c.db"}, {"a.db", "words"}, {"a.db", "a.db"}}) {
    const absl::Status status = Copy(File(from), File(to)).status();
    EXPECT_FALSE(status.ok()) << from << " " << to;
    // Named once.
    EXPECT_THAT(std::string(status.message()), testing::Not(testing::ContainsRegex("\\.db: .*\\.db: "))) << status;
  }
  EXPECT_EQ(std::filesystem::file_size(File("words")), 5000u);
  EXPECT_EQ(std::filesystem::file_size(File("empty")), 0u);
  EXPECT_FALSE(std::filesystem::exists(File("words.lock")));
  EXPECT_FALSE(std::filesystem::exists(File("c.db")));
}

TEST_F(CopyStore, WhatIsDamagedIsNotCarriedOverAsWhole) {
  const auto damage = [&](const std::string& sql) {
    const absl::Status status = (*SqliteConnection::Open(File("a.db"), Access::kWrite))->Execute(sql);
    ASSERT_TRUE(status.ok()) << status;
  };
  damage("UPDATE estimate SET estimated_um_urad = 7 WHERE calibration_id = 5 AND symbol = 'EX0C'");
  EXPECT_TRUE(absl::IsDataLoss(Copy(File("a.db"), url_).status()));
  damage("UPDATE estimate SET estimated_um_urad = 53.1 WHERE calibration_id = 5 AND symbol = 'EX0C'");
  damage("UPDATE machine_revision SET description_json = '{ }'");
  const absl::Status damaged = Copy(File("a.db"), url_).status();
  EXPECT_TRUE(absl::IsDataLoss(damaged)) << damaged;
  EXPECT_THAT(std::string(damaged.message()), HasSubstr("machine"));
}

}  // namespace
}  // namespace axiscal::storage
