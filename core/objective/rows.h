// A linearised problem: y = columns of effects x amplitudes + nuisance x anything + noise, all rows whitened.
#ifndef AXISCAL_CORE_OBJECTIVE_ROWS_H_
#define AXISCAL_CORE_OBJECTIVE_ROWS_H_

#include <Eigen/Core>
#include <vector>

#include "core/objective/whitening.h"

namespace axiscal::objective {

// Rows that stand together and share the nuisance columns of one group (a session's set-up): a series.
struct Stretch {
  int begin = 0, end = 0, group = 0;
};

struct Rows {
  Whitening whitening;
  std::vector<Stretch> stretches;  // one after the other; they cover all rows
  Eigen::VectorXd y;               // whitened
  // Whitened nuisance columns of the row's own group, the first own_precision[group].size() of a row count, and of all
  // rows. Priors with mean 0 hold them: precision, one over the variance (0: none).
  Eigen::MatrixXd own, common;
  std::vector<Eigen::VectorXd> own_precision;
  Eigen::VectorXd common_precision;
  // Value at the point of linearisation of each group's nuisance, of which the priors have y's residual.
  std::vector<Eigen::VectorXd> own_value;
  // Ways in which rows may share what is not in the model (session, series, pose, block of time ...): a cluster's
  // number per row, from 0.
  std::vector<std::vector<int>> clusterings;

  // Squares (whitened) that an effect may seem to explain although it is not there, as a coarse display rounds what it
  // shows: none that explains less is claimed.
  double rounding_squares = 0.0;
  // Squares (whitened) that noise leaves at least: what explains more of readings without noise explains rounding and
  // what is left of linearising, and would never end.
  double least_squares = 0.0;

  int count() const { return static_cast<int>(y.size()); }
};

}  // namespace axiscal::objective

#endif  // AXISCAL_CORE_OBJECTIVE_ROWS_H_
