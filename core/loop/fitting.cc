#include "core/loop/fitting.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/identify/noise.h"
#include "core/identify/reduction.h"
#include "core/machine/error_covariance.h"

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

double LeaningOf(const Fit& fit) {
  return identify::LeaningOnSetups(
      fit.problem, identify::Assemble(fit.problem, fit.point, identify::ListParameters(fit.point.model, false)));
}

InReadings::InReadings(const std::vector<instruments::MeasuringRun>& runs, const machine::ErrorTerm& term) {
  double squares = 0.0, basis[shapes::kMaxBasisCount];
  int count = 0;
  for (const instruments::MeasuringRun& run : runs) {
    for (int k = 0; run.path_readings == nullptr && k < run.reading_count(); ++k, ++count) {
      shapes::Basis(term.shape, run.StateOf(k), basis);
      double error = 0.0;
      for (int b = 0; b < shapes::BasisCount(term.shape); ++b) error += term.amplitude[b] * basis[b];
      squares += error * error;
      largest = std::max(largest, std::abs(error));
    }
  }
  if (std::isnan(squares)) largest = squares;
  if (count > 0) rms = std::sqrt(squares / count);
}

double EvidenceOf(const Fit& fit, int term) {
  const machine::ErrorModel& model = fit.result.model;
  const machine::WrittenCovariance& known = fit.result.covariance;
  std::vector<Eigen::Index> at;  // numbers that the readings tell
  std::vector<double> in_sigmas;
  for (int basis = 0; basis < shapes::BasisCount(model.terms[term].shape); ++basis) {
    const machine::NamedNumber number = machine::NameNumber(*fit.problem.machine, model, term, basis, false);
    const auto found = std::find(known.of.begin(), known.of.end(), number.name);
    if (found == known.of.end()) continue;
    const auto which = found - known.of.begin();
    if (!(known.sigma[which] > 0.0)) continue;
    at.push_back(which);
    in_sigmas.push_back(model.terms[term].amplitude[basis] / number.factor / known.sigma[which]);
  }
  const auto count = static_cast<Eigen::Index>(at.size());
  const Eigen::Map<const Eigen::VectorXd> value(in_sigmas.data(), count);
  Eigen::MatrixXd correlation(count, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j < count; ++j)
      correlation(i, j) = i == j ? 1.0 : known.correlation(std::max(at[i], at[j]), std::min(at[i], at[j]));
  const Eigen::LDLT<Eigen::MatrixXd> solver(correlation);
  return solver.isPositive() ? value.dot(solver.solve(value)) : value.squaredNorm();
}

}  // namespace axiscal::loop
