// Gauss-Newton with damped steps on the arrow of problem.h.
#ifndef AXISCAL_CORE_IDENTIFY_SOLVER_H_
#define AXISCAL_CORE_IDENTIFY_SOLVER_H_

#include "core/identify/identify.h"
#include "core/identify/reduction.h"

namespace axiscal::identify {

struct Solution {
  Point point;
  NormalEquations normal;  // at the last linearisation, a step of less than a thousandth of sigma away
  std::vector<Eigen::MatrixXd> residuals_mm;
  int iterations = 0;
  bool has_converged = false;
  bool is_bent = false;  // some step had to be damped or led back: uncertainties by linear propagation may be too small
  double cost = 0.0;     // whitened squares and priors at the last linearisation
};

// The problem at the nominal machine, all amplitudes and offsets zero. What the data cannot see of the amplitudes is a
// property of poses and error terms, judged there, where degeneracies are exact.
struct Nominal {
  Point point;
  NormalEquations normal;  // of the amplitudes; errors that the problem holds act
  NullSpace null_space;    // of the amplitudes; none act
};
Nominal AtNominal(const Problem& problem, const machine::ErrorModel& model);

// The same directions in the columns of ListParameters(model, true). A non-linear parameter is judged by its own
// uncertainty, not by rank.
NullSpace WithNonlinearColumns(const NullSpace& space, const machine::ErrorModel& model);

// Fits all terms of `start` and all setups from `start` on, the null directions held. FAILED_PRECONDITION when no step
// descends, CANCELLED. Without convergence within options.max_iterations the last point comes back, has_converged
// false. `at_start`: the normal equations there, where they are known.
absl::StatusOr<Solution> Solve(const Problem& problem, const Point& start, const NullSpace& null_space,
                               const Options& options, const NormalEquations* at_start = nullptr);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_SOLVER_H_
