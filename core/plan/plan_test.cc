#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/identify/testing/scenario.h"
#include "core/instruments/registry.h"
#include "core/plan/passes.h"
#include "core/plan/test.h"

namespace axiscal::plan {
namespace {

using instruments::MeasuringRun;
using machine::Machine;

// Sessions of one machine, taken from the tests themselves: the grids and circles of a machine that was never measured
// are what it is measured by.
std::vector<MeasuringRun> Bound(const Machine& machine, const std::vector<PlannedSession>& planned) {
  std::vector<MeasuringRun> runs;
  for (const PlannedSession& one : planned) {
    const auto session = synthetic::Simulate(machine, {}, one.session, {});
    EXPECT_TRUE(session.ok()) << session.status() << " " << one.text;
    if (!session.ok()) continue;
    const auto run = instruments::BindSession(*session, machine);
    EXPECT_TRUE(run.ok()) << run.status();
    if (run.ok()) runs.push_back(*run);
  }
  return runs;
}

Situation Measured(const Machine& machine, std::vector<MeasuringRun>* runs) {
  Situation never = SituationOf(machine, {});
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    if (machine.axes[axis].kind == machine::AxisKind::kRotary) never.ranges[axis] = {-1.0, 1.5};
  }
  for (const char* test : {"rtest-grid", "ballbar-circle"}) {
    for (MeasuringRun& run : Bound(machine, FindTest(test)->plan(never))) runs->push_back(std::move(run));
  }
  return SituationOf(machine, *runs);
}

class EveryMachine : public ::testing::TestWithParam<int> {
 protected:
  const Machine machine_ = GetParam() == 0   ? machine::testing::MultiTasking()
                           : GetParam() == 1 ? machine::testing::TiltingTable()
                                             : machine::testing::SwivelHead();
};

// The nominal machine reads zero in every pose of every planned session, but for what a session leaves the ball by on
// purpose: the commands and the geometry agree.
TEST_P(EveryMachine, PlannedSessionsKeepTheToolAtTheBall) {
  std::vector<MeasuringRun> measured;
  const Situation situation = Measured(machine_, &measured);
  ASSERT_GT(measured.size(), 10u);
  std::set<std::string> names;
  for (const plan::Test& test : Tests()) {
    for (const PlannedSession& planned : test.plan(situation)) {
      EXPECT_FALSE(planned.text.empty());
      EXPECT_TRUE(names.insert(*session::FindHeader(planned.session, "session")).second)
          << *session::FindHeader(planned.session, "session");
      synthetic::NoiseOptions exact;
      exact.sigma_scale = 0.0;
      exact.draw_setup = false;
      const auto session = synthetic::Simulate(machine_, {}, planned.session, exact);
      ASSERT_TRUE(session.ok()) << session.status();
      const MeasuringRun run = *instruments::BindSession(*session, machine_);
      const double left_mm = run.measured_mm.cwiseAbs().maxCoeff();
      constexpr double kRoundingMm = 0.05;  // commands have four decimals; a chord between two readings of a circle
      constexpr double kAwayMm = 0.5;
      EXPECT_LE(left_mm, (test.name == "rtest-approach" ? kAwayMm : 0.0) + kRoundingMm) << planned.text;
      EXPECT_GE(run.time_s.front(), situation.start_s - 1e-9) << planned.text;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Structures, EveryMachine, ::testing::Range(0, 3));

TEST(Plan, TheTwelvePatternsAreForMachinesThatTheyFit) {
  EXPECT_EQ(FindTest("ballbar-pattern")->plan(SituationOf(machine::testing::MultiTasking(), {})).size(), 24u);
  EXPECT_TRUE(FindTest("ballbar-pattern")->plan(SituationOf(machine::testing::TiltingTable(), {})).empty());
  Machine mirrored = machine::testing::MultiTasking();
  mirrored.axes[machine::FindAxis(mirrored, "X")].direction *= -1.0;
  EXPECT_TRUE(FindTest("ballbar-pattern")->plan(SituationOf(mirrored, {})).empty());
}

// Wherever pivot and table stand: the same bar, the balls at the machine's own places.
TEST(Plan, TheTwelvePatternsFollowPivotAndTable) {
  Machine machine = machine::testing::MultiTasking();
  machine.axes[machine::FindAxis(machine, "B")].point_mm = {30.0, 0.0, 200.0};
  machine.axes[machine::FindAxis(machine, "C")].point_mm = {-490.0, 12.0, -80.0};
  Mounted mounted;
  mounted.tips_mm = {{30.0, 0.0, -156.4}};
  mounted.balls_mm = {{-440.0, 12.0, 65.5}};
  mounted.bars_mm = {120.0};
  const auto planned = FindTest("ballbar-pattern")->plan(SituationOfMachine(machine, mounted));
  ASSERT_EQ(planned.size(), 24u);
  EXPECT_EQ(session::FindHeader(planned[0].session, "session"), "BX-356");
  EXPECT_EQ(session::FindHeader(planned[0].session, "tool_tip_mm"), "30 0 -156.4");
  EXPECT_EQ(session::FindHeader(planned[0].session, "table_ball_mm"), "-490 12 65.5");
  EXPECT_EQ(session::FindHeader(planned[6].session, "session"), "CR-356");
  EXPECT_EQ(session::FindHeader(planned[6].session, "table_ball_mm"), "-440 12 65.5");
  // CR at C = 0: the tool ball a bar's length towards C's line from the table ball.
  EXPECT_NEAR(session::FindColumn(planned[6].session, "X_mm")->values[0], -440.0 - 120.0 - 30.0, 1e-9);
  EXPECT_NEAR(session::FindColumn(planned[6].session, "Y_mm")->values[0], 12.0, 1e-9);
  EXPECT_NEAR(session::FindColumn(planned[6].session, "Z_mm")->values[0], 65.5 - -156.4, 1e-9);
  const Situation unsaid = SituationOfMachine(machine, {});  // on the table, and through the pivot
  EXPECT_EQ(unsaid.balls_mm.front(), Eigen::Vector3d(-490.0, 12.0, -80.0));
  EXPECT_EQ(unsaid.tips_mm.front(), Eigen::Vector3d(30.0, 0.0, 50.0));
  mounted.tips_mm = {{35.0, 0.0, -156.4}};  // a tool beside the pivot would tear the bar
  EXPECT_TRUE(FindTest("ballbar-pattern")->plan(SituationOfMachine(machine, mounted)).empty());
}

// An arm has no linear axis that would bring the tool point to the ball.
TEST(Plan, AnArmCanRunNoneOfTheTests) {
  const Machine arm = machine::testing::Make("arm",
                                             {machine::testing::Rotary("J1", machine::testing::kZ, {0, 0, 0}),
                                              machine::testing::Rotary("J2", machine::testing::kY, {0, 0, 300}),
                                              machine::testing::Rotary("J3", machine::testing::kX, {400, 0, 300})},
                                             {}, {});
  Situation situation = SituationOf(arm, {});
  for (Range& range : situation.ranges) range = {-1.0, 1.0};
  for (const plan::Test& test : Tests()) EXPECT_TRUE(test.plan(situation).empty()) << test.name;
}

TEST(Plan, OnlySessionsThatRanOneWayAreRunBackwards) {
  const Machine machine = machine::testing::MultiTasking();
  ballbar::PatternOptions one_way;
  one_way.both_senses = false;
  std::vector<session::Session> sessions = {*ballbar::PlanPattern(machine, "one-way", ballbar::Pattern::kCR, one_way),
                                            *ballbar::PlanPattern(machine, "both", ballbar::Pattern::kCR, {})};
  std::vector<MeasuringRun> runs;
  for (const session::Session& session : sessions)
    runs.push_back(*instruments::BindSession(*synthetic::Simulate(machine, {}, session, {}), machine));
  const std::vector<PlannedSession> planned = FindTest("other-sense")->plan(SituationOf(machine, runs));
  ASSERT_EQ(planned.size(), 1u);
  EXPECT_EQ(*session::FindHeader(planned[0].session, "session"), "one-way-reversed");
  const std::vector<double>& c_deg = session::FindColumn(planned[0].session, "C_deg")->values;
  EXPECT_EQ(c_deg.front(), 360.0);
  EXPECT_EQ(c_deg.back(), 0.0);
}

TEST(Plan, PassesGoThereAndBackWithoutAPause) {
  PlannedSession once;
  once.session.header = {{"session", "line"}};
  once.session.columns = {{"t_s", {10.0, 12.0, 14.0}, {}}, {"X_mm", {0.0, 5.0, 9.0}, {}}};
  once.text = "a line";
  const PlannedSession thrice = InPasses(once, 3);
  EXPECT_EQ(thrice.session.header[0].value, "line-x3");
  EXPECT_EQ(thrice.session.columns[0].values, (std::vector<double>{10, 12, 14, 16, 18, 20, 22}));
  EXPECT_EQ(thrice.session.columns[1].values, (std::vector<double>{0, 5, 9, 5, 0, 5, 9}));
  EXPECT_EQ(thrice.text, "a line, 3 passes there and back in one go");
}

TEST(Plan, LeavingTheRangeSoFarIsSaidAndStatedLimitsHold) {
  Machine machine = machine::testing::MultiTasking();
  std::vector<MeasuringRun> runs;
  runs.push_back(*instruments::BindSession(
      *synthetic::Simulate(machine, {}, *ballbar::PlanPattern(machine, "CR", ballbar::Pattern::kCR, {}), {}), machine));
  const PlannedSession far = {*ballbar::PlanPattern(machine, "CA", ballbar::Pattern::kCA, {}), ""};
  const Reach reach = ReachOf(SituationOf(machine, runs), far.session);
  EXPECT_TRUE(reach.is_reachable);
  EXPECT_EQ(reach.text, "Z up to 522 mm (so far 422 mm)");
  EXPECT_NEAR(reach.beyond_mm, 100.0, 1e-9);
  machine.axes[machine::FindAxis(machine, "Z")].max_position = 500.0;
  EXPECT_FALSE(ReachOf(SituationOf(machine, runs), far.session).is_reachable);
}

}  // namespace
}  // namespace axiscal::plan
