// Gauss-Newton with halved steps on the arrow of problem.h.
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
  double cost = 0.0;  // whitened squares and priors at the last linearisation
};

// What the data cannot see of the amplitudes: a property of poses and error terms, judged at the nominal machine, where
// degeneracies are exact.
NullSpace NominalNullSpace(const Problem& problem, const machine::ErrorModel& model, bool with_nonlinear);

// Fits all terms of `start` and all setups from `start` on, the null directions held. FAILED_PRECONDITION without
// convergence, CANCELLED.
absl::StatusOr<Solution> Solve(const Problem& problem, const Point& start, const NullSpace& null_space,
                               const Options& options);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_SOLVER_H_
