#include <gtest/gtest.h>

#include <cmath>

#include "core/instruments/run.h"

namespace axiscal::instruments {
namespace {

MeasuringRun OneAxis(const std::vector<double>& positions) {
  MeasuringRun run;
  run.axis_count = 1;
  run.positions = positions;
  run.measured_mm = Eigen::MatrixXd::Zero(1, positions.size());
  run.has_time = true;
  for (size_t k = 0; k < positions.size(); ++k) run.time_s.push_back(0.5 * k);
  DeriveMotion(&run);
  return run;
}

TEST(Motion, SenseIsThatOfTheLastChangeAndOfTheFirstOneBeforeIt) {
  const MeasuringRun run = OneAxis({5, 5, 7, 7, 6, 6, 8});
  const double expected[] = {1, 1, 1, 1, -1, -1, 1};
  for (int k = 0; k < 7; ++k) EXPECT_EQ(run.AxisStatesOf(0)[k].sense, expected[k]) << k;
  EXPECT_EQ(OneAxis({5, 5, 5}).AxisStatesOf(0)[2].sense, 0.0);
}

// Up to a target, beyond it and back: no position shows it, the session says it.
TEST(Motion, AStatedSenseIsWhereTheAxisCameFrom) {
  MeasuringRun run;
  run.axis_count = 1;
  run.positions = {0, 5, 5, 5, 2, 3};
  run.stated_senses = {0, 0, -1, 0, 0, -1};
  run.measured_mm = Eigen::MatrixXd::Zero(1, 6);
  DeriveMotion(&run);
  const double senses[] = {1, 1, -1, -1, -1, -1}, travel[] = {INFINITY, 5, 0, 0, 3, 0};
  for (int k = 0; k < 6; ++k) {
    EXPECT_EQ(run.AxisStatesOf(0)[k].sense, senses[k]) << k;
    EXPECT_EQ(run.AxisStatesOf(0)[k].travel_since_reversal, travel[k]) << k;
  }
}

TEST(Motion, TravelCountsFromTheLastReversalOrTheStart) {
  const MeasuringRun run = OneAxis({0, 2, 4, 3, 1, 1, 2});
  EXPECT_TRUE(std::isinf(run.AxisStatesOf(0)[0].travel_since_reversal));
  EXPECT_EQ(run.AxisStatesOf(0)[2].travel_since_reversal, 4.0);
  EXPECT_EQ(run.AxisStatesOf(0)[3].travel_since_reversal, 1.0);
  EXPECT_EQ(run.AxisStatesOf(0)[4].travel_since_reversal, 3.0);
  EXPECT_EQ(run.AxisStatesOf(0)[5].travel_since_reversal, 3.0);
  EXPECT_EQ(run.AxisStatesOf(0)[6].travel_since_reversal, 1.0);
}

// Loops within loops; one that is closed is forgotten, and of more than are kept the widest.
TEST(Motion, TurnsAreRememberedUntilTheAxisGoesBeyondThem) {
  const MeasuringRun run = OneAxis({0, 10, 4, 7, 7, 10, 11, 11, 2});
  const std::vector<std::vector<double>> expected = {{}, {}, {10}, {4, 10}, {4, 10}, {}, {}, {}, {11}};
  const double moves[] = {0, 10, -6, 3, 3, 3, 1, 1, -9};
  for (size_t k = 0; k < expected.size(); ++k) {
    const shapes::AxisState& state = run.AxisStatesOf(0)[k];
    std::vector<double> turns(state.turned_at.begin(), state.turned_at.end());
    std::erase_if(turns, [](double at) { return std::isnan(at); });
    EXPECT_EQ(turns, expected[k]) << k;
    EXPECT_EQ(state.last_move, moves[k]) << k;
  }
  const MeasuringRun deep = OneAxis({0, 10, 1, 9, 2, 8});
  EXPECT_EQ(deep.AxisStatesOf(0)[5].turned_at, (std::array<double, shapes::kTurns>{2, 9, 1}));
}

TEST(Motion, SpeedIsSignedZeroAtRestAndThatOfTheFirstMoveBeforeIt) {
  const MeasuringRun run = OneAxis({0, 2, 2, 2, -1});
  EXPECT_EQ(run.AxisStatesOf(0)[0].speed, 4.0);
  EXPECT_EQ(OneAxis({5, 5, 7}).AxisStatesOf(0)[0].speed, 0.0);
  EXPECT_EQ(OneAxis({5}).AxisStatesOf(0)[0].speed, 0.0);
  EXPECT_EQ(run.AxisStatesOf(0)[1].speed, 2.0);  // comes to rest
  EXPECT_EQ(run.AxisStatesOf(0)[2].speed, 0.0);
  EXPECT_EQ(run.AxisStatesOf(0)[3].speed, -3.0);
  EXPECT_EQ(run.AxisStatesOf(0)[4].speed, -6.0);
}

// q = t^2 - 2 t turns round at 1 s: the way to a position is slower or faster than the axis is there.
TEST(Motion, SpeedAndAccelerationAreThoseAtThePositionWhereverTheReadingsStand) {
  MeasuringRun run;
  run.axis_count = 1;
  run.has_time = true;
  run.time_s = {0.0, 0.5, 1.0, 1.25, 4.0, 4.5};
  for (const double t : run.time_s) run.positions.push_back(t * t - 2.0 * t);
  run.measured_mm = Eigen::MatrixXd::Zero(1, 6);
  DeriveMotion(&run);
  for (const int k : {1, 2, 3, 4}) EXPECT_NEAR(run.AxisStatesOf(0)[k].speed, 2.0 * run.time_s[k] - 2.0, 1e-12) << k;
  for (const int k : {1, 2, 3, 4}) EXPECT_NEAR(run.AxisStatesOf(0)[k].acceleration, 2.0, 1e-12) << k;
  for (const int k : {0, 5}) EXPECT_EQ(run.AxisStatesOf(0)[k].acceleration, 0.0) << k;
  EXPECT_NEAR(run.AxisStatesOf(0)[5].speed, (11.25 - 8.0) / 0.5, 1e-12);  // the last: of the way to it
}

TEST(Motion, MomentsThatNoClockTellsApartAreOne) {
  MeasuringRun run;
  run.axis_count = 1;
  run.has_time = true;
  run.time_s = {0.0, 1e-310, 2e-310, 1.0, 2.0};
  run.positions = {0.0, 1.0, 0.0, 5.0, 6.0};
  run.measured_mm = Eigen::MatrixXd::Zero(1, 5);
  DeriveMotion(&run);
  const double speeds[] = {0.0, 0.0, 0.0, 3.0, 1.0};
  for (int k = 0; k < 5; ++k) {
    EXPECT_EQ(run.AxisStatesOf(0)[k].speed, speeds[k]) << k;
    EXPECT_EQ(run.AxisStatesOf(0)[k].acceleration, k == 3 ? -4.0 : 0.0) << k;
  }
}

}  // namespace
}  // namespace axiscal::instruments
