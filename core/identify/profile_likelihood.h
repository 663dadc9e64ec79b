// Errors whose interval is not what linear propagation says.
//
// Linear propagation takes chi-square for a parabola: with all other unknowns refitted (the profile likelihood; Bates
// and Watts 1988, "Nonlinear Regression Analysis and Its Applications", ch. 6), it rises by k^2 where an error is k
// standard uncertainties off. Two findings contradict it: the profile rises by something else, or a second minimum that
// chi-square hardly refuses puts the error elsewhere.
#ifndef AXISCAL_CORE_IDENTIFY_PROFILE_LIKELIHOOD_H_
#define AXISCAL_CORE_IDENTIFY_PROFILE_LIKELIHOOD_H_

#include <vector>

#include "core/identify/solve.h"

namespace axiscal::identify {

// Per parameter; none where the problem is not curved. `linear`: covariance of the errors by the readings' noise as
// stated, p x p; `curved`: what set-ups that rest on their priors add by curvature (curved_setup.h); `sigma_scale`: by
// how much the readings scatter more than stated. CANCELLED as Solve().
absl::StatusOr<std::vector<bool>> FindWithoutInterval(const SolvedProblem& solved, const Eigen::MatrixXd& linear,
                                                      const Eigen::MatrixXd& curved, double sigma_scale,
                                                      const Options& options);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_PROFILE_LIKELIHOOD_H_
