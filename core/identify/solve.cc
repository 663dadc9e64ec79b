#include "core/identify/solve.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/demand.h"
#include "core/identify/outliers.h"
#include "core/identify/reduction.h"
#include "core/instruments/resolution.h"
#include "core/instruments/touch/touch_bind.h"

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

// Touches of one feature that stand out of the series together are what the others lack, or what all of them have: they
// are used again and told.
void KeepFeatures(const Problem& problem, size_t run_index, std::vector<bool>* is_used,
                  std::vector<StandingOut>* standing_out) {
  const touch::Touches& touches = problem.runs[run_index].touches;
  for (size_t feature = 0; feature < touches.features.size(); ++feature) {
    StandingOut out{static_cast<int>(run_index), static_cast<int>(feature), 0, 0};
    std::vector<size_t> flagged;
    for (size_t k = 0; k < touches.feature_of.size(); ++k) {
      if (touches.feature_of[k] != out.feature) continue;
      ++out.of;
      if (!(*is_used)[k]) flagged.push_back(k);
    }
    out.touches = static_cast<int>(flagged.size());
    const bool all_gated = std::all_of(flagged.begin(), flagged.end(), [&](size_t k) {
      const auto is_it = [&](const touch::Rejection& one) { return one.reading == static_cast<int>(k); };
      return std::any_of(touches.rejected.begin(), touches.rejected.end(), is_it);
    });
    if (all_gated || !touch::AreTooMany(flagged.size(), static_cast<size_t>(out.of))) continue;
    standing_out->push_back(out);
    for (const size_t k : flagged) (*is_used)[k] = true;
  }
}

// Sets scattered bad readings aside. Returns whether anything changed.
bool SetOutliersAside(const std::vector<Eigen::MatrixXd>& residuals_mm, Problem* problem,
                      std::vector<StandingOut>* standing_out) {
  constexpr double kQuantisedSigmaShare =
      0.3;  // a series finer than this share of the stated sigma is quantised, not quiet
  bool has_changed = false;
  standing_out->clear();
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
    if (run.kind == instruments::Kind::kTouch) {
      KeepFeatures(*problem, i, &is_used, standing_out);
      SetKnownAside(run, &is_used);
    }
    has_changed |= is_used != problem->is_used[i];
    problem->is_used[i] = std::move(is_used);
  }
  return has_changed;
}

