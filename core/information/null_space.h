// Directions in the space of unknowns that readings do not see: named, they are what a set of tests cannot tell.
#ifndef AXISCAL_CORE_INFORMATION_NULL_SPACE_H_
#define AXISCAL_CORE_INFORMATION_NULL_SPACE_H_

#include <Eigen/Core>
#include <vector>

#include "core/information/information.h"

namespace axiscal::information {

struct NullSpace {
  // One row per direction, in units of the unknowns (mm, rad); row k has 1 at column fixed[k], 0 at the others of
  // `fixed`.
  Eigen::MatrixXd directions;
  std::vector<int> fixed;      // the unknowns that are held while the others are fitted (the gauge)
  std::vector<bool> involved;  // per unknown: takes part in some direction, so it has no value of its own
  int rank = 0;
  double condition = 0.0;  // largest over smallest singular value of the scaled Jacobian, null directions left out
};

// Singular values of the column-scaled Jacobian below `threshold` (relative to a column's norm before the set-up was
// eliminated) count as zero.
inline constexpr double kRankThreshold = 1e-5;
NullSpace FindNullSpace(const Information& information, double threshold = kRankThreshold);

}  // namespace axiscal::information

#endif  // AXISCAL_CORE_INFORMATION_NULL_SPACE_H_
