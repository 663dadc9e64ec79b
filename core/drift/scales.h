// By how much calibrations of a machine scatter more than they state, and how fast its errors wander.
#ifndef AXISCAL_CORE_DRIFT_SCALES_H_
#define AXISCAL_CORE_DRIFT_SCALES_H_

#include <Eigen/Core>

#include "core/drift/state.h"

namespace axiscal::drift {

// Errors share what they know: each one's scale is drawn to the machine's mean.
struct Scales {
  double common = 1.0;   // factor of the stated covariance
  Eigen::VectorXd each;  // n: scatter by statement, squared
  Eigen::VectorXd rate;  // n: q^2, units^2 per week
};
Scales ScalesOf(const State& state);

// common * stated, and for each error that scatters more, the excess on the diagonal. (A factor of each error's own
// would make combinations that are known badly look as if they were known well.)
Eigen::MatrixXd NoiseOf(const Eigen::MatrixXd& stated, const Scales& scales);

}  // namespace axiscal::drift

#endif  // AXISCAL_CORE_DRIFT_SCALES_H_
