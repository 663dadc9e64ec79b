#include "server/handlers/approve_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/handlers/make_table.h"
#include "server/handlers/testing/test_core.h"

namespace axiscal::handlers {
namespace {

using ::testing::HasSubstr;

class Approval : public ::testing::Test, protected TestCore {
 protected:
  absl::Status Approve(const records::Estimate& estimate) {
    storage::NewCalibration calibration = storage::TestCalibration(database.clock.UtcNow(), -90.0);
    calibration.estimates.push_back(estimate);
    const auto stored = database->CreateCalibration(calibration);
    EXPECT_TRUE(stored.ok()) << stored.status();
    v1::ApproveCalibrationRequest request;
    request.set_calibration_id(stored->id.number());
    request.set_etag(1);
    request.set_reason("first");
    return ApproveCalibration(core, call, request).status();
  }
};

TEST_F(Approval, IsRefusedToWhatNoMachineHas) {
  ASSERT_TRUE(database->CreateMachine(MachineId("mt"), kMachineJson, storage::Cell("")).ok());
  using records::EstimateUnit;
  const records::Estimate metres = {"EXX:linear", EstimateUnit::kUm, true, -999'000.0, 12.0};
  const absl::Status refused = Approve(metres);
  EXPECT_EQ(refused.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(base::ErrorReason(refused), "CALIBRATION_NOT_PLAUSIBLE");
  EXPECT_THAT(std::string(refused.message()), HasSubstr("has EXX:linear = -999000 um, no machine has more than 20000"));
  EXPECT_EQ(base::ErrorReason(Approve({"EZ0T", EstimateUnit::kUm, true, 25'000.0, 1.0})), "CALIBRATION_NOT_PLAUSIBLE");
  EXPECT_EQ(base::ErrorReason(Approve({"EC0A", EstimateUnit::kUrad, true, 1e6, 1.0})), "CALIBRATION_NOT_PLAUSIBLE");
  // A joint that was put together anew, a tool that is 3 mm off: a person decides, who has read the warning.
  const absl::Status joint = Approve({"EC02", EstimateUnit::kUrad, true, 35'000.0, 100.0});
  EXPECT_TRUE(joint.ok()) << joint;
  const absl::Status tool = Approve({"EZ0T", EstimateUnit::kUm, true, 3'145.0, 1.0});
  EXPECT_TRUE(tool.ok()) << tool;
}

TEST_F(Approval, NorIsATableMadeOfIt) {
  ASSERT_TRUE(database->CreateMachine(MachineId("mt"), kMachineJson, storage::Cell("")).ok());
  EXPECT_FALSE(Approve({"EXX:linear", records::EstimateUnit::kUm, true, -999'000.0, 12.0}).ok());
  v1::MakeTableRequest request;
  request.set_machine_id("mt");
  request.set_calibration_id(1);  // the candidate
  request.set_format("general");
  for (const double mm : {0.0, 0.0, -150.0}) request.add_tool_tip_mm(mm);
  EXPECT_EQ(base::ErrorReason(MakeTable(core, call, request).status()), "CALIBRATION_NOT_PLAUSIBLE");
}

}  // namespace
}  // namespace axiscal::handlers
