#include "core/loop/fitting.h"

#include "core/identify/noise.h"
#include "core/identify/reduction.h"

namespace axiscal::loop {

using identify::Fit;

absl::StatusOr<Fit> FitExtension(const machine::Machine& machine, const Extension& extension,
                                 const identify::Options& options) {
  identify::Options own = options;
  own.model = extension.Model();
  own.judge_correlation = false;  // judged below, with the scatter
  ASSIGN_OR_RETURN(Fit fit, identify::FitRuns(machine, extension.Runs(), own));
  constexpr int kRounds = 2;
  for (int round = 0; round < kRounds; ++round) {
    identify::Problem problem = std::move(fit.problem);
    problem.noise = EstimateNoise(problem, fit.residuals_mm);
    own.model = fit.result.model;
    ASSIGN_OR_RETURN(fit, identify::FitProblem(std::move(problem), *own.model, own, fit.point.setup));
  }
  return fit;
}

absl::StatusOr<Fit> Refit(const Fit& fit, const machine::ErrorModel& model, const identify::Options& options) {
  identify::Options own = options;
  own.set_outliers_aside = false;
  return identify::FitProblem(fit.problem, model, own, fit.point.setup);
}

double SquaresOf(const Fit& fit) {
  return identify::WhitenedSquares(fit.problem, fit.residuals_mm) + identify::PriorSquares(fit.problem, fit.point);
}

}  // namespace axiscal::loop
