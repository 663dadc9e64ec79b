#include "core/identify/unseen.h"

#include <gtest/gtest.h>

#include "core/identify/identify.h"
#include "core/identify/testing/scenario.h"

namespace axiscal::identify {
namespace {

// All thirteen deviations of this machine; one combination of them no ball bar can see.
constexpr char kThirteen[] = R"({"EA0T": 0, "EX0T": 0, "EZ0T": 0, "EA0B": 0, "EB0B": 0, "EC0B": 0, "EC0X": 0, "EA0Y": 0,
    "EB0Y": 0, "EA0C": 0, "EB0C": 0, "EX0C": 0, "EY0C": 0})";

// Five patterns of bars with 722 readings each, 182 where the head turns.
SolvedProblem Solved() {
  static const machine::Machine machine = machine::testing::MultiTasking();
  const machine::ErrorModel model = testing::Errors(machine, kThirteen);
  auto runs = BindSessions(machine, testing::Measure(machine, model, {})).value();
  Options options;
  options.model = model;
  return SolveProblem(MakeProblem(machine, std::move(runs)).value(), model, options, {}).value();
}

// Of a long run some readings stand for all: what they say is what all say.
TEST(UnseenCovariance, OfSomeReadingsIsThatOfAll) {
  const SolvedProblem solved = Solved();
  ASSERT_FALSE(solved.held.empty());
  const Covariance covariance =
      CovarianceOf(solved.problem, solved.solution.point, solved.solution.normal, solved.held);
  const Eigen::VectorXd some = UnseenCovariance(solved, covariance).diagonal().cwiseSqrt();
  const Eigen::VectorXd all = UnseenCovariance(solved, covariance, 722).diagonal().cwiseSqrt();
  EXPECT_GT(all.maxCoeff(), 1e-6);
  for (Eigen::Index i = 0; i < all.size(); ++i) EXPECT_NEAR(some[i], all[i], 0.03 * all[i] + 1e-9) << i;
}

}  // namespace
}  // namespace axiscal::identify
