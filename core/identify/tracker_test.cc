// A tracker that moves while it measures, seen by reference targets beside the machine.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <variant>

#include "core/identify/identify.h"
#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"
#include "core/synthetic/simulate.h"

namespace axiscal::identify {
namespace {

const machine::Machine kMachine = machine::testing::MultiTasking();
constexpr int kReferences = 3, kLooks = 4, kPosesBetween = 9;

// Looks at three reference targets with poses of X and Z in between, B turned in some: where the target stands along B,
// which is Y, no reading tells.
session::Session Plan() {
  session::Session session;
  session.header = {{"machine", "mt"},
                    {"session", "station"},
                    {"instrument", "tracker"},
                    {"sigma_um", "5"},
                    {"tool_tip_mm", "0 0 -150"},
                    {"reference R1", "-540 -430 -470"},
                    {"reference R2", "540 -490 -370"},
                    {"reference R3", "50 540 230"}};
  session.columns = {{"t_s", {}, {}},   {"Z_mm", {}, {}},  {"Y_mm", {}, {}},  {"X_mm", {}, {}},
                     {"B_deg", {}, {}}, {"C_deg", {}, {}}, {"target", {}, {}}};
  double time_s = 0.0;
  const auto add = [&](const std::string& target, double x_mm, double z_mm, double b_deg) {
    const double row[] = {time_s, z_mm, 0.0, x_mm, b_deg, 0.0};
    for (size_t i = 0; i < std::size(row); ++i) session.columns[i].values.push_back(row[i]);
    session.columns.back().texts.push_back(target);
    // The tracker goes on from look to look: a look is short, so that it has one pose.
    time_s += target == "tool" ? 60.0 : 0.01;
  };
  for (int look = 0; look < kLooks; ++look) {
    for (int i = 1; i <= kReferences; ++i) add(absl::StrCat("R", i), 0.0, 0.0, 0.0);
    for (int k = 0; k < kPosesBetween && look + 1 < kLooks; ++k)
      add("tool", -250.0 + 250.0 * (k % 3), -200.0 + 200.0 * (k / 3), look == 1 ? 20.0 * k - 90.0 : 0.0);
  }
  return session;
}

Eigen::Matrix3Xd Places(const session::Session& session) {
  const size_t first = session.columns.size() - 3, rows = session.columns[0].values.size();
  Eigen::Matrix3Xd places_mm(3, static_cast<Eigen::Index>(rows));
  for (size_t k = 0; k < rows; ++k) {
    for (size_t i = 0; i < 3; ++i)
      places_mm(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = session.columns[first + i].values[k];
  }
  return places_mm;
}

// How far the references' motion takes a point in the middle of all readings, at the look where it goes farthest, um.
double WentUm(const Eigen::Matrix3Xd& places_mm) {
  const Eigen::Vector3d middle_mm = places_mm.rowwise().mean();
  double most_mm = 0.0;
  for (int look = 1; look < kLooks; ++look) {
    const Eigen::Matrix4d motion =
        Eigen::umeyama(places_mm.leftCols<kReferences>().eval(),
                       places_mm.middleCols<kReferences>(look * (kReferences + kPosesBetween)).eval(), false);
    const Eigen::Vector3d moved_mm =
        motion.topLeftCorner<3, 3>() * middle_mm + motion.topRightCorner<3, 1>() - middle_mm;
    most_mm = std::max(most_mm, moved_mm.norm());
  }
  return 1e3 * most_mm;
}

// The tracker stands three metres away and turns by some 0.3 mrad: what its own axes' origin does is a matter of where
// they are taken to stand, and no measure of how far the targets seemed to go.
TEST(Tracker, HowFarItMovedIsWhatItsReferencesShow) {
  const machine::ErrorModel truth = *machine::ReadErrors(
      R"({"terms": [{"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 60}]})", kMachine);
  const Eigen::Isometry3d far_away = Eigen::Translation3d(-3100.0, 1250.0, 180.0) *
                                     Eigen::AngleAxisd(0.8, Eigen::Vector3d(0.05, -0.1, 1.0).normalized());
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    synthetic::NoiseOptions noise;
    noise.seed = seed;
    auto measured = synthetic::Simulate(kMachine, truth, Plan(), noise);
    ASSERT_TRUE(measured.ok()) << measured.status();
    const Eigen::Matrix3Xd places_mm = far_away * Places(*measured);
    for (size_t i = 0; i < 3; ++i) {
      std::vector<double>& values = measured->columns[measured->columns.size() - 3 + i].values;
      for (size_t k = 0; k < values.size(); ++k)
        values[k] = places_mm(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
    }
    Options options;
    options.model = truth;
    const auto result = Identify(kMachine, {*measured}, options);
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_LT(result->fit.chi2_per_dof, 1.5);
    const reports::TrackerMoved* moved = nullptr;
    for (const reports::WarningFacts& facts : result->warnings) {
      if (const auto* const one = std::get_if<reports::TrackerMoved>(&facts)) moved = one;
    }
    ASSERT_NE(moved, nullptr);
    EXPECT_LT(moved->sigma_um, 20.0);
    EXPECT_NEAR(moved->moved_um, WentUm(places_mm), 4.0 * moved->sigma_um);
  }
}

}  // namespace
}  // namespace axiscal::identify