int ReadingCount(const Problem& problem) {
  int readings = 0;
  for (const MeasuringRun& run : problem.runs) readings += static_cast<int>(run.measured_mm.size());
  return readings;
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

// Touches alone are far from linear in a set-up: the gap to a face that was touched near its middle changes with the
// square of the artefact's turn, so that a turn and its opposite explain the readings alike.
bool MayBeCurved(const Problem& problem) {
  return std::any_of(problem.runs.begin(), problem.runs.end(),
                     [](const MeasuringRun& run) { return run.kind == instruments::Kind::kTouch; });
}

// Set-ups alone, all errors as they start: an artefact that was mounted by hand stands millimetres from its nominal
// place, where the derivatives of touches by errors are others by a third. From there one step with all errors may end
// in another valley, such as that of an axis that goes the other way.
std::vector<Eigen::VectorXd> SetupsAlone(const Problem& problem, const Point& start, const NullSpace& null_space,
                                         const Options& options) {
  NullSpace holding = null_space;
  const size_t parameters = ListParameters(start.model, options.fit_nonlinear).size();
  holding.fixed.resize(parameters);
  std::iota(holding.fixed.begin(), holding.fixed.end(), 0);
  Options quiet = options;
  quiet.progress = nullptr;
  const absl::StatusOr<Solution> found = Solve(problem, start, holding, quiet);
  return found.ok() && found->has_converged ? found->point.setup : start.setup;
}

// Amplitudes first where there are non-linear parameters, then all. Bad readings are set aside between the two: they
// would send a time constant where it does not come back from. `is_given`: the set-ups of `start` are a solution's.
absl::StatusOr<Solution> SolveInStages(const Point& start, bool is_given, const NormalEquations* at_start,
                                       const Nominal& nominal, const NullSpace& null_space, const Options& options,
                                       Problem* problem) {
  if (!HasNonlinear(start.model, options)) return Solve(*problem, start, null_space, options, at_start);
  if (is_given && !NeedsAmplitudes(start.model)) return Solve(*problem, start, null_space, options);
  Options amplitudes_only = options;
  amplitudes_only.fit_nonlinear = false;
  constexpr double kNear = 1e-2;  // only where the second fit starts
  amplitudes_only.converged_decrement = std::max(kNear, options.converged_decrement);
  ASSIGN_OR_RETURN(const Solution first, Solve(*problem, start, nominal.null_space, amplitudes_only, at_start));
  std::vector<StandingOut> of_amplitudes;
  if (options.set_outliers_aside && first.has_converged) SetOutliersAside(first.residuals_mm, problem, &of_amplitudes);
  return Solve(*problem, first.point, null_space, options);
}

// From `setup`, or where it is empty from the nominal one. Of touches, where that was a curved way or none to a
// minimum, from the set-ups alone too: the end of that way is taken unless the other fits better by more than chance
// makes it.
absl::StatusOr<Solution> SolveFrom(const machine::ErrorModel& model, const std::vector<Eigen::VectorXd>& setup,
                                   const Nominal& nominal, const NullSpace& null_space, const Options& options,
                                   Problem* problem) {
  Point start = StartingPoint(*problem, model);
  if (!setup.empty()) start.setup = setup;
  const bool is_nominal = setup.empty() && start.model.terms == nominal.point.model.terms;
  absl::StatusOr<Solution> found = SolveInStages(start, !setup.empty(), is_nominal ? &nominal.normal : nullptr, nominal,
                                                 null_space, options, problem);
  const bool is_straight = found.ok() && found->has_converged && !found->is_curved;
  if (!setup.empty() || !MayBeCurved(*problem) || is_straight || absl::IsCancelled(found.status())) return found;
  start.setup = SetupsAlone(*problem, start, null_space, options);
  absl::StatusOr<Solution> other =
      SolveInStages(start, /*is_given=*/false, nullptr, nominal, null_space, options, problem);
  if (absl::IsCancelled(other.status())) return other;
  constexpr double kByChance = 6.0;  // chi-square
  const bool is_taken = other.ok() && other->has_converged &&
                        (!found.ok() || !found->has_converged || other->cost < found->cost + kByChance);
  if (!is_taken) return found;
  other->is_curved = true;
  return other;
}

absl::Status NotConverged(const Solution& solution) {
  return absl::FailedPreconditionError(
      absl::StrCat("identification has not converged after ", solution.iterations, " iterations"));
}

// Chi-square without the priors that judge nothing.
double JudgingCost(const Problem& problem, const Solution& solution) {
  return solution.cost - PriorSquares(problem, solution.point) + JudgingPriorSquares(problem, solution.point);
}

// A model that misses pulls setup offsets far from where anybody would mount a ball, along valleys without a floor.
// The stated sigma says little then: it is raised, by no more than it takes for the priors to hold again, and the fit
// is done again by `solve`. FAILED_PRECONDITION where the readings do not scatter by more than stated, or it may not be
// raised.
template <typename SolveAgain>
absl::Status RaiseNoiseUntilConverged(const Options& options, const SolveAgain& solve, SolvedProblem* solved) {
  while (!solved->solution.has_converged) {
    constexpr double kMostGrowth = 3.0, kMisses = 1.1;
    const double growth = std::min(
        kMostGrowth, std::sqrt(JudgingCost(solved->problem, solved->solution) / ReadingCount(solved->problem)));
    if (!options.raise_noise || growth < kMisses) return NotConverged(solved->solution);
    for (Noise& noise : solved->problem.noise) noise.sigma_mm *= growth;
    solved->noise_scale *= growth;
    ASSIGN_OR_RETURN(solved->solution, solve());
  }
  return absl::OkStatus();
}

// Sets solved->null_space, `held` and `solution`; raises the noise where it takes that to converge.
absl::Status FindMinimum(const machine::ErrorModel& model, const std::vector<Eigen::VectorXd>& setup,
                         const Options& options, SolvedProblem* solved) {
  Problem& problem = solved->problem;
  Nominal nominal = AtNominal(problem, model);
  solved->null_space =
      HasNonlinear(model, options) ? WithNonlinearColumns(nominal.null_space, model) : nominal.null_space;
  solved->held = solved->null_space.fixed;
  ASSIGN_OR_RETURN(solved->solution, SolveFrom(model, setup, nominal, solved->null_space, options, &problem));
  const auto solve_again = [&] {
    nominal = AtNominal(problem, model);
    return SolveFrom(model, setup, nominal, solved->null_space, options, &problem);
  };
  return RaiseNoiseUntilConverged(options, solve_again, solved);
}

// Solves again without holding what shows at the solution after all (gauge.h).
absl::Status FreeHeldErrors(const Options& options, SolvedProblem* solved) {
  const auto solve_holding = [&](const std::vector<int>& held) {
    NullSpace holding = solved->null_space;
    holding.fixed = held;
    return Solve(solved->problem, solved->solution.point, holding, options);
  };
  std::vector<int> held = HeldAtSolution(solved->problem, solved->solution, solved->parameters, solved->null_space);
  if (held != solved->held) {
    ASSIGN_OR_RETURN(Solution freed, solve_holding(held));
    solved->is_curved |= freed.is_curved;
    if (freed.has_converged) {
      solved->solution = std::move(freed);
      solved->held = std::move(held);
    }
  }
  while (options.profile_intervals) {
    const std::optional<int> worst =
        BiasesMost(solved->problem, solved->solution, solved->parameters, solved->null_space, solved->held);
    if (!worst) break;
    held = solved->held;
    std::erase(held, *worst);
    ASSIGN_OR_RETURN(Solution freed, solve_holding(held));
    if (!freed.has_converged) break;
    solved->is_curved |= freed.is_curved;
    solved->solution = std::move(freed);
    solved->held = std::move(held);
  }
  return absl::OkStatus();
}

// `from` with the turns of one set-up reversed, every combination of signs, for each set-up.
std::vector<Point> ReversedTurns(const Problem& problem, const Point& from) {
  std::vector<Point> starts;
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    if (FirstOfSetup(problem, i) != i) continue;
    const auto g = static_cast<size_t>(problem.group_of_run[i]);
    std::vector<Eigen::Index> turns;
    for (const Eigen::Index k : problem.offsets_of_run[i]) {
      const instruments::SetupParameter& parameter = problem.groups[g].parameters[static_cast<size_t>(k)];
      if (parameter.is_angle && !parameter.held) turns.push_back(k);
    }
    for (unsigned reversed = 1; reversed < 1u << turns.size(); ++reversed) {
      Point start = from;
      for (size_t k = 0; k < turns.size(); ++k) {
        if (reversed >> k & 1u) start.setup[g][turns[k]] *= -1.0;
      }
      starts.push_back(std::move(start));
    }
  }
  return starts;
}

