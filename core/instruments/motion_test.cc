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
  for (int k = 0; k < 7; ++k) EXPECT_EQ(run.axis_states[k].sense, expected[k]) << k;
  EXPECT_EQ(OneAxis({5, 5, 5}).axis_states[2].sense, 0.0);
}

TEST(Motion, TravelCountsFromTheLastReversalOrTheStart) {
  const MeasuringRun run = OneAxis({0, 2, 4, 3, 1, 1, 2});
  EXPECT_TRUE(std::isinf(run.axis_states[0].travel_since_reversal));
  EXPECT_EQ(run.axis_states[2].travel_since_reversal, 4.0);
  EXPECT_EQ(run.axis_states[3].travel_since_reversal, 1.0);
  EXPECT_EQ(run.axis_states[4].travel_since_reversal, 3.0);
  EXPECT_EQ(run.axis_states[5].travel_since_reversal, 3.0);
  EXPECT_EQ(run.axis_states[6].travel_since_reversal, 1.0);
}

TEST(Motion, SpeedIsSignedZeroAtRestAndThatOfTheFirstMoveBeforeIt) {
  const MeasuringRun run = OneAxis({0, 2, 2, -1});
  EXPECT_EQ(run.axis_states[0].speed, 4.0);
  EXPECT_EQ(OneAxis({5, 5, 7}).axis_states[0].speed, 0.0);
  EXPECT_EQ(OneAxis({5}).axis_states[0].speed, 0.0);
  EXPECT_EQ(run.axis_states[1].speed, 4.0);
  EXPECT_EQ(run.axis_states[2].speed, 0.0);
  EXPECT_EQ(run.axis_states[3].speed, -6.0);
}

}  // namespace
}  // namespace axiscal::instruments
