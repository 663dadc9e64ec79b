#include "core/identify/identify.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/demand.h"
#include "core/identify/describe.h"
#include "core/identify/honesty.h"
#include "core/identify/noise.h"
#include "core/identify/outliers.h"
#include "core/identify/reduction.h"
#include "core/identify/row_weights.h"
#include "core/identify/solver.h"
#include "core/instruments/plausible.h"
#include "core/instruments/resolution.h"

namespace axiscal::identify {
namespace {

using instruments::MeasuringRun;

// Rows that are weighted together stay together: one bad number spoils its reading.
void UseWhole(int row_count, std::vector<bool>* is_used) {
  for (auto reading = is_used->begin(); reading != is_used->end(); reading += row_count) {
    const bool is_whole = std::all_of(reading, reading + row_count, [](bool used) { return used; });
    std::fill(reading, reading + row_count, is_whole);
  }
}

// Sets scattered bad readings aside. Returns whether anything changed.
bool UpdateUsed(const std::vector<Eigen::MatrixXd>& residuals_mm, Problem* problem) {
  constexpr double kQuantisedSigmaShare =
      0.3;  // a series finer than this share of the stated sigma is quantised, not quiet
  bool has_changed = false;
  for (size_t i = 0; i < problem->runs.size(); ++i) {
    const MeasuringRun& run = problem->runs[i];
    std::vector<bool> is_used(problem->is_used[i].size());
    for (int row = 0; row < run.row_count; ++row) {
      const std::vector<bool> is_bad =
          FindOutliers(residuals_mm[i].row(row).transpose(),
                       std::max(kQuantisedSigmaShare * run.sigma_mm, instruments::RoundingSigma(run)));
      for (int k = 0; k < run.reading_count(); ++k) is_used[static_cast<size_t>(k) * run.row_count + row] = !is_bad[k];
    }
    if (problem->WeightOf(i, 0) != nullptr) UseWhole(run.row_count, &is_used);
    SetKnownAside(run, &is_used);
    has_changed |= is_used != problem->is_used[i];
    problem->is_used[i] = std::move(is_used);
  }
  return has_changed;
}

// Uncertainties of the fitted errors and set-ups; behind the fitted errors those that are held.
Covariance UncertaintyOf(const Problem& problem, const Solution& solution, const NullSpace& null_space,
                         const std::vector<Parameter>& parameters, double scale) {
  if (problem.fixed_covariance.size() == 0) {
    return CovarianceOf(problem, solution.point, solution.normal, null_space.fixed, scale);
  }
  Problem all_free = problem;
  all_free.fixed_model = {};
  Point point = solution.point;
  std::vector<Parameter> all = parameters;
  const int fitted = static_cast<int>(point.model.terms.size());
  for (Parameter held : ListParameters(problem.fixed_model, true)) {
    held.term += fitted;
    all.push_back(held);
  }
  point.model.terms.insert(point.model.terms.end(), problem.fixed_model.terms.begin(), problem.fixed_model.terms.end());
  return CovarianceOf(all_free, point, Assemble(all_free, point, all), null_space.fixed, scale,
                      problem.fixed_covariance);
}

// Readings to every unknown that a scatter below the stated one must be judged from.
constexpr double kManyReadings = 10.0;

bool HasManyReadings(const Fit& fit) {
  size_t unknowns = fit.result.estimates.size();
  for (const SetupGroup& group : fit.problem.groups) unknowns += group.parameters.size();
  return fit.result.fit.used > kManyReadings * static_cast<double>(unknowns);
}

// Gives correlated runs the correlation that their residuals show, and the scatter that goes with it where it is above
// the stated one: correlated readings scatter less about a fit than about the truth. Gives others the scatter that they
// show where it is clearly below the stated one: somebody was careful, and intervals would hold more than they say.
// Returns whether there are any; not where they leave more than such noise would, which is an effect that the model
// lacks and no servo ripple.
bool TakeNoise(Fit* fit) {
  constexpr double kClearlyBelow = 0.9;
  const bool may_narrow = HasManyReadings(*fit);
  Problem& problem = fit->problem;
  const std::vector<Noise> as_stated = problem.noise;
  problem.noise = EstimateNoise(problem, fit->residuals_mm);
  double squares = 0.0, count = 0.0;
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const Noise& stated = as_stated[i];
    Noise& shown = problem.noise[i];
    if (problem.WeightOf(i, 0) != nullptr) shown = stated;  // raw rows scatter unequally
    if (shown.ar1 == 0.0 && !(may_narrow && shown.sigma_mm < kClearlyBelow * stated.sigma_mm)) {
      shown = stated;
      continue;
    }
    if (shown.ar1 != 0.0) shown.sigma_mm = std::max(stated.sigma_mm, shown.sigma_mm);
    squares += WhitenedSquaresOf(problem, i, fit->residuals_mm[i]);
    count += static_cast<double>(std::count(problem.is_used[i].begin(), problem.is_used[i].end(), true));
  }
  constexpr double kLackOfFit = 1.2;
  if (count > 0.0 && squares <= kLackOfFit * count) return true;
  problem.noise = as_stated;
  return false;
}

bool HasNonlinear(const machine::ErrorModel& model, const Options& options) {
  return options.fit_nonlinear &&
         std::any_of(model.terms.begin(), model.terms.end(),
                     [](const machine::ErrorTerm& term) { return shapes::NonlinearParameter(term.shape) != nullptr; });
}

// At amplitude zero a decay length or time constant has no effect that could be fitted.
bool NeedsAmplitudes(const machine::ErrorModel& model) {
  return std::any_of(model.terms.begin(), model.terms.end(), [](const machine::ErrorTerm& term) {
    return shapes::NonlinearParameter(term.shape) != nullptr && term.amplitude[0] == 0.0 && term.amplitude[1] == 0.0;
  });
}

// Bad readings are set aside between the stages: they would send a time constant where it does not come back from.
absl::StatusOr<Solution> SolveInStages(const machine::ErrorModel& model, const std::vector<Eigen::VectorXd>& setup,
                                       const Nominal& nominal, const NullSpace& null_space, const Options& options,
                                       Problem* problem) {
  Point start = StartingPoint(*problem, model);
  if (!setup.empty()) start.setup = setup;
  const bool is_nominal = setup.empty() && start.model.terms == nominal.point.model.terms;
  const NormalEquations* at_start = is_nominal ? &nominal.normal : nullptr;
  if (!HasNonlinear(model, options)) return Solve(*problem, start, null_space, options, at_start);
  if (!setup.empty() && !NeedsAmplitudes(model)) return Solve(*problem, start, null_space, options);
  Options amplitudes_only = options;
  amplitudes_only.fit_nonlinear = false;
  constexpr double kNear = 1e-2;  // only where the second stage starts
  amplitudes_only.converged_decrement = std::max(kNear, options.converged_decrement);
  ASSIGN_OR_RETURN(const Solution first, Solve(*problem, start, nominal.null_space, amplitudes_only, at_start));
  if (options.set_outliers_aside && first.has_converged) UpdateUsed(first.residuals_mm, problem);
  return Solve(*problem, first.point, null_space, options);
}

}  // namespace

