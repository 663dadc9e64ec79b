#include "core/loop/fitting.h"

#include <algorithm>
#include <cmath>

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

namespace {

// Of fits that are compared.
identify::Options ToCompare(const identify::Options& options) {
  identify::Options own = options;
  own.set_outliers_aside = false;
  own.raise_noise = false;         // chi-squares compare at one sigma only
  own.converged_decrement = 1e-3;  // what decides is a thousand times as much
  return own;
}

}  // namespace

absl::StatusOr<Fit> Refit(const Fit& fit, const machine::ErrorModel& model, const identify::Options& options) {
  return identify::FitProblem(fit.problem, model, ToCompare(options), fit.point.setup);
}

double SquaresOf(const Fit& fit) {
  return identify::WhitenedSquares(fit.problem, fit.residuals_mm) + identify::PriorSquares(fit.problem, fit.point);
}

double EvidenceOf(const Fit& fit, int term) {
  const std::vector<identify::Parameter> parameters = identify::ListParameters(fit.point.model, true);
  double squares = 0.0;
  for (size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].term != term || parameters[i].is_nonlinear) continue;
    const identify::Estimate& estimate = fit.result.estimates[i];
    if (estimate.identifiable && estimate.sigma > 0.0)
      squares += estimate.value * estimate.value / (estimate.sigma * estimate.sigma);
  }
  return squares;
}

}  // namespace axiscal::loop
