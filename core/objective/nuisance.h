// What the nuisance of a problem can explain of a column: coefficients on an orthonormal basis of its columns with the
// priors as further rows. The products of two columns after projection are those before it less those of their
// coefficients. No reading links two groups, so the basis has the shape of an arrow ("block angular", Bjorck 1996, 6.3)
// and memory is rows x (own nuisance + common).
#ifndef AXISCAL_CORE_OBJECTIVE_NUISANCE_H_
#define AXISCAL_CORE_OBJECTIVE_NUISANCE_H_

#include <Eigen/Core>
#include <vector>

#include "core/objective/rows.h"

namespace axiscal::objective {

class Nuisance {
 public:
  explicit Nuisance(const Rows& rows);

  Eigen::Index size() const { return size_; }
  // Where the coefficients of a group's own nuisance begin; those of the common one stand last.
  Eigen::Index OffsetOf(int group) const { return offset_[group]; }
  // In place, columns x size(): from products with the raw nuisance columns to coefficients.
  void Finish(Eigen::Ref<Eigen::MatrixXd> products) const;
  // Coefficients of one whitened column of all rows.
  Eigen::VectorXd CoefficientsOf(const Eigen::VectorXd& column) const;
  // What the priors' own rows add to the coefficients of y, and to its squares.
  Eigen::VectorXd OfPriors() const;
  double PriorSquares() const;
  // The part of a column that has these coefficients, at the rows.
  Eigen::VectorXd Explained(const Eigen::VectorXd& coefficients) const;

 private:
  const Rows& rows_;
  std::vector<Eigen::MatrixXd> own_basis_;   // per group: its columns times this are orthonormal with the priors' rows
  std::vector<Eigen::MatrixXd> own_common_;  // per group: own-basis coefficients of the common columns
  std::vector<Eigen::Index> offset_;
  Eigen::MatrixXd common_basis_;
  Eigen::Index size_ = 0;
};

}  // namespace axiscal::objective

#endif  // AXISCAL_CORE_OBJECTIVE_NUISANCE_H_
