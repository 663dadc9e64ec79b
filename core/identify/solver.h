// Gauss-Newton with damped steps (Levenberg-Marquardt) on the normal equations of problem.h.
#ifndef AXISCAL_CORE_IDENTIFY_SOLVER_H_
#define AXISCAL_CORE_IDENTIFY_SOLVER_H_

#include "core/identify/identify.h"
#include "core/identify/reduction.h"

namespace axiscal::identify {

struct Solution {
  Point point;
  // Where `normal` was assembled: a last step before `point`, which chi-square hardly tells from it. What is put into
  // equations with `normal` is taken there: offsets that the readings hardly see may go far by that step.
  Point linearised;
  NormalEquations normal;
  std::vector<Eigen::MatrixXd> residuals_mm;
  int iterations = 0;
  bool has_converged = false;
  // Some step had to be damped or led back: readings are far from linear in the unknowns, and uncertainties by linear
  // propagation may be too small.
  bool is_curved = false;
  double cost = 0.0;  // chi-square: whitened squares and priors at the last linearisation
};

// Fits all terms of `start` and all setups from `start` on, the null directions held. FAILED_PRECONDITION when no step
// descends, CANCELLED. Without convergence within options.max_iterations the last point comes back, has_converged
// false. `at_start`: the normal equations there, where they are known.
absl::StatusOr<Solution> Solve(const Problem& problem, const Point& start, const NullSpace& null_space,
                               const Options& options, const NormalEquations* at_start = nullptr);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_SOLVER_H_
