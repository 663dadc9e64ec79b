#include <gtest/gtest.h>

#include <cmath>

#include "core/base/units.h"
#include "core/identify/testing/scenario.h"
#include "core/instruments/evaluation.h"
#include "core/plan/test.h"
#include "core/plan/tests_internal.h"

namespace axiscal::plan {
namespace {

// The machine of the paper: the work-side axes count against the right hand.
machine::Machine Dmu80() {
  machine::Machine machine = machine::testing::Make(
      "dmu80t", {machine::testing::Linear("X", {1, 0, 0}), machine::testing::Linear("Y", {0, 1, 0})},
      {machine::testing::Linear("Z", {0, 0, -1}), machine::testing::Rotary("C", {0, 0, -1}, {0, 0, 0})}, {});
  return machine;
}

Mounted Published() {
  Mounted mounted;
  mounted.tips_mm = {{250, 0, 100}};
  mounted.balls_mm = {{100, 0, 100}};
  mounted.bars_mm = {150};
  return mounted;
}

// Chang 2019, 21 and 26: X from 250 to 50 mm from C, relative to home 0 to -200; the bar stays 150 mm.
TEST(LinkedTest, IsThePublishedTrajectory) {
  const machine::Machine machine = Dmu80();
  const Situation situation = SituationOfMachine(machine, Published());
  const std::vector<PlannedSession> planned = FindTest("ballbar-linked")->plan(situation);
  ASSERT_EQ(planned.size(), 4u);
  const session::Session& xc = planned[0].session;
  EXPECT_EQ(*session::FindHeader(xc, "table_ball_mm"), "100 0 100");
  const std::vector<double>& x_mm = session::FindColumn(xc, "X_mm")->values;
  const std::vector<double>& c_deg = session::FindColumn(xc, "C_deg")->values;
  EXPECT_NEAR(x_mm[0], 0.0, 1e-4);
  EXPECT_NEAR(x_mm[180], -200.0, 1e-4);
  EXPECT_NEAR(c_deg[0], 0.0, 1e-4);
  EXPECT_NEAR(c_deg[180], 180.0, 1e-4);
  EXPECT_NEAR(c_deg[360], 360.0, 1e-4);
  for (size_t k = 0; k < c_deg.size(); ++k) {
    const double t = c_deg[k] * base::kRadPerDeg;
    const double x_abs_mm = 100 * std::cos(t) + std::sqrt(150 * 150 - 1e4 * std::sin(t) * std::sin(t));
    EXPECT_NEAR(x_mm[k] + 250.0, x_abs_mm, 2e-4) << k;
    // Equal steps along the spindle ball's circle about the table ball: constant path speed (24, 26).
    if (k == 0 || k > 360) continue;
    const auto in_table = [&](size_t i) {
      const double angle = c_deg[i] * base::kRadPerDeg, out = x_mm[i] + 250.0;
      return Eigen::Vector2d(out * std::cos(angle), out * std::sin(angle));
    };
    EXPECT_NEAR((in_table(k) - in_table(k - 1)).norm(), 2 * 150 * std::sin(base::kRadPerDeg / 2), 1e-3);
  }
  for (const PlannedSession& session : planned) EXPECT_TRUE(KeepsTheBar(machine, session.session)) << session.text;
}

// 24 as printed adds 250 again: the bar would be 375 to 400 mm.
TEST(LinkedTest, PrintedTrajectoryTearsTheBar) {
  const double wrong_mm = 250.0 + 250.0 - 100.0;  // at t = 0
  EXPECT_NEAR(wrong_mm, 400.0, 1e-12);
  session::Session xc = FindTest("ballbar-linked")->plan(SituationOfMachine(Dmu80(), Published()))[0].session;
  for (session::Column& column : xc.columns) {
    if (column.name != "X_mm") continue;
    for (double& x_mm : column.values) x_mm += 250.0;
  }
  EXPECT_FALSE(KeepsTheBar(Dmu80(), xc));
}

TEST(LinkedTest, NeedsATableThatTurnsOnce) {
  machine::Machine machine = Dmu80();
  machine.axes[3].max_position = 3.0;
  EXPECT_TRUE(FindTest("ballbar-linked")->plan(SituationOfMachine(machine, Published())).empty());
}

}  // namespace
}  // namespace axiscal::plan
