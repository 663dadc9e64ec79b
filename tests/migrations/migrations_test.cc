// Every released schema, as a dump of a file that was in use, is opened by the present program: its schema is that of a
// new file, its rows are all there. A new release adds its dump (0002, ...); old dumps are never edited.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "core/base/testing/source_path.h"
#include "server/storage/migrate.h"
#include "server/storage/sqlite_connection.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

std::string Dump(const std::string& name) {
  std::ostringstream text;
  text << std::ifstream(base::SourcePath("/tests/migrations/") + name).rdbuf();
  return text.str();
}

std::string Schema(const std::string& path) {
  const std::unique_ptr<SqliteConnection> connection = *SqliteConnection::Open(path, Access::kReadOnly);
  Statement row =
      *connection->Ask("SELECT type, name, sql FROM sqlite_schema WHERE name NOT LIKE 'sqlite_%' ORDER BY type, name");
  std::string schema;
  while (*row.Step()) schema += row.Text(0) + " " + row.Text(1) + ": " + row.Text(2) + "\n";
  return schema;
}

class Upgrade : public testing::TestWithParam<std::string> {
 protected:
  Upgrade() {
    options.path = directory.File("old.db");
    const std::unique_ptr<SqliteConnection> connection = *SqliteConnection::Open(options.path, Access::kWrite);
    DEMAND(connection->Execute(Dump(GetParam())).ok());
  }

  TempDirectory directory;
  SqliteOptions options;
};

TEST_P(Upgrade, GivesTheSchemaOfANewFile) {
  ASSERT_TRUE(OpenSqlite(options).ok());
  SqliteOptions fresh;
  fresh.path = directory.File("new.db");
  ASSERT_TRUE(OpenSqlite(fresh).ok());
  EXPECT_EQ(Schema(options.path), Schema(fresh.path));
}

TEST_P(Upgrade, KeepsEveryRow) {
  const std::unique_ptr<Database> database = *OpenSqlite(options);
  EXPECT_EQ(database->GetMachine(MachineId("mt"))->revision, 2);
  EXPECT_EQ(database->GetMachineRevision(MachineId("mt"), 1)->description_json, "{}");
  const auto session = database->ReadSession(SessionId(1));
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->header, TestSession("").header);
  ASSERT_EQ(session->reading_count(), 30u);
  EXPECT_EQ(session->columns[1].values[12], TestColumns(1, 10)[1].values[2]);
  EXPECT_EQ(database->GetSession(SessionId(2))->state, SessionState::kOpen);
  EXPECT_EQ(*database->ExpireSessions(std::chrono::hours(1)), 0);  // begins to be left now
  const auto calibration = database->GetApprovedCalibration(MachineId("mt"));
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  EXPECT_EQ(calibration->content.estimates, TestCalibration({}, -101.2).estimates);
  EXPECT_EQ(calibration->job, JobId(1));
  const auto drift =
      database->QueryDrift({MachineId("mt"), {"EA0B"}, base::FromUtcUs(0), base::FromUtcUs(1'800'000'000'000'000), 1});
  ASSERT_EQ(drift->at(0).points.size(), 1u);
  EXPECT_EQ(drift->at(0).points[0].count, 2);
  EXPECT_EQ(database->GetJob(JobId(1))->result, "result");
  EXPECT_EQ(database->GetJob(JobId(2))->state, JobState::kQueued);  // ran when the file was left
  EXPECT_EQ((*database->ClaimJob(std::chrono::seconds(30)))->id, JobId(2));
  std::string program;
  ASSERT_TRUE(database
                  ->ReadProgram(ProgramId(1), 0,
                                [&](const std::string& bytes) {
                                  program += bytes;
                                  return absl::OkStatus();
                                })
                  .ok());
  EXPECT_EQ(program, "G01 X1\n");
  EXPECT_FALSE(database->ListAudit({})->rows.empty());
  // What nobody has looked for events in is looked at.
  EXPECT_EQ(*database->MachinesToLookAt("1"), std::vector{MachineId("mt")});
  EXPECT_TRUE(database->CheckAudit().ok()) << database->CheckAudit().status();
}

// A candidate that was retired without ever having been approved is no point of the history: sums over weeks that were
// made with it are made again. Beside it stand two that count.
TEST_P(Upgrade, TakesRejectedCandidatesOutOfTheHistory) {
  DEMAND((*SqliteConnection::Open(options.path, Access::kWrite))
             ->Execute("UPDATE calibration SET state = 3, retired_at_utc_us = 1700086400000000 WHERE id = 2;"
                       "INSERT INTO calibration SELECT 3, machine_id, 3, machine_revision, 1, 1, NULL, "
                       "1700050000000000, model_json, options_json, report_json, engine_version, rank, condition, "
                       "chi2_per_dof, rms_before_um, rms_after_um, created_by, 1700050000000000, NULL, NULL, NULL "
                       "FROM calibration WHERE id = 2;"
                       "INSERT INTO estimate VALUES(1,'EA0B',1700050000000000,3,1,2,1,-110.0,0.4);"
                       "UPDATE estimate_week SET estimate_count = 3, min_um_urad = -110.0, "
                       "sum_um_urad = sum_um_urad - 110.0 WHERE symbol = 'EA0B'")
             .ok());
  const std::unique_ptr<Database> database = *OpenSqlite(options);
  const auto rejected = database->GetCalibration(CalibrationId(2));
  ASSERT_TRUE(rejected.ok()) << rejected.status();
  EXPECT_EQ(rejected->state, CalibrationState::kRetired);
  const std::unique_ptr<SqliteConnection> connection = *SqliteConnection::Open(options.path, Access::kReadOnly);
  Statement week = *connection->Ask(
      "SELECT symbol, estimate_count, not_identifiable_count, min_um_urad, max_um_urad, "
      "round(sum_um_urad, 6), last_at_utc_us, last_sigma_um_urad, last_calibration_id "
      "FROM estimate_week WHERE symbol IN ('EA0B', 'EC0C') ORDER BY symbol");
  std::string sums;
  while (*week.Step()) {
    for (int column = 0; column < 9; ++column) sums += (column > 0 ? "," : "") + week.Text(column);
    sums += "\n";
  }
  EXPECT_EQ(sums, "EA0B,2,0,-110.0,-101.2,-211.2,1700050000000000,0.4,3\nEC0C,0,1,,,,,,\n");
}

TEST_P(Upgrade, GivesCalibrationsAndDescriptionsTheirChecksums) {
  std::unique_ptr<Database> database = *OpenSqlite(options);
  ASSERT_TRUE(database->GetApprovedCalibration(MachineId("mt")).ok());
  database.reset();
  DEMAND((*SqliteConnection::Open(options.path, Access::kWrite))
             ->Execute("UPDATE estimate SET estimated_um_urad = 7.0 WHERE identifiable = 1")
             .ok());
  database = *OpenSqlite(options);
  EXPECT_TRUE(absl::IsDataLoss(database->GetApprovedCalibration(MachineId("mt")).status()));
  database.reset();
  DEMAND((*SqliteConnection::Open(options.path, Access::kWrite))
             ->Execute("UPDATE machine_revision SET description_json = '9'")
             .ok());
  database = *OpenSqlite(options);
  EXPECT_TRUE(absl::IsDataLoss(database->GetMachine(MachineId("mt")).status()));
}

INSTANTIATE_TEST_SUITE_P(Released, Upgrade, testing::Values("v0001.sql"));

}  // namespace
}  // namespace axiscal::storage