// Whether the artefact's turn is seen by faces: it then acts by its square, too.
bool HasTouchedFaces(const Problem& problem) {
  return std::any_of(problem.runs.begin(), problem.runs.end(), [](const MeasuringRun& run) {
    const std::vector<touch::Feature>& features = run.touches.features;
    return run.kind == instruments::Kind::kTouch &&
           std::any_of(features.begin(), features.end(), [](const touch::Feature& one) { return !one.is_sphere; });
  });
}

// Holds each turn that rests on a weak prior at values over its prior and fits all else. What chi-square hardly refuses
// goes to `along_turns`, and where it leads to a minimum when the turn is free again, to `minima`.
absl::Status FollowTurns(const NullSpace& holding, const Options& options, SolvedProblem* solved) {
  const Solution from = solved->solution;
  const double rise = kRefused * std::max(1.0, from.cost / ReadingCount(solved->problem));
  Options short_way = options;
  constexpr int kIterations = 8;  // a turn that readings refuse is not followed to the end
  short_way.max_iterations = kIterations;
  for (size_t g = 0; g < solved->problem.groups.size(); ++g) {
    for (size_t k = 0; k < solved->problem.groups[g].parameters.size(); ++k) {
      const instruments::SetupParameter& turn = solved->problem.groups[g].parameters[k];
      if (!turn.is_angle || !turn.is_weak || turn.held || !std::isfinite(turn.prior_sigma)) continue;
      for (const double sigmas : {-2.0, -1.0, 0.0, 1.0, 2.0}) {
        Problem at_turn = solved->problem;
        Point start = from.point;
        start.setup[g][static_cast<Eigen::Index>(k)] = sigmas * turn.prior_sigma;
        at_turn.groups[g].parameters[k].held = sigmas * turn.prior_sigma;
        absl::StatusOr<Solution> held = Solve(at_turn, start, holding, short_way);
        if (absl::IsCancelled(held.status())) return held.status();
        if (!held.ok() || !held->has_converged || held->cost > from.cost + rise) continue;
        absl::StatusOr<Solution> freed = Solve(solved->problem, held->point, holding, options);
        if (absl::IsCancelled(freed.status())) return freed.status();
        solved->along_turns.push_back(*std::move(held));
        if (freed.ok() && freed->has_converged) solved->minima.push_back(*std::move(freed));
      }
    }
  }
  return absl::OkStatus();
}

