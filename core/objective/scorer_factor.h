// What the scorer's two sources share: a state's factor (scorer.cc), what may be added to it (scorer_additions.cc).
#ifndef AXISCAL_CORE_OBJECTIVE_SCORER_FACTOR_H_
#define AXISCAL_CORE_OBJECTIVE_SCORER_FACTOR_H_

#include <Eigen/Core>
#include <vector>

#include "core/objective/scorer.h"

namespace axiscal::objective {

// A flat column's own ridge, share of its squares: rounding of the products.
inline constexpr double kRidge = 1e-10;

// Cholesky factor of K + D (precision of the priors), flat members' columns first.
struct Scorer::Factor {
  bool is_possible = true;
  std::vector<Eigen::Index> first;  // per member: where its columns stand
  Eigen::MatrixXd lower;
  Eigen::VectorXd half;   // lower^-1 b
  Eigen::Index flat = 0;  // columns of flat members
  double squares = 0.0;   // rss
  double log_det = 0.0;   // of the blocks
  double prices = 0.0;
};

}  // namespace axiscal::objective

#endif  // AXISCAL_CORE_OBJECTIVE_SCORER_FACTOR_H_