absl::StatusOr<Fit> FitProblem(Problem problem, const machine::ErrorModel& model, const Options& options,
                               const std::vector<Eigen::VectorXd>& setup) {
  DEMAND(setup.empty() || setup.size() == problem.groups.size());
  const std::vector<Parameter> parameters = ListParameters(model, options.fit_nonlinear);
  int setup_count = 0, readings = 0;
  for (const SetupGroup& group : problem.groups) setup_count += static_cast<int>(group.parameters.size());
  for (const MeasuringRun& run : problem.runs) readings += static_cast<int>(run.measured_mm.size());
  // Setups bring a prior each; errors need readings.
  if (readings < static_cast<int>(parameters.size())) {
    return absl::FailedPreconditionError(
        absl::StrCat(readings, " readings cannot determine ", parameters.size(), " errors"));
  }
  double noise_scale = 1.0;
  Nominal nominal = AtNominal(problem, model);
  const NullSpace null_space =
      HasNonlinear(model, options) ? WithNonlinearColumns(nominal.null_space, model) : nominal.null_space;
  ASSIGN_OR_RETURN(Solution solution, SolveInStages(model, setup, nominal, null_space, options, &problem));
  // A model that misses pulls setup offsets far from where anybody would mount a ball, along valleys without a floor.
  // The stated sigma says little then: it is raised, by no more than it takes for the priors to hold again.
  while (!solution.has_converged) {
    constexpr double kMostGrowth = 3.0, kMisses = 1.1;
    const double growth = std::min(kMostGrowth, std::sqrt(solution.cost / readings));
    if (!options.raise_noise || growth < kMisses) {
      return absl::FailedPreconditionError(
          absl::StrCat("identification has not converged after ", solution.iterations, " iterations"));
    }
    for (Noise& noise : problem.noise) noise.sigma_mm *= growth;
    noise_scale *= growth;
    nominal = AtNominal(problem, model);
    ASSIGN_OR_RETURN(solution, SolveInStages(model, setup, nominal, null_space, options, &problem));
  }
  ASSIGN_OR_RETURN(Stand stand, StandOf(problem, std::move(solution), parameters, null_space, options));
  solution = stand.best_first[0];
  const NullSpace& holding = stand.holding;
  constexpr int kRounds = 5;
  for (int round = 0; options.set_outliers_aside && round < kRounds; ++round) {
    if (!UpdateUsed(solution.residuals_mm, &problem)) break;
    ASSIGN_OR_RETURN(solution, Solve(problem, solution.point, holding, options));
  }
  Fit fit;
  fit.result.noise_scale = noise_scale;
  fit.result.fit = StatisticsOf(problem, solution.point, solution.residuals_mm,
                                static_cast<int>(parameters.size()) - static_cast<int>(holding.fixed.size()));
  const double scale = options.scale_uncertainties ? std::sqrt(std::max(1.0, fit.result.fit.chi2_per_dof)) : 1.0;
  const Covariance covariance = UncertaintyOf(problem, solution, holding, parameters, scale);
  OwedToPriors owed = FindOwedToPriors(problem, solution, parameters, null_space, holding.fixed);
  ASSIGN_OR_RETURN(const std::vector<bool> open,
                   FindWithoutInterval(problem, solution, stand, parameters, scale, options));
  for (size_t i = 0; i < open.size(); ++i) owed.involved[i] = owed.involved[i] || open[i];
  DescribeErrors(problem, solution, null_space, owed, covariance, parameters, &fit.result);
  if (options.held_errors) DescribeHeldErrors(*options.held_errors, covariance, &fit.result);
  fit.result.sessions = ListSessions(problem, solution.point, covariance, solution.residuals_mm);
  fit.result.outliers = ListOutliers(problem, solution.residuals_mm);
  fit.result.coverage_factor = CoverageFactor(scale > 1.0, fit.result.fit.degrees_of_freedom);
  fit.result.model = solution.point.model;
  const std::vector<bool> unsupported =
      FindUnsupported(solution, parameters, owed, null_space, holding.fixed, covariance);
  fit.result.warnings = WarningsOf(fit.result, parameters, open, unsupported);
  for (Warning& warning : CoarseReadings(problem)) fit.result.warnings.push_back(std::move(warning));
  for (Warning& warning : SharedWithHeld(problem, covariance, fit.result.held_from))
    fit.result.warnings.push_back(std::move(warning));
  fit.result.iterations = solution.iterations;
  fit.problem = std::move(problem);
  fit.point = std::move(solution.point);
  fit.residuals_mm = std::move(solution.residuals_mm);
  return fit;
}