// Solves a curved problem again from other starts (multi-start); sets `minima`, `along_turns` and the best solution.
absl::Status FindOtherMinima(const Options& options, SolvedProblem* solved) {
  solved->minima = {solved->solution};
  Options quiet = options;
  quiet.progress = nullptr;
  const NullSpace holding = solved->Holding();
  for (const Point& start : ReversedTurns(solved->problem, solved->solution.point)) {
    absl::StatusOr<Solution> other = Solve(solved->problem, start, holding, quiet);
    if (absl::IsCancelled(other.status())) return other.status();
    if (other.ok() && other->has_converged) solved->minima.push_back(*std::move(other));
  }
  if (HasTouchedFaces(solved->problem)) RETURN_IF_ERROR(FollowTurns(holding, quiet, solved));
  std::stable_sort(solved->minima.begin(), solved->minima.end(),
                   [](const Solution& a, const Solution& b) { return a.cost < b.cost; });
  solved->solution = solved->minima[0];
  return absl::OkStatus();
}

// Puts error `i` into the gauge. With C the covariance of the free errors, another one moves with it by
// C_ji / C_ii; where an error i of the largest size would move it by more than its own uncertainty beside i, it has no
// value of its own either.
void AddToGauge(int i, const Eigen::MatrixXd& covariance, double scale, SolvedProblem* solved) {
  NullSpace& space = solved->null_space;
  const machine::ErrorModel& model = solved->solution.point.model;
  const double largest = LargestOf(model, solved->parameters[i]);
  Eigen::RowVectorXd direction = covariance.col(i).transpose() / covariance(i, i);
  for (Eigen::Index j = 0; j < direction.size(); ++j) {
    const double beside = covariance(j, j) - direction[j] * covariance(i, j);
    if (std::abs(direction[j]) * largest <= scale * std::sqrt(std::max(0.0, beside)) ||
        solved->parameters[static_cast<size_t>(j)].is_nonlinear)
      direction[j] = 0.0;
  }
  for (const int fixed : space.fixed) direction[fixed] = 0.0;
  direction[i] = 1.0;
  for (Eigen::Index row = 0; row < space.directions.rows(); ++row)
    space.directions.row(row) -= (space.directions(row, i) * direction).eval();
  space.directions.conservativeResize(space.directions.rows() + 1, direction.size());
  space.directions.bottomRows(1) = direction;
  for (Eigen::Index j = 0; j < direction.size(); ++j) {
    if (direction[j] != 0.0) space.involved[static_cast<size_t>(j)] = true;
  }
  space.fixed.push_back(i);
  --space.rank;
  solved->held.push_back(i);
}

