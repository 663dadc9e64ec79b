#include "core/objective/nuisance.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace axiscal::objective {
namespace {

// B with B' G B = 1 on the space that G sees.
Eigen::MatrixXd InverseRoot(const Eigen::MatrixXd& gram) {
  const Eigen::Index n = gram.rows();
  if (n == 0) return gram;
  Eigen::VectorXd scale(n);
  for (Eigen::Index i = 0; i < n; ++i) scale[i] = gram(i, i) > 0.0 ? 1.0 / std::sqrt(gram(i, i)) : 0.0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * gram * scale.asDiagonal());
  constexpr double kSeen = 1e-11;  // of a unit column: beyond rounding
  Eigen::VectorXd root(n);
  for (Eigen::Index i = 0; i < n; ++i)
    root[i] = eigen.eigenvalues()[i] > kSeen ? 1.0 / std::sqrt(eigen.eigenvalues()[i]) : 0.0;
  return scale.asDiagonal() * eigen.eigenvectors() * root.asDiagonal();
}

}  // namespace

Nuisance::Nuisance(const Rows& rows) : rows_(rows) {
  const Eigen::Index p = rows.common.cols();
  std::vector<Eigen::MatrixXd> gram;
  for (const Eigen::VectorXd& precision : rows.own_precision) {
    gram.emplace_back(precision.asDiagonal());
    offset_.push_back(size_);
    size_ += precision.size();
  }
  size_ += p;
  for (const Stretch& some : rows.stretches) {
    const Eigen::Index s = gram[some.group].rows(), n = some.end - some.begin;
    const auto own = rows.own.block(some.begin, 0, n, s);
    gram[some.group].noalias() += own.transpose() * own;
  }
  for (const Eigen::MatrixXd& one : gram) {
    own_basis_.push_back(InverseRoot(one));
    own_common_.push_back(Eigen::MatrixXd::Zero(one.rows(), p));
  }
  for (const Stretch& some : rows.stretches) {
    const Eigen::Index s = gram[some.group].rows(), n = some.end - some.begin;
    own_common_[some.group] += own_basis_[some.group].transpose() * (rows.own.block(some.begin, 0, n, s).transpose() *
                                                                     rows.common.middleRows(some.begin, n));
  }
  Eigen::MatrixXd reduced = rows.common.transpose() * rows.common;
  for (const Eigen::MatrixXd& one : own_common_) reduced.noalias() -= one.transpose() * one;
  reduced.diagonal() += rows.common_precision;
  common_basis_ = InverseRoot(reduced);
}

void Nuisance::Finish(Eigen::Ref<Eigen::MatrixXd> products) const {
  const Eigen::Index p = common_basis_.cols();
  for (size_t g = 0; g < own_basis_.size(); ++g) {
    auto own = products.middleCols(offset_[g], own_basis_[g].rows());
    own = (own * own_basis_[g]).eval();
    if (p > 0) products.rightCols(p).noalias() -= own * own_common_[g];
  }
  if (p > 0) products.rightCols(p) = (products.rightCols(p) * common_basis_).eval();
}

Eigen::VectorXd Nuisance::CoefficientsOf(const Eigen::VectorXd& column) const {
  const Eigen::Index p = common_basis_.cols();
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(1, size_);
  for (const Stretch& some : rows_.stretches) {
    const Eigen::Index s = own_basis_[some.group].rows(), n = some.end - some.begin;
    products.middleCols(offset_[some.group], s) +=
        column.segment(some.begin, n).transpose() * rows_.own.block(some.begin, 0, n, s);
  }
  products.rightCols(p) = column.transpose() * rows_.common;
  Finish(products);
  return products.row(0).transpose();
}

Eigen::VectorXd Nuisance::OfPriors() const {
  Eigen::MatrixXd pull = Eigen::MatrixXd::Zero(1, size_);
  for (size_t g = 0; g < rows_.own_value.size(); ++g) {
    const Eigen::VectorXd& value = rows_.own_value[g];
    pull.middleCols(offset_[g], value.size()) = value.cwiseProduct(rows_.own_precision[g]).transpose();
  }
  Finish(pull);
  return pull.row(0).transpose();
}

double Nuisance::PriorSquares() const {
  double squares = 0.0;
  for (size_t g = 0; g < rows_.own_value.size(); ++g)
    squares += rows_.own_value[g].cwiseAbs2().dot(rows_.own_precision[g]);
  return squares;
}

Eigen::VectorXd Nuisance::Explained(const Eigen::VectorXd& coefficients) const {
  const Eigen::Index p = common_basis_.cols();
  const Eigen::VectorXd by_common = common_basis_ * coefficients.tail(p);
  Eigen::VectorXd column = rows_.common * by_common;
  for (const Stretch& some : rows_.stretches) {
    const Eigen::Index s = own_basis_[some.group].rows(), n = some.end - some.begin;
    const Eigen::VectorXd by_own =
        own_basis_[some.group] * (coefficients.segment(offset_[some.group], s) - own_common_[some.group] * by_common);
    column.segment(some.begin, n).noalias() += rows_.own.block(some.begin, 0, n, s) * by_own;
  }
  return column;
}

}  // namespace axiscal::objective
