#include "core/identify/describe.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/identify/fit_warnings.h"
#include "core/identify/held.h"
#include "core/identify/naming.h"

namespace axiscal::identify {
namespace {

using instruments::MeasuringRun;

// What the free errors carry once the null directions are held: error j stands for itself and its share of the held
// ones. `covariance` of the errors, scaled.
std::vector<Combination> DeterminedCombinations(const std::vector<Estimate>& estimates, const NullSpace& null_space,
                                                const Eigen::VectorXd& values, const Eigen::MatrixXd& covariance) {
  std::vector<Combination> combinations;
  const int p = static_cast<int>(estimates.size());
  for (int j = 0; j < p; ++j) {
    const bool is_held = std::find(null_space.fixed.begin(), null_space.fixed.end(), j) != null_space.fixed.end();
    if (!null_space.involved[j] || is_held) continue;
    Eigen::VectorXd dual = Eigen::VectorXd::Zero(p);  // the combination as a sum of errors
    dual[j] = 1.0;
    for (size_t k = 0; k < null_space.fixed.size(); ++k) dual[null_space.fixed[k]] -= null_space.directions(k, j);
    // CombinationName divides by the factors (a direction); a sum is written with its coefficients times them.
    Eigen::VectorXd coefficients(p);
    for (int i = 0; i < p; ++i) coefficients[i] = dual[i] * estimates[i].factor * estimates[i].factor;
    // The carrier comes first so that value and unit are its own.
    std::vector<Estimate> order = estimates;
    std::swap(order[0], order[j]);
    std::swap(coefficients[0], coefficients[j]);
    combinations.push_back({CombinationName(order, coefficients), estimates[j].unit, estimates[j].factor,
                            dual.dot(values), std::sqrt(std::max(0.0, dual.dot(covariance * dual))), dual});
  }
  return combinations;
}

// Readings that were set aside, with the gate that rejected them if one did.
std::vector<Outlier> ListOutliers(const Problem& problem, const std::vector<Eigen::MatrixXd>& residuals_mm) {
  std::vector<Outlier> outliers;
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const MeasuringRun& run = problem.runs[i];
    for (int k = 0; k < run.reading_count(); ++k) {
      for (int row = 0; row < run.row_count; ++row) {
        if (problem.is_used[i][static_cast<size_t>(k) * run.row_count + row]) continue;
        if (run.path_readings != nullptr) {
          const eccentricity::Reading& reading = run.path_readings->readings[k];
          outliers.push_back({run.session, reading.row + 1, reading.component, residuals_mm[i](row, k), {}});
          continue;
        }
        Outlier outlier{run.session, k + 1, row, residuals_mm[i](row, k), {}};
        for (const touch::Rejection& rejection : run.touches.rejected) {
          if (rejection.reading == k) outlier.gate = Gate{rejection.gate, rejection.off_mm, rejection.limit_mm};
        }
        outliers.push_back(std::move(outlier));
      }
    }
  }
  return outliers;
}

// An offset that nobody placed beforehand (a free datum, a slip) and that the readings tell less well than the prior
// that only keeps the fit steady has no number. `sigma` by the readings' noise as stated.
bool IsTold(const instruments::SetupParameter& parameter, double sigma) {
  constexpr double kHalf = 0.5;  // of the variance
  return parameter.is_placed || sigma * sigma < kHalf * parameter.prior_sigma * parameter.prior_sigma;
}

std::vector<SessionFit> ListSessions(const Problem& problem, const Point& point, const Judgement& judgement,
                                     const std::vector<Eigen::MatrixXd>& residuals_mm) {
  std::vector<SessionFit> sessions;
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const int group = problem.group_of_run[i];
    SessionFit session;
    session.session = problem.runs[i].session;
    session.setup_name = problem.runs[i].setup_name;
    session.readings = static_cast<int>(residuals_mm[i].size());
    session.rms_mm = std::sqrt(residuals_mm[i].squaredNorm() / session.readings);
    session.max_mm = residuals_mm[i].cwiseAbs().maxCoeff();
    for (const Eigen::Index k : problem.offsets_of_run[i]) {
      const instruments::SetupParameter& parameter = problem.groups[group].parameters[static_cast<size_t>(k)];
      constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
      const double sigma = judgement.covariance.setup_sigma[group][k];
      const bool is_told = IsTold(parameter, sigma / judgement.sigma_scale);
      session.setup.push_back({parameter.name, is_told ? parameter.centre + point.setup[group][k] : kNone,
                               is_told ? sigma : kNone, parameter.is_angle});
    }
    sessions.push_back(std::move(session));
  }
  return sessions;
}

