#include "core/identify/unseen.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/identify/identify.h"
#include "core/identify/testing/scenario.h"
#include "core/machine/error_json.h"
#include "core/synthetic/simulate.h"

namespace axiscal::identify {
namespace {

// All thirteen deviations of this machine; one combination of them no ball bar can see.
constexpr char kThirteen[] = R"({"EA0T": 0, "EX0T": 0, "EZ0T": 0, "EA0B": 0, "EB0B": 0, "EC0B": 0, "EC0X": 0, "EA0Y": 0,
    "EB0Y": 0, "EA0C": 0, "EB0C": 0, "EX0C": 0, "EY0C": 0})";

// Patterns of bars with 722 readings each, 182 where the head turns.
SolvedProblem Solved(const std::vector<testing::Measured>& patterns) {
  static const machine::Machine machine = machine::testing::MultiTasking();
  machine::ErrorModel model = testing::Errors(machine, kThirteen);
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    int along = 0;
    machine.axes[axis].direction.cwiseAbs().maxCoeff(&along);
    if (machine.axes[axis].kind != machine::AxisKind::kLinear) continue;
    model.terms.push_back({axis, static_cast<machine::Component>(along), shapes::Linear{axis}, {}});
    model.terms.push_back({axis, static_cast<machine::Component>(along), shapes::Backlash{axis}, {}});
  }
  auto runs = BindSessions(machine, testing::Measure(machine, model, {}, patterns)).value();
  Options options;
  options.model = model;
  return SolveProblem(MakeProblem(machine, std::move(runs)).value(), model, options, {}).value();
}

void ExpectSomeTellWhatAllTell(const SolvedProblem& solved) {
  ASSERT_FALSE(solved.held.empty());
  const Covariance covariance =
      CovarianceOf(solved.problem, solved.solution.point, solved.solution.normal, solved.held);
  const Eigen::VectorXd some = UnseenCovariance(solved, covariance).diagonal().cwiseSqrt();
  const Eigen::VectorXd all = UnseenCovariance(solved, covariance, 722).diagonal().cwiseSqrt();
  EXPECT_GT(all.maxCoeff(), 1e-7);
  // What is a twentieth of the uncertainty by the readings adds nothing to it.
  const Eigen::VectorXd by_readings = covariance.errors.diagonal().cwiseSqrt();
  for (Eigen::Index i = 0; i < all.size(); ++i)
    EXPECT_NEAR(some[i], all[i], 0.03 * all[i] + 0.05 * by_readings[i] + 1e-9) << i;
}

// Of a long run some readings stand for all: what they say is what all say.
TEST(UnseenCovariance, OfSomeReadingsIsThatOfAll) { ExpectSomeTellWhatAllTell(Solved(testing::FivePatterns())); }

// Of one pattern alone most directions look like an offset of a ball, which takes them up to the last reading: what
// some readings leave of that stood for an uncertainty many times that by the readings.
TEST(UnseenCovariance, WhatASetUpTakesUpIsNoUncertaintyOfALongRun) {
  for (const testing::Measured& pattern : testing::FivePatterns()) {
    SCOPED_TRACE(pattern.name);
    ExpectSomeTellWhatAllTell(Solved({pattern}));
  }
}

// An interferometer along Y shows a roll of Y by the lever of 350 mm. What no reading shows acts like it: straightness
// of Y (sigma_h: 100 um at 250 mm) through a beam that is askew by 10 mrad, to either side, and a yaw (100 urad) by as
// far as the target stands aside (5 mm).
session::Session AlongY() {
  session::Session session;
  session.header = {{"machine", "mt"},   {"session", "line-Y"},       {"instrument", "length"},
                    {"sigma_um", "0.3"}, {"tool_tip_mm", "0 0 -350"}, {"beam", "0 1 0"}};
  session.columns = {{"t_s", {}, {}},  {"Z_mm", {}, {}},  {"Y_mm", {}, {}},
                     {"X_mm", {}, {}}, {"B_deg", {}, {}}, {"C_deg", {}, {}}};
  constexpr int kReadings = 110, kTargets = 11;
  for (int k = 0; k < kReadings; ++k) {
    for (session::Column& column : session.columns) column.values.push_back(0.0);
    session.columns[0].values.back() = 10.0 * k;
    session.columns[2].values.back() = -360.0 + 72.0 * (k % kTargets);
  }
  return session;
}

TEST(UnseenCovariance, IsInWhatALineTells) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const double by_straightness = 0.01 * 100.0 / 0.35, by_yaw = 0.005 * 100.0 / 0.35;  // urad
  const double expected = std::hypot(by_straightness, by_straightness, by_yaw);
  constexpr int kRuns = 20;
  for (uint64_t run = 1; run <= kRuns; ++run) {
    SCOPED_TRACE(run);
    // Small, so that how the beam and the target stand shows by next to nothing, and is fitted all the same.
    machine::ErrorModel truth =
        *machine::ReadErrors(R"({"terms": [{"symbol": "EYY", "shape": "linear", "variable": "Y", "amplitude": 20},
            {"symbol": "EAY", "shape": "quadratic", "variable": "Y", "amplitude": -5},
            {"symbol": "ECY", "shape": "quadratic", "variable": "Y", "amplitude": 30},
            {"symbol": "EXY", "shape": "quadratic", "variable": "Y", "amplitude": 5},
            {"symbol": "EZY", "shape": "quadratic", "variable": "Y", "amplitude": -4}]})",
                             machine);
    synthetic::NoiseOptions noise;
    noise.seed = run;
    const auto measured = synthetic::Simulate(machine, truth, AlongY(), noise);
    ASSERT_TRUE(measured.ok()) << measured.status();
    Options options;
    options.model = truth;
    for (machine::ErrorTerm& term : options.model->terms) term.amplitude.fill(0.0);
    const auto result = Identify(machine, {*measured}, options);
    ASSERT_TRUE(result.ok()) << result.status();
    const Estimate& roll = result->estimates[1];
    ASSERT_EQ(roll.name, "EAY:quadratic");
    ASSERT_TRUE(roll.identifiable);
    // How askew the fit finds the beam counts beside how well that is known: more than that of a straight one.
    EXPECT_GT(roll.sigma / roll.factor, 0.95 * expected);
    EXPECT_LT(roll.sigma / roll.factor, 1.5 * expected);
    EXPECT_NEAR(roll.value / roll.factor, -5.0, 3.0 * roll.sigma / roll.factor);
  }
}

}  // namespace
}  // namespace axiscal::identify
