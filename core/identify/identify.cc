#include "core/identify/identify.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/identify/datum.h"
#include "core/identify/describe.h"
#include "core/identify/judge.h"
#include "core/identify/noise.h"
#include "core/identify/reduction.h"
#include "core/identify/row_weights.h"
#include "core/identify/solve.h"
#include "core/instruments/plausible.h"
#include "core/instruments/repeated.h"

namespace axiscal::identify {
namespace {

using instruments::MeasuringRun;

// Readings per unknown that a scatter below the stated one must be judged from.
constexpr double kManyReadings = 10.0;

bool HasManyReadings(const Fit& fit) {
  size_t unknowns = fit.result.estimates.size();
  for (const SetupGroup& group : fit.problem.groups) unknowns += group.parameters.size();
  return fit.result.fit.used > kManyReadings * static_cast<double>(unknowns);
}

// Sets the problem's noise to what the residuals show, where that changes the uncertainties:
// - of a run whose residuals are correlated, to that correlation, and to the scatter that goes with it where it is
//   above the stated one (correlated readings scatter less about a fit than about the truth);
// - of any other run that clearly scatters by less than stated, to that scatter: its intervals would be too wide.
// Returns whether the noise of any run changed. Lack of fit: where chi-square with the new noise is still more than
// kLackOfFit per reading, the residuals show an effect that the model lacks and no servo ripple; the noise then stays
// as it was.
bool TakeShownNoise(Fit* fit) {
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

// Set-ups alone leave what the errors do to all touches of a feature.
absl::Status CheckStandingOut(const Fit& fit) {
  if (fit.standing_out.empty() || fit.result.model.terms.empty()) return absl::OkStatus();
  const StandingOut& out = fit.standing_out[0];
  const MeasuringRun& run = fit.problem.runs[static_cast<size_t>(out.run)];
  return absl::InvalidArgumentError(absl::StrFormat(
      "session '%s': %d of the %d touches of '%s' stand out of the session's others or fail a gate, expected at most a "
      "third: is stylus_radius_mm = %g right, and the feature's header line? If they are, the machine has an error "
      "that "
      "is not declared (axiscal close-loop looks for it)",
      run.session, out.touches, out.of, run.touches.features[static_cast<size_t>(out.feature)].name,
      run.touches.stylus_radius_mm));
}

}  // namespace

absl::StatusOr<Fit> FitProblem(Problem problem, const machine::ErrorModel& model, const Options& options,
                               const std::vector<Eigen::VectorXd>& setup) {
  ASSIGN_OR_RETURN(SolvedProblem solved, SolveProblem(std::move(problem), model, options, setup));
  ASSIGN_OR_RETURN(const Judgement judgement, Judge(solved, options));
  return Describe(std::move(solved), judgement, options);
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

absl::StatusOr<MeasuringRun> BindMeasured(const session::Session& session, const machine::Machine& machine) {
  ASSIGN_OR_RETURN(MeasuringRun run, instruments::BindSession(session, machine));
  RETURN_IF_ERROR(instruments::CheckAlive(session, run));
  return run;
}

absl::StatusOr<std::vector<MeasuringRun>> BindSessions(const machine::Machine& machine,
                                                       const std::vector<session::Session>& sessions) {
  std::vector<MeasuringRun> runs;
  for (const session::Session& session : sessions) {
    ASSIGN_OR_RETURN(runs.emplace_back(), BindMeasured(session, machine));
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
  const double chi2 = WhitenedSquares(problem, residuals_mm) + JudgingPriorSquares(problem, point);
  out.chi2_per_dof = out.degrees_of_freedom > 0 ? chi2 / out.degrees_of_freedom : 0.0;
  return out;
}

absl::StatusOr<Fit> FitRuns(const machine::Machine& machine, std::vector<MeasuringRun> runs, const Options& options) {
  RETURN_IF_ERROR(Validate(options));
  if (runs.empty()) return absl::InvalidArgumentError("no sessions to identify from");
  ASSIGN_OR_RETURN(Problem problem, MakeProblem(machine, std::move(runs)));
  const machine::ErrorModel model = options.model ? *options.model : machine::DeclaredModel(machine);
  RETURN_IF_ERROR(CheckRecorded(machine, problem.runs, model));
  if (options.held_errors) {
    RETURN_IF_ERROR(CheckRecorded(machine, problem.runs, options.held_errors->model));
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
  if (!options.judge_correlation || !is_noise_as_stated || !TakeShownNoise(&fit)) return fit;
  return FitProblem(std::move(fit.problem), model, options);
}

absl::StatusOr<Fit> CheckRuns(const machine::Machine& machine, std::vector<MeasuringRun> runs,
                              const machine::ErrorModel& model, const Options& options) {
  RETURN_IF_ERROR(Validate(options));
  if (runs.empty()) return absl::InvalidArgumentError("no sessions to check with");
  ASSIGN_OR_RETURN(Problem problem, MakeProblem(machine, std::move(runs)));
  RETURN_IF_ERROR(CheckRecorded(machine, problem.runs, model));
  problem.fixed_model = model;
  return FitProblem(std::move(problem), {}, options);
}

std::optional<size_t> SharedSetup(const MeasuringRun& run, const Problem& fit) {
  if (!run.is_setup_stated) return std::nullopt;
  for (size_t i = 0; i < fit.runs.size(); ++i) {
    if (fit.runs[i].setup_name == run.setup_name && fit.runs[i].slips.empty()) return i;
  }
  return std::nullopt;
}

std::optional<size_t> SharedScale(const MeasuringRun& run, const Problem& fit) {
  for (size_t i = 0; i < fit.runs.size() && !run.scale_of.empty(); ++i) {
    if (fit.runs[i].scale_of == run.scale_of) return i;
  }
  return std::nullopt;
}

absl::StatusOr<Fit> CheckRuns(const machine::Machine& machine, std::vector<MeasuringRun> runs, const Fit& fitted,
                              const Options& options) {
  for (MeasuringRun& run : runs) {
    const std::optional<size_t> same = SharedSetup(run, fitted.problem), of_scale = SharedScale(run, fitted.problem);
    if (same) {
      const MeasuringRun& first = fitted.problem.runs[*same];
      RETURN_IF_ERROR(CheckSameSetup(first, run));
      StartAs(first, &run);
      const Eigen::VectorXd setup = SetupOf(fitted.problem, fitted.point, *same);
      for (size_t k = 0; k < run.setup.size(); ++k) run.setup[k].held = setup[static_cast<Eigen::Index>(k)];
    } else if (of_scale) {
      const MeasuringRun& first = fitted.problem.runs[*of_scale];
      RETURN_IF_ERROR(CheckSameScale(first, run));
      run.setup[ScaleAt(run)].held =
          SetupOf(fitted.problem, fitted.point, *of_scale)[static_cast<Eigen::Index>(ScaleAt(first))];
    }
  }
  return CheckRuns(machine, std::move(runs), fitted.result.model, options);
}

absl::StatusOr<Fit> FitMeasured(const machine::Machine& machine, std::vector<MeasuringRun> runs,
                                const Options& options) {
  RETURN_IF_ERROR(instruments::CheckRepeated(runs));
  ASSIGN_OR_RETURN(Fit fit, FitRuns(machine, std::move(runs), options));
  RETURN_IF_ERROR(CheckStandingOut(fit));
  for (reports::WarningFacts& warning : FindMovedDatum(fit)) fit.result.warnings.push_back(std::move(warning));
  const Point nominal = StartingPoint(fit.problem, {});
  const machine::ErrorModel held = std::exchange(fit.problem.fixed_model, {});
  fit.result.nominal = StatisticsOf(fit.problem, nominal, ResidualsOf(fit.problem, nominal), 0);
  fit.problem.fixed_model = held;
  return fit;
}

absl::StatusOr<Fit> FitSessions(const machine::Machine& machine, const std::vector<session::Session>& sessions,
                                const Options& options) {
  if (options.progress) options.progress({"reading sessions", 0.0, ""});
  ASSIGN_OR_RETURN(std::vector<MeasuringRun> runs, BindSessions(machine, sessions));
  return FitMeasured(machine, std::move(runs), options);
}

absl::StatusOr<Result> Identify(const machine::Machine& machine, const std::vector<session::Session>& sessions,
                                const Options& options) {
  ASSIGN_OR_RETURN(Fit fit, FitSessions(machine, sessions, options));
  return std::move(fit.result);
}

}  // namespace axiscal::identify
