#include <gtest/gtest.h>

#include <set>

#include "core/decide/close_loop.h"
#include "core/identify/testing/scenario.h"
#include "core/plan/session_builder.h"

namespace axiscal::decide {
namespace {

using loop::Report;
using loop::SelectionStep;
using loop::Unexplained;

// A ball measured by R-test in poses that follow no line: neighbours say nothing of each other.
session::Session Poses(const machine::Machine& machine, const machine::ErrorModel& truth, const std::string& name,
                       int count, uint64_t seed) {
  const plan::Situation situation = plan::SituationOf(machine, {});
  plan::SessionBuilder builder(situation, name, {0, 0, -150}, {80, 30, -400});
  for (int k = 0; k < count; ++k) {
    std::vector<double> positions(machine.axis_count(), 0.0);
    positions[machine::FindAxis(machine, "B")] = ((k * 7) % 5 - 2) * 0.2;
    positions[machine::FindAxis(machine, "C")] = ((k * 11) % 12 - 6) * 0.5;
    builder.Add(positions, Eigen::Vector3d::Zero());
  }
  synthetic::NoiseOptions noise;
  noise.seed = seed;
  return synthetic::Simulate(machine, truth, builder.Finish(), noise).value();
}

TEST(CloseLoop, ASlipInTheMiddleOfAShortSessionIsGivenItsMoment) {
  const machine::Machine machine = machine::testing::MultiTasking();
  constexpr int kCount = 30, kSlipped = 15;
  std::vector<session::Session> sessions = {Poses(machine, {}, "R1", kCount, 3), Poses(machine, {}, "R2", kCount, 4)};
  const double by_mm[] = {0.02, -0.015, 0.01};
  for (int k = kSlipped; k < kCount; ++k)
    for (size_t row = 0; row < 3; ++row) (sessions[1].columns.end() - 3 + row)->values[k] += by_mm[row];
  const auto runs = identify::BindSessions(machine, sessions);
  ASSERT_TRUE(runs.ok()) << runs.status();
  const Report report = CloseLoop(machine, *runs, {}).value();
  EXPECT_TRUE(report.effects.empty());
  EXPECT_TRUE(report.fitted.outliers.empty());
  ASSERT_EQ(report.unexplained.size(), 1u);
  EXPECT_EQ(report.unexplained[0].kind, Unexplained::kSlip);
  EXPECT_EQ(report.unexplained[0].session, "R2");
  const std::vector<double>& times_s = session::FindColumn(sessions[1], "t_s")->values;
  EXPECT_EQ(report.unexplained[0].from, times_s[kSlipped - 1]);
  EXPECT_EQ(report.unexplained[0].to, times_s[kSlipped]);
}

class LastReadings : public testing::TestWithParam<int> {};

// Among readings that an effect moves about a bad one at an end does not stand out of its neighbours, and what moved
// the last reading alone might have slipped.
TEST_P(LastReadings, AreBadAndDidNotSlip) {
  machine::Machine machine = machine::testing::MultiTasking();
  const machine::ErrorModel truth = identify::testing::Errors(machine, R"({"terms": [
      {"symbol": "EXC", "shape": "harmonic", "order": 2, "amplitude": 12, "phase_deg": 40},
      {"symbol": "EZC", "shape": "harmonic", "order": 3, "amplitude": 9, "phase_deg": 10}]})");
  constexpr int kCount = 30;
  std::vector<session::Session> sessions = {Poses(machine, truth, "R1", kCount, 3),
                                            Poses(machine, truth, "R2", kCount, 4)};
  const int bad = GetParam();
  const double off_mm[] = {-0.073, -0.049, -0.061};  // no two as what slipped would read
  for (int k = kCount - bad; k < kCount; ++k) sessions[1].columns.back().values[k] += off_mm[k + bad - kCount];
  const auto runs = identify::BindSessions(machine, sessions);
  ASSERT_TRUE(runs.ok()) << runs.status();
  const Report report = CloseLoop(machine, *runs, {}).value();
  EXPECT_TRUE(report.unexplained.empty());
  EXPECT_EQ(report.effects.size(), 2u);
  std::set<int> listed;
  for (const identify::Outlier& outlier : report.fitted.outliers) {
    EXPECT_EQ(outlier.session, "R2");
    listed.insert(outlier.row);
  }
  std::set<int> expected;
  for (int k = kCount - bad; k < kCount; ++k) expected.insert(k + 1);
  EXPECT_EQ(listed, expected);
}

INSTANTIATE_TEST_SUITE_P(Counts, LastReadings, testing::Values(1, 2, 3));

}  // namespace
}  // namespace axiscal::decide
