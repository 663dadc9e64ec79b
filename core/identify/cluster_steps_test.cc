#include "core/identify/cluster_steps.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "core/identify/identify.h"
#include "core/identify/testing/scenario.h"

namespace axiscal::identify {
namespace {

constexpr char kEight[] = R"({"EA0B": 0, "EB0B": 0, "EC0B": 0, "EA0C": 0, "EB0C": 0, "EX0C": 0, "EY0C": 0, "EA0T": 0})";

// Five patterns of bars, solved.
const SolvedProblem& AsMeasured() {
  static const SolvedProblem kSolved = [] {
    static const machine::Machine machine = machine::testing::MultiTasking();
    const machine::ErrorModel model = testing::Errors(machine, kEight);
    auto runs = BindSessions(machine, testing::Measure(machine, model, {})).value();
    Options options;
    options.model = model;
    return SolveProblem(MakeProblem(machine, std::move(runs)).value(), model, options, {}).value();
  }();
  return kSolved;
}

// The same with other noise, of which each `together` readings one after the other have the same.
SolvedProblem Disturbed(int together, uint64_t seed) {
  SolvedProblem solved = AsMeasured();
  base::Random random(seed);
  for (size_t i = 0; i < solved.problem.runs.size(); ++i) {
    instruments::MeasuringRun& run = solved.problem.runs[i];
    double off_mm = 0.0;
    for (int k = 0; k < run.reading_count(); ++k) {
      if (k % together == 0) off_mm = solved.problem.noise[i].sigma_mm * random.Normal();
      run.measured_mm.col(k).array() += solved.solution.residuals_mm[i].col(k).array() - off_mm;
    }
  }
  solved.solution.normal = Assemble(solved.problem, solved.solution.point, solved.parameters);
  return solved;
}

// What the errors move by from one draw of the noise to the next over what is stated of them, roots of the means over
// draws and errors: with their design effects, and as if readings were independent.
struct MovedBy {
  double with_effects = 0.0, as_independent = 0.0;
};
MovedBy OfStated(int together) {
  constexpr int kDraws = 24;
  MovedBy squares;
  for (int seed = 1; seed <= kDraws; ++seed) {
    const SolvedProblem solved = Disturbed(together, static_cast<uint64_t>(seed));
    const Problem& problem = solved.problem;
    const Point& point = solved.solution.point;
    const NormalEquations& normal = solved.solution.normal;
    const Eigen::ArrayXd variance = CovarianceOf(problem, point, normal, solved.held).errors.diagonal().array();
    const int freedom = normal.row_count - static_cast<int>(solved.parameters.size());
    const Eigen::ArrayXd effects = DesignEffects(solved, variance.matrix(), freedom).array();
    EXPECT_GE(effects.minCoeff(), 1.0);
    const Eigen::ArrayXd moved = SolveStep(problem, point, normal, solved.held).errors.array();
    squares.with_effects += (moved.square() / (effects * variance)).mean() / kDraws;
    squares.as_independent += (moved.square() / variance).mean() / kDraws;
  }
  return {std::sqrt(squares.with_effects), std::sqrt(squares.as_independent)};
}

TEST(DesignEffects, ChangeLittleWhereReadingsAreIndependent) {
  const MovedBy moved = OfStated(1);
  EXPECT_GT(moved.with_effects, 0.85 * moved.as_independent);
  EXPECT_LT(moved.as_independent, 1.2);
}

TEST(DesignEffects, HoldWhatReadingsDoThatAreOffTogether) {
  const MovedBy moved = OfStated(8);
  EXPECT_GT(moved.as_independent, 1.6) << "this noise does nothing that independent noise does not";
  EXPECT_LT(moved.with_effects, 1.3);
  EXPECT_GT(moved.with_effects, 0.7);
}

// What pulls at the errors in one stretch is what the others hold against.
TEST(ClusterSteps, AddUpToTheStepOfAllReadings) {
  const SolvedProblem solved = Disturbed(8, 1);
  const GaussNewtonStep step =
      SolveStep(solved.problem, solved.solution.point,
                Assemble(solved.problem, solved.solution.point, solved.parameters), solved.held);
  Problem exact = solved.problem;  // what priors of set-ups ask for is in no cluster
  for (size_t i = 0; i < exact.runs.size(); ++i) {
    const Eigen::MatrixXd residuals_mm = ResidualsOf(exact, solved.solution.point)[i];
    exact.runs[i].measured_mm += residuals_mm;
  }
  const GaussNewtonStep of_priors =
      SolveStep(exact, solved.solution.point, Assemble(exact, solved.solution.point, solved.parameters), solved.held);
  const Eigen::VectorXd sum = ClusterSteps(solved).rowwise().sum();
  for (Eigen::Index i = 0; i < sum.size(); ++i)
    EXPECT_NEAR(sum[i], step.errors[i] - of_priors.errors[i], 1e-6 * std::abs(step.errors[i]) + 1e-12) << i;
}

}  // namespace
}  // namespace axiscal::identify