// Holds what the readings that are used leave open to more than LargestOf: a number of that width is none, and the
// model must not act by it. The gauge was found from the poses of all readings; those that were set aside may have been
// the ones that told.
absl::Status HoldTooWide(const Options& options, SolvedProblem* solved) {
  const std::vector<Parameter>& parameters = solved->parameters;
  while (true) {
    const Solution& solution = solved->solution;
    const double freedom = static_cast<double>(solution.normal.row_count) - solved->Unknowns(solution);
    const double scale = options.scale_uncertainties && freedom > 0.0
                             ? std::sqrt(std::max(1.0, JudgingCost(solved->problem, solution) / freedom))
                             : 1.0;
    const Eigen::MatrixXd covariance =
        InverseBeside(Reduce(solved->problem, solution.linearised, solution.normal, Priors::kAll), solved->held);
    const std::vector<int>& fixed = solved->null_space.fixed;
    int widest = -1;
    double most = 1.0;
    for (int i = 0; i < static_cast<int>(parameters.size()); ++i) {
      // One of the gauge that was freed (gauge.h) has no number anyway and would bias the others.
      if (std::find(fixed.begin(), fixed.end(), i) != fixed.end()) continue;
      const double sigma = scale * std::sqrt(std::max(0.0, covariance(i, i)));
      const double share = sigma / LargestOf(solution.point.model, parameters[i]);
      if (!(share > most)) continue;
      most = share;
      widest = i;
    }
    if (widest < 0) return absl::OkStatus();
    AddToGauge(widest, covariance, scale, solved);
    Point start = solution.point;
    SetValue(parameters[static_cast<size_t>(widest)], 0.0, &start.model);
    ASSIGN_OR_RETURN(solved->solution, Solve(solved->problem, start, solved->Holding(), options));
    if (!solved->solution.has_converged) return NotConverged(solved->solution);
  }
}

}  // namespace

NullSpace SolvedProblem::Holding() const {
  NullSpace holding = null_space;
  holding.fixed = held;
  return holding;
}

double SolvedProblem::Unknowns(const Solution& at) const {
  return static_cast<double>(parameters.size()) - static_cast<double>(held.size()) -
         AmplitudesFromPriors(problem, at.point, at.normal, held) +
         OffsetsFromReadings(problem, at.point, at.normal, held);
}

absl::StatusOr<SolvedProblem> SolveProblem(Problem problem, const machine::ErrorModel& model, const Options& options,
                                           const std::vector<Eigen::VectorXd>& setup) {
  DEMAND(setup.empty() || setup.size() == problem.groups.size());
  SolvedProblem solved;
  solved.problem = std::move(problem);
  solved.parameters = ListParameters(model, options.fit_nonlinear);
  const int readings = ReadingCount(solved.problem);
  // Setups and free curves bring a prior each; errors need readings.
  const auto needing = std::count_if(solved.parameters.begin(), solved.parameters.end(),
                                     [&](const Parameter& one) { return PriorPrecision(model, one) == 0.0; });
  if (readings < needing)
    return absl::FailedPreconditionError(absl::StrCat(readings, " readings cannot determine ", needing, " errors"));
  RETURN_IF_ERROR(FindMinimum(model, setup, options, &solved));
  solved.is_curved = solved.solution.is_curved;
  RETURN_IF_ERROR(FreeHeldErrors(options, &solved));
  solved.is_way_curved = solved.is_curved;
  // The way to a minimum may be straight where its surroundings are not.
  solved.is_curved = options.profile_intervals && ((solved.is_curved && MayBeCurved(solved.problem)) ||
                                                   (HasTouchedFaces(solved.problem) && !solved.parameters.empty()));
  if (solved.is_curved) RETURN_IF_ERROR(FindOtherMinima(options, &solved));
  const NullSpace holding = solved.Holding();
  constexpr int kRounds = 5;
  for (int round = 0; options.set_outliers_aside && round < kRounds; ++round) {
    if (!SetOutliersAside(solved.solution.residuals_mm, &solved.problem, &solved.standing_out)) break;
    const auto solve_again = [&] { return Solve(solved.problem, solved.solution.point, holding, options); };
    ASSIGN_OR_RETURN(solved.solution, solve_again());
    RETURN_IF_ERROR(RaiseNoiseUntilConverged(options, solve_again, &solved));
  }
  RETURN_IF_ERROR(HoldTooWide(options, &solved));
  return solved;
}

}  // namespace axiscal::identify