void DescribeErrors(const SolvedProblem& solved, const Judgement& judgement, Result* result) {
  const std::vector<Parameter>& parameters = solved.parameters;
  const machine::ErrorModel& model = solved.solution.point.model;
  const NullSpace& null_space = solved.null_space;
  const Covariance& covariance = judgement.covariance;
  const int p = static_cast<int>(parameters.size());
  Eigen::VectorXd values(p), sigmas(p);
  for (int i = 0; i < p; ++i) {
    values[i] = ValueOf(model, parameters[i]);
    sigmas[i] = std::sqrt(std::max(0.0, covariance.errors(i, i)));
    Estimate estimate = NamedEstimate(*solved.problem.machine, model, parameters[i]);
    // With what held errors add, too.
    const bool is_too_wide = sigmas[i] > LargestOf(model, parameters[i]);
    estimate.identifiable = !null_space.involved[i] && !judgement.HasNoNumber(i) && !is_too_wide;
    if (estimate.identifiable) {
      estimate.value = values[i];
      estimate.sigma = sigmas[i];
    }
    result->estimates.push_back(std::move(estimate));
  }
  result->correlation = Eigen::MatrixXd::Constant(p, p, std::numeric_limits<double>::quiet_NaN());
  for (int i = 0; i < p; ++i) {
    for (int j = 0; j < p; ++j) {
      if (!result->estimates[i].identifiable || !result->estimates[j].identifiable) continue;
      result->correlation(i, j) = covariance.errors(i, j) / (sigmas[i] * sigmas[j]);
    }
  }
  for (int k = 0; k < null_space.directions.rows(); ++k) {
    result->not_separable.push_back(CombinationName(result->estimates, null_space.directions.row(k).transpose()));
  }
  for (const Eigen::VectorXd& direction : judgement.prior_dominated.directions)
    result->not_separable.push_back(CombinationName(result->estimates, direction));
  result->determined =
      DeterminedCombinations(result->estimates, null_space, values, covariance.errors.topLeftCorner(p, p));
  for (const StatedPart& part : judgement.stated) {
    Eigen::VectorXd moved = part.moved;
    for (int i = 0; i < p; ++i)
      if (!result->estimates[static_cast<size_t>(i)].identifiable) moved[i] = std::numeric_limits<double>::quiet_NaN();
    result->stated.push_back({part.of, std::move(moved)});
  }
  result->rank = null_space.rank;
  result->condition = null_space.condition;
}

// After DescribeErrors. `covariance`: of the fitted errors and the held ones.
void DescribeHeldErrors(const HeldErrors& held, const Covariance& covariance, Result* result) {
  result->held_errors = held.errors;
  result->held_from = held.from;
  const Eigen::Index p = static_cast<Eigen::Index>(result->estimates.size()),
                     h = static_cast<Eigen::Index>(held.errors.size());
  result->held_correlation = Eigen::MatrixXd::Constant(h, p + h, std::numeric_limits<double>::quiet_NaN());
  const Eigen::VectorXd sigma = covariance.errors.diagonal().cwiseMax(0.0).cwiseSqrt();
  for (Eigen::Index i = 0; i < h; ++i) {
    for (Eigen::Index j = 0; j < p + h; ++j) {
      if (sigma[p + i] == 0.0 || sigma[j] == 0.0 || (j < p && !result->estimates[j].identifiable)) continue;
      result->held_correlation(i, j) = covariance.errors(p + i, j) / (sigma[p + i] * sigma[j]);
    }
  }
}

