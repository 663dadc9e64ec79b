#include "core/identify/solver.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace axiscal::identify {
namespace {

// A tenth of a standard deviation: over such a step everything is linear.
constexpr double kSmallDecrement = 1e-2;

// A model that misses by more sigmas than this, all readings taken together, is not fitted on but given a larger sigma
// (solve.cc).
constexpr double kFarOff = 10.0;

Point Moved(const Point& from, const std::vector<Parameter>& parameters, const GaussNewtonStep& step) {
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

// How much each set-up offset shows in the readings, per group.
std::vector<Eigen::VectorXd> SetupShown(const NormalEquations& normal) {
  std::vector<Eigen::VectorXd> shown;
  for (const GroupNormal& group : normal.groups) shown.push_back(group.gram.diagonal().head(group.setup_count));
  return shown;
}

// Whether a step changed that of no offset by more than a tenth; what is nothing beside the others of its unit may
// change.
bool IsSteady(const Problem& problem, const std::vector<Eigen::VectorXd>& before,
              const std::vector<Eigen::VectorXd>& after) {
  constexpr double kChanged = 0.1, kNothing = 1e-4;
  for (size_t g = 0; g < before.size(); ++g) {
    double largest[2] = {0.0, 0.0};
    const auto unit = [&](Eigen::Index i) -> double& { return largest[problem.groups[g].parameters[i].is_angle]; };
    for (Eigen::Index i = 0; i < before[g].size(); ++i) unit(i) = std::max({unit(i), before[g][i], after[g][i]});
    for (Eigen::Index i = 0; i < before[g].size(); ++i) {
      const double allowed = std::max(kChanged * std::max(before[g][i], after[g][i]), kNothing * unit(i));
      if (std::abs(after[g][i] - before[g][i]) > allowed) return false;
    }
  }
  return true;
}

// Takes `step`, or a more damped one that does not raise the cost. Undamped steps are the rule. Where readings are far
// from linear in the unknowns (a bar pulled far across its length, a turn that shows only off the middle of a face) a
// long step leaves the floor of its curved valley. A damped step from there leads back to the floor, and the two count
// as one where they lower the cost by half of what `step` predicted; otherwise the damping grows until a step does what
// it predicts.
class Descent {
 public:
  Descent(const Problem& problem, const std::vector<Parameter>& parameters, const std::vector<int>& held)
      : problem_(problem), parameters_(parameters), held_(held) {}

  double damping() const { return damping_; }
  bool is_curved() const { return is_curved_; }

  // Moves `solution` from `cost` on. Returns the new cost.
  absl::StatusOr<double> Take(GaussNewtonStep step, double cost, Solution* solution) {
    while (true) {
      Trial trial = Try(solution->point, step);
      if (trial.cost <= cost * (1.0 + 1e-12)) {
        // A step that lowers the cost by little of what it predicted was too long: it zigzags across a curved valley.
        constexpr double kKeepsLittle = 0.25;
        if (cost - trial.cost < kKeepsLittle * step.decrement) {
          Raise();
        } else {
          damping_ = damping_ <= kLeastDamping ? 0.0 : damping_ / kGrowth;
        }
        return Accept(std::move(trial), solution);
      }
      const GaussNewtonStep back =
          SolveStep(problem_, trial.point, trial.normal, held_, std::max(kFirstDamping, kGrowth * damping_));
      Trial on_floor = Try(trial.point, back);
      constexpr double kKeepsHalf = 0.5;
      if (on_floor.cost < cost - kKeepsHalf * step.decrement) {
        is_curved_ = true;
        return Accept(std::move(on_floor), solution);
      }
      Raise();
      if (!(damping_ <= kLargestDamping)) return absl::FailedPreconditionError("identification does not descend");
      step = SolveStep(problem_, solution->point, solution->normal, held_, damping_);
    }
  }

 private:
  static constexpr double kFirstDamping = 1e-4, kLeastDamping = 1e-10, kGrowth = 10.0, kLargestDamping = 1e9;

  struct Trial {
    Point point;
    NormalEquations normal;
    double cost = 0.0;
  };

  Trial Try(const Point& from, const GaussNewtonStep& step) const {
    Trial trial;
    trial.point = Moved(from, parameters_, step);
    trial.normal = Assemble(problem_, trial.point, parameters_);
    trial.cost = CostOf(problem_, trial.point, trial.normal);
    return trial;
  }

  static double Accept(Trial trial, Solution* solution) {
    solution->point = std::move(trial.point);
    solution->normal = std::move(trial.normal);
    return trial.cost;
  }

  void Raise() {
    damping_ = damping_ == 0.0 ? kFirstDamping : damping_ * kGrowth;
    is_curved_ = true;
  }

  const Problem& problem_;
  const std::vector<Parameter>& parameters_;
  const std::vector<int>& held_;
  double damping_ = 0.0;
  bool is_curved_ = false;
};

}  // namespace

absl::StatusOr<Solution> Solve(const Problem& problem, const Point& start, const NullSpace& null_space,
                               const Options& options, const NormalEquations* at_start) {
  const std::vector<Parameter> parameters = ListParameters(start.model, options.fit_nonlinear);
  Solution solution;
  solution.point = start;
  solution.normal = at_start != nullptr ? *at_start : Assemble(problem, start, parameters);
  double cost = CostOf(problem, start, solution.normal), previous_decrement = 0.0;
  Descent descent(problem, parameters, null_space.fixed);
  int flat_steps = 0;
  bool is_steady = false;
  std::optional<Point> last_step;
  for (int iteration = 1; iteration <= options.max_iterations; ++iteration) {
    if (options.cancelled && options.cancelled()) return absl::CancelledError("identification cancelled");
    const GaussNewtonStep step =
        SolveStep(problem, solution.point, solution.normal, null_space.fixed, descent.damping());
    if (!step.errors.allFinite())
      return absl::FailedPreconditionError("identification: the normal equations are singular");
    solution.iterations = iteration;
    if (options.progress) {
      options.progress({"fitting", static_cast<double>(iteration) / options.max_iterations,
                        absl::StrFormat("iteration %d, chi-square %.6g", iteration, cost)});
    }
    // Convergence is quadratic: where this step and the one before say that the next would not matter, this one is the
    // last. Not after a long step that made show what hardly did before (a turn of a face that was touched in its
    // middle), which no earlier step tells.
    const bool is_last = step.decrement < options.converged_decrement ||
                         (iteration > 1 && (step.decrement < kSmallDecrement || is_steady) &&
                          step.decrement * (step.decrement / previous_decrement) < options.converged_decrement);
    // What damping held back is no convergence.
    const bool is_held_back = is_last && descent.damping() > 0.0 &&
                              !(SolveStep(problem, solution.point, solution.normal, null_space.fixed).decrement <
                                std::max(kSmallDecrement, options.converged_decrement));
    if (is_last && !is_held_back) {
      // What nothing holds (a tracker's turn about a line of points) may go far for next to nothing: not where it
      // costs.
      Point last = Moved(solution.point, parameters, step);
      std::vector<Eigen::MatrixXd> residuals_mm = ResidualsOf(problem, last);
      const double last_cost = WhitenedSquares(problem, residuals_mm) + PriorSquares(problem, last);
      if (last_cost <= cost * (1.0 + 1e-12) + options.converged_decrement) {
        last_step = std::move(last);
        solution.residuals_mm = std::move(residuals_mm);
      }
      solution.has_converged = true;
      break;
    }
    previous_decrement = step.decrement;
    const double cost_before = cost;
    const std::vector<Eigen::VectorXd> shown_before = SetupShown(solution.normal);
    ASSIGN_OR_RETURN(cost, descent.Take(step, cost, &solution));
    is_steady = IsSteady(problem, shown_before, SetupShown(solution.normal));
    // A valley so flat that its floor, wherever it is, fits no better: only a model that misses has one.
    constexpr double kFlat = 2e-3;
    constexpr int kFlatSteps = 4;
    flat_steps = cost_before - cost < kFlat * cost ? flat_steps + 1 : 0;
    if (flat_steps == kFlatSteps && cost < kFarOff * kFarOff * solution.normal.row_count) {
      solution.has_converged = true;
      break;
    }
  }
  solution.linearised = solution.point;
  if (last_step) solution.point = *std::move(last_step);
  solution.cost = cost;
  solution.is_curved = descent.is_curved();
  if (solution.residuals_mm.empty()) solution.residuals_mm = ResidualsOf(problem, solution.point);
  return solution;
}

}  // namespace axiscal::identify
