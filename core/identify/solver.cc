#include "core/identify/solver.h"

#include <algorithm>

namespace axiscal::identify {
namespace {

// A model that misses by more sigmas than this, all readings taken together, is not fitted on but given a larger sigma
// (identify.cc).
constexpr double kFarOff = 10.0;

Point Moved(const Point& from, const std::vector<Parameter>& parameters, const Step& step) {
  Point to = from;
  for (size_t i = 0; i < parameters.size(); ++i) {
    double value = ValueOf(from.model, parameters[i]) + step.errors[i];
    if (parameters[i].is_nonlinear) {
      // Lengths and time constants stay positive and move by a factor of three at most in one step; a frequency a few
      // periods off is another one.
      const double old = ValueOf(from.model, parameters[i]);
      const bool is_frequency = std::holds_alternative<shapes::Harmonic>(from.model.terms[parameters[i].term].shape);
      const double most = is_frequency ? 1.01 : 3.0;
      value = std::clamp(value, old / most, old * most);
    }
    SetValue(parameters[i], value, &to.model);
  }
  for (size_t g = 0; g < to.setup.size(); ++g) to.setup[g] += step.setup[g];
  return to;
}

double CostOf(const Problem& problem, const Point& point, const NormalEquations& normal) {
  double cost = PriorSquares(problem, point);
  for (const GroupNormal& group : normal.groups) cost += group.gram(group.gram.rows() - 1, group.gram.cols() - 1);
  return cost;
}

// Takes `step`, or a more damped one that does not raise the cost. Undamped steps are the rule; where a bad model bends
// the problem (a bar pulled far across its length) the damping grows until the step is honest. Returns the new cost.
absl::StatusOr<double> Descend(const Problem& problem, const std::vector<Parameter>& parameters,
                               const std::vector<int>& held, Step step, double cost, double* damping,
                               Solution* solution) {
  constexpr double kFirstDamping = 1e-4, kGrowth = 10.0, kLargestDamping = 1e9;
  while (true) {
    Point next = Moved(solution->point, parameters, step);
    NormalEquations normal = Assemble(problem, next, parameters);
    const double next_cost = CostOf(problem, next, normal);
    if (next_cost <= cost * (1.0 + 1e-12)) {
      solution->point = std::move(next);
      solution->normal = std::move(normal);
      // A step that keeps little of what it promised was too long: it zigzags across a bent valley.
      constexpr double kKeepsLittle = 0.25;
      if (cost - next_cost < kKeepsLittle * step.decrement) {
        *damping = *damping == 0.0 ? kFirstDamping : *damping * kGrowth;
      } else {
        *damping = *damping <= kFirstDamping ? 0.0 : *damping / kGrowth;
      }
      return next_cost;
    }
    *damping = *damping == 0.0 ? kFirstDamping : *damping * kGrowth;
    if (!(*damping <= kLargestDamping)) return absl::FailedPreconditionError("identification does not descend");
    step = SolveStep(problem, solution->point, solution->normal, held, *damping);
  }
}

}  // namespace

Nominal AtNominal(const Problem& problem, const machine::ErrorModel& model) {
  machine::ErrorModel zero = model;
  for (machine::ErrorTerm& term : zero.terms) term.amplitude.fill(0.0);
  Nominal nominal;
  nominal.point = StartingPoint(problem, zero);
  nominal.normal = Assemble(problem, nominal.point, ListParameters(zero, false));
  if (problem.fixed_model.terms.empty()) {
    nominal.null_space = FindNullSpace(Reduce(problem, nominal.point, nominal.normal, Priors::kInformative));
    return nominal;
  }
  Problem free_of_errors = problem;
  free_of_errors.fixed_model = {};
  const NormalEquations normal = Assemble(free_of_errors, nominal.point, ListParameters(zero, false));
  nominal.null_space = FindNullSpace(Reduce(free_of_errors, nominal.point, normal, Priors::kInformative));
  return nominal;
}

NullSpace WithNonlinearColumns(const NullSpace& space, const machine::ErrorModel& model) {
  const std::vector<Parameter> all = ListParameters(model, true);
  NullSpace out = space;
  out.involved.assign(all.size(), false);
  out.directions = Eigen::MatrixXd::Zero(space.directions.rows(), static_cast<Eigen::Index>(all.size()));
  std::vector<int> at;
  for (size_t i = 0; i < all.size(); ++i) {
    if (all[i].is_nonlinear) {
      ++out.rank;
      continue;
    }
    const size_t amplitude = at.size();
    out.involved[i] = space.involved[amplitude];
    out.directions.col(i) = space.directions.col(amplitude);
    at.push_back(static_cast<int>(i));
  }
  for (int& column : out.fixed) column = at[column];
  return out;
}

absl::StatusOr<Solution> Solve(const Problem& problem, const Point& start, const NullSpace& null_space,
                               const Options& options, const NormalEquations* at_start) {
  const std::vector<Parameter> parameters = ListParameters(start.model, options.fit_nonlinear);
  Solution solution;
  solution.point = start;
  solution.normal = at_start != nullptr ? *at_start : Assemble(problem, start, parameters);
  double cost = CostOf(problem, start, solution.normal), previous_decrement = 0.0, damping = 0.0;
  int flat_steps = 0;
  for (int iteration = 1; iteration <= options.max_iterations; ++iteration) {
    if (options.cancelled && options.cancelled()) return absl::CancelledError("identification cancelled");
    const Step step = SolveStep(problem, solution.point, solution.normal, null_space.fixed, damping);
    if (!step.errors.allFinite())
      return absl::FailedPreconditionError("identification: the normal equations are singular");
    solution.iterations = iteration;
    if (options.progress) {
      options.progress({"fitting", static_cast<double>(iteration) / options.max_iterations,
                        absl::StrFormat("iteration %d, chi-square %.6g", iteration, cost)});
    }
    // Convergence is quadratic: where this step and the one before promise that the next would not matter, this one is
    // the last.
    const bool is_last =
        step.decrement < options.converged_decrement ||
        (iteration > 1 && step.decrement * (step.decrement / previous_decrement) < options.converged_decrement);
    if (is_last) {
      // What nothing holds (a tracker's turn about a line of points) may go far for next to nothing: not where it
      // costs.
      Point last = Moved(solution.point, parameters, step);
      const double last_cost = WhitenedSquares(problem, ResidualsOf(problem, last)) + PriorSquares(problem, last);
      if (last_cost <= cost * (1.0 + 1e-12) + options.converged_decrement) solution.point = std::move(last);
      solution.has_converged = true;
      break;
    }
    previous_decrement = step.decrement;
    const double cost_before = cost;
    ASSIGN_OR_RETURN(cost, Descend(problem, parameters, null_space.fixed, step, cost, &damping, &solution));
    // A valley so flat that its floor, wherever it is, fits no better: only a model that misses has one.
    constexpr double kFlat = 2e-3;
    constexpr int kFlatSteps = 4;
    flat_steps = cost_before - cost < kFlat * cost ? flat_steps + 1 : 0;
    if (flat_steps == kFlatSteps && cost < kFarOff * kFarOff * solution.normal.row_count) {
      solution.has_converged = true;
      break;
    }
  }
  solution.cost = cost;
  solution.residuals_mm = ResidualsOf(problem, solution.point);
  return solution;
}

}  // namespace axiscal::identify