absl::Status Validate(const Options& options) {
  if (options.max_iterations <= 0) {
    return absl::InvalidArgumentError(absl::StrCat("max_iterations = ", options.max_iterations, ", must be > 0"));
  }
  if (!(options.converged_decrement > 0.0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("converged_decrement = ", options.converged_decrement, ", must be > 0"));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<MeasuringRun>> BindSessions(const machine::Machine& machine,
                                                       const std::vector<session::Session>& sessions) {
  std::vector<MeasuringRun> runs;
  for (const session::Session& session : sessions) {
    ASSIGN_OR_RETURN(MeasuringRun run, instruments::BindSession(session, machine));
    RETURN_IF_ERROR(instruments::CheckAlive(session, run));
    runs.push_back(std::move(run));
  }
  return runs;
}

FitStatistics StatisticsOf(const Problem& problem, const Point& point, const std::vector<Eigen::MatrixXd>& residuals_mm,
                           int parameters) {
  FitStatistics out;
  double squares = 0.0, used_squares = 0.0;
  for (size_t i = 0; i < residuals_mm.size(); ++i) {
    const int rows = problem.runs[i].row_count;
    for (int k = 0; k < residuals_mm[i].cols(); ++k) {
      for (int row = 0; row < rows; ++row) {
        const double residual = residuals_mm[i](row, k);
        squares += residual * residual;
        out.max_mm = std::max(out.max_mm, std::abs(residual));
        ++out.readings;
        if (!problem.is_used[i][static_cast<size_t>(k) * rows + row]) continue;
        used_squares += residual * residual;
        ++out.used;
      }
    }
  }
  out.rms_mm = out.readings > 0 ? std::sqrt(squares / out.readings) : 0.0;
  out.rms_without_outliers_mm = out.used > 0 ? std::sqrt(used_squares / out.used) : 0.0;
  out.degrees_of_freedom = out.used - parameters;
  const double chi2 = WhitenedSquares(problem, residuals_mm) + PriorSquares(problem, point);
  out.chi2_per_dof = out.degrees_of_freedom > 0 ? chi2 / out.degrees_of_freedom : 0.0;
  return out;
}

absl::StatusOr<Fit> FitRuns(const machine::Machine& machine, std::vector<MeasuringRun> runs, const Options& options) {
  RETURN_IF_ERROR(Validate(options));
  if (runs.empty()) return absl::InvalidArgumentError("no sessions to identify from");
  ASSIGN_OR_RETURN(Problem problem, MakeProblem(machine, std::move(runs)));
  const machine::ErrorModel model = options.model ? *options.model : machine::DeclaredModel(machine);
  if (options.held_errors) {
    problem.fixed_model = options.held_errors->model;
    problem.fixed_covariance = options.held_errors->covariance;
  }
  if (options.budget) {
    std::vector<std::string> names;
    for (const MeasuringRun& run : problem.runs) names.push_back(run.session);
    RETURN_IF_ERROR(CheckSessions(*options.budget, names));
    WeighRows(*options.budget, model, &problem);
  }
  ASSIGN_OR_RETURN(Fit fit, FitProblem(std::move(problem), model, options));
  const bool is_noise_as_stated = fit.result.noise_scale == 1.0;  // raised for a misfit, which is no servo ripple
  if (!options.judge_correlation || !is_noise_as_stated || !TakeNoise(&fit)) return fit;
  return FitProblem(std::move(fit.problem), model, options);
}

absl::StatusOr<Fit> CheckRuns(const machine::Machine& machine, std::vector<MeasuringRun> runs,
                              const machine::ErrorModel& model, const Options& options) {
  RETURN_IF_ERROR(Validate(options));
  if (runs.empty()) return absl::InvalidArgumentError("no sessions to check with");
  ASSIGN_OR_RETURN(Problem problem, MakeProblem(machine, std::move(runs)));
  problem.fixed_model = model;
  return FitProblem(std::move(problem), {}, options);
}

absl::StatusOr<Fit> FitSessions(const machine::Machine& machine, const std::vector<session::Session>& sessions,
                                const Options& options) {
  if (options.progress) options.progress({"reading sessions", 0.0, ""});
  ASSIGN_OR_RETURN(std::vector<MeasuringRun> runs, BindSessions(machine, sessions));
  ASSIGN_OR_RETURN(Fit fit, FitRuns(machine, std::move(runs), options));
  const Point nominal = StartingPoint(fit.problem, {});
  const machine::ErrorModel held = std::exchange(fit.problem.fixed_model, {});
  fit.result.nominal = StatisticsOf(fit.problem, nominal, ResidualsOf(fit.problem, nominal), 0);
  fit.problem.fixed_model = held;
  return fit;
}

absl::StatusOr<Result> Identify(const machine::Machine& machine, const std::vector<session::Session>& sessions,
                                const Options& options) {
  ASSIGN_OR_RETURN(Fit fit, FitSessions(machine, sessions, options));
  return std::move(fit.result);
}

}  // namespace axiscal::identify
