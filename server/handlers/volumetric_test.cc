#include "server/handlers/volumetric.h"

#include <gtest/gtest.h>

#include "server/handlers/testing/test_core.h"
#include "server/storage/testing/caught_statements.h"

namespace axiscal::handlers {
namespace {

// Calibrations of a machine of which nothing is known but that they are there: the list says so of each.
class VolumetricPages : public ::testing::Test, protected storage::CaughtStatements, protected TestCore {
 protected:
  void SetUp() override { session_ = storage::StoreSession(*database, 1); }  // and its machine
  CalibrationId Store() {
    storage::NewCalibration calibration;
    calibration.machine = MachineId("mt");
    calibration.machine_revision = 1;
    calibration.measured_at = database.clock.UtcNow();
    calibration.model_json = calibration.options_json = calibration.report_json = "{}";
    calibration.sessions = {session_};
    const auto stored = database->CreateCalibration(calibration);
    EXPECT_TRUE(stored.ok()) << stored.status();
    return stored.ok() ? stored->id : CalibrationId();
  }
  v1::ListVolumetricErrorsResponse Page(int size, const std::string& token) {
    v1::ListVolumetricErrorsRequest request;
    request.set_machine_id("mt");
    request.set_page_size(size);
    request.set_page_token(token);
    const auto page = ListVolumetricErrors(core, call, request);
    EXPECT_TRUE(page.ok()) << page.status();
    return page.ok() ? *page : v1::ListVolumetricErrorsResponse();
  }
  // The calibrations of all pages.
  std::vector<int64_t> All(int size) {
    std::vector<int64_t> ids;
    std::string token;
    do {
      const v1::ListVolumetricErrorsResponse page = Page(size, token);
      EXPECT_LE(page.errors_size(), size);
      for (const v1::VolumetricError& error : page.errors()) ids.push_back(error.calibration_id());
      token = page.next_page_token();
    } while (!token.empty());
    return ids;
  }

  SessionId session_;
};

TEST_F(VolumetricPages, HaveEachCalibrationOnceButThoseGivenUp) {
  std::vector<CalibrationId> ids;
  for (int i = 0; i < 9; ++i) ids.push_back(Store());
  for (const int given_up : {0, 3, 4, 5})
    ASSERT_TRUE(database->RetireCalibration(ids[given_up], 0, {"tester", ""}).ok());
  std::vector<int64_t> expected;
  for (const int i : {8, 7, 6, 2, 1}) expected.push_back(ids[i].number());
  for (const int size : {1, 2, 3, 5, 100}) EXPECT_EQ(All(size), expected) << size;
}

TEST_F(VolumetricPages, CostTheSameHoweverManyCalibrationsThereAre) {
  const auto cost_of_a_page = [&] {
    const int64_t before = steps();
    EXPECT_EQ(Page(3, Page(3, "").next_page_token()).errors_size(), 3);
    return steps() - before;
  };
  for (int i = 0; i < 30; ++i) Store();
  const int64_t of_few = cost_of_a_page();
  for (int i = 0; i < 300; ++i) Store();
  EXPECT_LT(cost_of_a_page(), 2 * of_few);
}

TEST_F(VolumetricPages, RefuseATokenOfAnotherList) {
  for (int i = 0; i < 3; ++i) Store();
  const std::string token = Page(1, "").next_page_token();
  v1::ListVolumetricErrorsRequest request;
  request.set_machine_id("mt");
  request.set_page_token(token);
  v1::AxisSpan& span = *request.add_box();
  span.set_axis("X");
  span.set_to_mm_or_deg(1.0);
  EXPECT_EQ(base::ErrorReason(ListVolumetricErrors(core, call, request).status()), "PAGE_INVALID");
}

}  // namespace
}  // namespace axiscal::handlers
