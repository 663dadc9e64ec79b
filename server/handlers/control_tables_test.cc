// A program is not corrected by a calibration of which a control may have a table.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "server/inputs/calibration_use.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::handlers {
namespace {

using ::testing::HasSubstr;

TEST(ControlTables, OfACalibrationRefuseItsProgramsUntilTheyAreSaidToBeOff) {
  storage::TempDatabase database;
  ASSERT_TRUE(database->CreateMachine(MachineId("mt"), "{}", storage::Cell("")).ok());
  const auto given = database->CreateCalibration(storage::TestCalibration(database.clock.UtcNow(), -90.0));
  const auto other = database->CreateCalibration(storage::TestCalibration(database.clock.UtcNow(), -80.0));
  ASSERT_TRUE(given.ok() && other.ok()) << given.status() << other.status();
  EXPECT_TRUE(inputs::CheckTables(*database, given->id, false).ok());
  ASSERT_TRUE(database->NoteHandedTable(given->id, "siemens-cec", {"ann", ""}).ok());
  const absl::Status twice = inputs::CheckTables(*database, given->id, false);
  EXPECT_EQ(twice.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(base::ErrorReason(twice), "TABLE_HANDED_OUT");
  EXPECT_THAT(std::string(twice.message()),
              HasSubstr("calibration 1 were handed out (siemens-cec on 2023-11-14 to ann)"));
  EXPECT_TRUE(inputs::CheckTables(*database, given->id, true).ok());
  EXPECT_TRUE(inputs::CheckTables(*database, other->id, false).ok());
}

}  // namespace
}  // namespace axiscal::handlers
