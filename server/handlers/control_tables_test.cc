// A program is not corrected for a machine of whose calibrations the control may have a table.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "server/inputs/calibration_use.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::handlers {
namespace {

using ::testing::HasSubstr;

TEST(ControlTables, OfAnyCalibrationOfTheMachineRefuseItsProgramsUntilTheyAreSaidToBeOff) {
  storage::TempDatabase database;
  for (const char* id : {"mt", "other"})
    ASSERT_TRUE(database->CreateMachine(MachineId(id), "{}", storage::Cell("")).ok());
  const auto given = database->CreateCalibration(storage::TestCalibration(database.clock.UtcNow(), -90.0));
  const auto later = database->CreateCalibration(storage::TestCalibration(database.clock.UtcNow(), -80.0));
  storage::NewCalibration of_other = storage::TestCalibration(database.clock.UtcNow(), -70.0);
  of_other.machine = MachineId("other");
  const auto other = database->CreateCalibration(of_other);
  ASSERT_TRUE(given.ok() && later.ok() && other.ok()) << given.status() << later.status() << other.status();
  EXPECT_TRUE(inputs::CheckTables(*database, *given, false).ok());
  ASSERT_TRUE(database->NoteHandedTable(given->id, "siemens-cec", {"ann", ""}).ok());
  // The control has the table of calibration 1 whichever calibration the program is corrected by.
  for (const auto& calibration : {*given, *later}) {
    const absl::Status twice = inputs::CheckTables(*database, calibration, false);
    EXPECT_EQ(twice.code(), absl::StatusCode::kFailedPrecondition);
    EXPECT_EQ(base::ErrorReason(twice), "TABLE_HANDED_OUT");
    EXPECT_THAT(std::string(twice.message()),
                HasSubstr("of machine mt were handed out (siemens-cec of calibration 1 on 2023-11-14 to ann)"));
    EXPECT_THAT(std::string(twice.message()), HasSubstr("state --tables-off (tables_are_off)"));
    EXPECT_TRUE(inputs::CheckTables(*database, calibration, true).ok());
  }
  EXPECT_TRUE(inputs::CheckTables(*database, *other, false).ok());
}

TEST(ControlTables, TheNewestTenAreNamed) {
  storage::TempDatabase database;
  ASSERT_TRUE(database->CreateMachine(MachineId("mt"), "{}", storage::Cell("")).ok());
  const auto calibration = database->CreateCalibration(storage::TestCalibration(database.clock.UtcNow(), -90.0));
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  for (int i = 0; i < 12; ++i) {
    ASSERT_TRUE(database->NoteHandedTable(calibration->id, absl::StrCat("format", i), {"ann", ""}).ok());
    database.clock.Advance(std::chrono::hours(1));
  }
  const std::string text(inputs::CheckTables(*database, *calibration, false).message());
  EXPECT_THAT(text, HasSubstr("(format11 of calibration 1"));
  EXPECT_THAT(text, HasSubstr("to ann and 2 older ones)"));
  EXPECT_EQ(text.find("format1 of"), std::string::npos);
}

}  // namespace
}  // namespace axiscal::handlers