// `errors`: the covariance of the fitted errors and of those held, as `result` lists them.
machine::WrittenCovariance WrittenCovarianceOf(const Eigen::MatrixXd& errors, const Result& result) {
  std::vector<const Estimate*> numbers;
  for (const Estimate& estimate : result.estimates) numbers.push_back(&estimate);
  for (const Estimate& held : result.held_errors) numbers.push_back(&held);
  std::vector<Eigen::Index> known;
  for (Eigen::Index i = 0; i < errors.rows() && i < static_cast<Eigen::Index>(numbers.size()); ++i) {
    if (std::isfinite(errors(i, i)) && errors(i, i) > 0.0) known.push_back(i);
  }
  machine::WrittenCovariance written;
  for (const Eigen::Index i : known) {
    const Estimate& number = *numbers[static_cast<size_t>(i)];
    written.of.push_back(number.name);
    written.sigma.push_back(std::sqrt(errors(i, i)) / number.factor);
  }
  const Eigen::MatrixXd covariance = errors(known, known);
  const Eigen::VectorXd per_sigma = covariance.diagonal().cwiseSqrt().cwiseInverse();
  written.correlation = per_sigma.asDiagonal() * covariance * per_sigma.asDiagonal();
  return written;
}

std::vector<reports::WarningFacts> ListWarnings(const SolvedProblem& solved, const Judgement& judgement,
                                                const Result& result) {
  std::vector<reports::WarningFacts> warnings = FindBeyondSize(solved.problem, result);
  for (const std::vector<reports::WarningFacts>& further :
       {FindQuiet(solved.problem, result, solved.solution.residuals_mm),
        WarningsOf(result, solved.parameters, judgement.without_interval, judgement.unsupported)})
    warnings.insert(warnings.end(), further.begin(), further.end());
  for (reports::WarningFacts& warning : FindCoarseReadings(solved.problem)) warnings.push_back(std::move(warning));
  for (reports::WarningFacts& warning : FindExpired(solved.problem)) warnings.push_back(std::move(warning));
  for (reports::WarningFacts& warning : FindTwoClocks(solved.problem, result)) warnings.push_back(std::move(warning));
  for (reports::WarningFacts& warning : FindMoved(solved.problem, solved.solution.point, judgement.covariance))
    warnings.push_back(std::move(warning));
  for (reports::WarningFacts& warning : SharedWithHeld(solved.problem, judgement.covariance, result.held_from))
    warnings.push_back(std::move(warning));
  // Set-up offsets of which nothing is known beforehand take a reading each as errors do.
  int unknowns = static_cast<int>(solved.parameters.size() - solved.held.size()) -
                 static_cast<int>(solved.null_space.directions.rows());
  for (const SetupGroup& group : solved.problem.groups) {
    for (const instruments::SetupParameter& parameter : group.parameters) unknowns += parameter.is_weak ? 1 : 0;
  }
  if (unknowns > 0 && result.fit.used <= unknowns) {
    warnings.push_back(reports::NoFreedom{.unknowns = absl::StrCat(unknowns, " unknowns"),
                                          .readings = absl::StrCat(result.fit.used, " readings"),
                                          .without_sigma = {},
                                          .what_to_do = "measure more readings than there are unknowns"});
  }
  return warnings;
}

}  // namespace

Fit Describe(SolvedProblem solved, const Judgement& judgement, const Options& options) {
  Fit fit;
  Result& result = fit.result;
  const Solution& solution = solved.solution;
  result.model = solution.point.model;
  DescribeErrors(solved, judgement, &result);
  if (options.held_errors) DescribeHeldErrors(*options.held_errors, judgement.covariance, &result);
  result.covariance = WrittenCovarianceOf(judgement.covariance.errors, result);
  result.fit = judgement.statistics;
  result.coverage_factor = judgement.coverage_factor;
  result.sessions = ListSessions(solved.problem, solution.point, judgement, solution.residuals_mm);
  result.outliers = ListOutliers(solved.problem, solution.residuals_mm);
  result.iterations = solution.iterations;
  result.noise_scale = solved.noise_scale;
  result.warnings = ListWarnings(solved, judgement, result);
  fit.standing_out = std::move(solved.standing_out);
  fit.problem = std::move(solved.problem);
  fit.point = std::move(solved.solution.point);
  fit.residuals_mm = std::move(solved.solution.residuals_mm);
  return fit;
}

}  // namespace axiscal::identify
