#include "core/identify/unseen.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/identify/identify.h"
#include "core/identify/testing/scenario.h"

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

}  // namespace
}  // namespace axiscal::identify
