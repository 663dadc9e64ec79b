#include "server/handlers/list_residuals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/session/checksum.h"
#include "server/handlers/calibration_fit.h"
#include "server/handlers/testing/test_core.h"

namespace axiscal::handlers {
namespace {

constexpr int kSessions = 3, kReadings = 80, kRows = 3;

// Calibrations of three tracker sessions.
class Residuals : public ::testing::Test, protected TestCore {
 protected:
  void SetUp() override {
    ASSERT_TRUE(database->CreateMachine(MachineId("mt"), kMachineJson, {"tester", ""}).ok());
    for (int i = 0; i < kSessions; ++i) ASSERT_NO_FATAL_FAILURE(StoreTracker(i));
    first_ = StoreCalibration(10.0);
    second_ = StoreCalibration(20.0);
  }
  void StoreTracker(int number) {
    storage::NewSession asked;
    asked.machine = MachineId("mt");
    asked.name = absl::StrCat("T", number);
    asked.instrument = "tracker";
    asked.header = {{"machine", "mt"},
                    {"session", asked.name},
                    {"instrument", "tracker"},
                    {"sigma_um", "5"},
                    {"tool_tip_mm", "0 0 -100"}};
    std::vector<session::Column> columns;
    for (const char* name : {"X_mm", "Y_mm", "Z_mm", "C_deg", "px_mm", "py_mm", "pz_mm"}) {
      asked.columns.push_back({name, false});
      columns.push_back({name, {}, {}});
    }
    for (int k = 0; k < kReadings; ++k) {
      const double x = 10.0 * (k % 9), y = 7.0 * (k % 11), z = 5.0 * (k % 13), off = 1e-3 * ((k * 7) % 5 - 2);
      const double row[] = {x, y, z, 0.0, x + off, y - off, z - 100.0};
      for (size_t i = 0; i < columns.size(); ++i) columns[i].values.push_back(row[i]);
    }
    const auto stored = database->CreateSession(asked);
    ASSERT_TRUE(stored.ok()) << stored.status();
    ASSERT_TRUE(storage::Append(*database, stored->id, 0, columns).ok());
    ASSERT_TRUE(
        database->FinishSession(stored->id, {1, kReadings, session::SessionHash({session::ChunkCrc32c(columns)})})
            .ok());
    sessions_.push_back(stored->id);
  }
  CalibrationId StoreCalibration(double ex0c_um) {
    storage::NewCalibration calibration;
    calibration.machine = MachineId("mt");
    calibration.machine_revision = 1;
    calibration.measured_at = database.clock.UtcNow();
    calibration.model_json = absl::StrCat("{\"EX0C\": ", ex0c_um, "}");
    calibration.options_json = calibration.report_json = "{}";
    calibration.sessions = sessions_;
    const auto stored = database->CreateCalibration(calibration);
    EXPECT_TRUE(stored.ok()) << stored.status();
    return stored.ok() ? stored->id : CalibrationId();
  }
  // The page behind `token`, and the token of the next.
  v1::ListResidualsResponse Page(CalibrationId id, const std::string& token) {
    v1::ListResidualsRequest request;
    request.set_calibration_id(id.number());
    request.set_page_size(kPage);
    request.set_page_token(token);
    const auto page = ListResiduals(core, call, request);
    EXPECT_TRUE(page.ok()) << page.status();
    return page.ok() ? *page : v1::ListResidualsResponse();
  }
  // Session and number of all readings, page after page.
  std::multiset<std::pair<int64_t, int64_t>> ReadAll(CalibrationId id) {
    std::multiset<std::pair<int64_t, int64_t>> read;
    std::string token;
    do {
      const v1::ListResidualsResponse page = Page(id, token);
      for (const v1::Residual& one : page.residuals()) read.emplace(one.session_id(), one.reading());
      token = page.next_page_token();
    } while (!token.empty());
    return read;
  }

  static constexpr int kPage = 7;
  std::vector<SessionId> sessions_;
  CalibrationId first_, second_;
};

TEST_F(Residuals, OfALargeCalibrationComeOffOneFit) {
  core.fits = std::make_shared<CalibrationFits>(0);  // any calibration is larger
  const auto read = ReadAll(first_);
  EXPECT_EQ(read.size(), static_cast<size_t>(kSessions * kReadings));
  EXPECT_EQ(std::set(read.begin(), read.end()).size(), read.size());  // none twice
  EXPECT_EQ(core.fits->fitted(), 1);
  const int64_t bytes = core.fits->bytes();
  EXPECT_GT(bytes, int64_t{2} * kSessions * kReadings * kRows * static_cast<int64_t>(sizeof(double)));
  EXPECT_LT(bytes, int64_t{80} * kSessions * kReadings * kRows);
  // Another one takes its place: what is kept does not grow.
  EXPECT_EQ(ReadAll(second_).size(), read.size());
  EXPECT_EQ(core.fits->fitted(), 2);
  EXPECT_EQ(core.fits->bytes(), bytes);
  Page(first_, "");
  EXPECT_EQ(core.fits->fitted(), 3);
}

TEST_F(Residuals, OfSeveralAreKeptAsLongAsThereIsRoom) {
  Page(first_, "");
  core.fits = std::make_shared<CalibrationFits>(2 * core.fits->bytes());
  std::string first, second;
  int pages = 0;
  do {
    first = Page(first_, first).next_page_token();
    second = Page(second_, second).next_page_token();
    ++pages;
  } while (!first.empty() && !second.empty());
  EXPECT_EQ(pages, (kSessions * kReadings + kPage - 1) / kPage);
  EXPECT_EQ(core.fits->fitted(), 2);
  // A third one takes the place of that which was asked for least lately.
  const CalibrationId third = StoreCalibration(30.0);
  Page(third, "");
  Page(second_, "");
  EXPECT_EQ(core.fits->fitted(), 3);
  Page(first_, "");
  EXPECT_EQ(core.fits->fitted(), 4);
}

}  // namespace
}  // namespace axiscal::handlers
