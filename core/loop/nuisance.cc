#include "core/loop/nuisance.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/identify/reduction.h"

namespace axiscal::loop {

Eigen::MatrixXd InverseRoot(const Eigen::MatrixXd& gram) {
  const Eigen::Index n = gram.rows();
  Eigen::VectorXd scale(n);
  for (Eigen::Index i = 0; i < n; ++i) scale[i] = gram(i, i) > 0.0 ? 1.0 / std::sqrt(gram(i, i)) : 0.0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * gram * scale.asDiagonal());
  constexpr double kSeen = 1e-11;
  Eigen::VectorXd root(n);
  for (Eigen::Index i = 0; i < n; ++i)
    root[i] = eigen.eigenvalues()[i] > kSeen ? 1.0 / std::sqrt(eigen.eigenvalues()[i]) : 0.0;
  return scale.asDiagonal() * eigen.eigenvectors() * root.asDiagonal();
}

Nuisance::Nuisance(const identify::Problem& problem, const std::vector<Series>& series, Eigen::MatrixXd columns,
                   const Eigen::VectorXd& precision)
    : columns_(std::move(columns)), widest_(columns_.cols() - precision.size()) {
  const Eigen::Index p = precision.size();
  const size_t groups = problem.groups.size();
  std::vector<Eigen::MatrixXd> gram(groups);
  for (size_t g = 0; g < groups; ++g) {
    const auto s = static_cast<Eigen::Index>(problem.groups[g].parameters.size());
    gram[g] = Eigen::MatrixXd::Zero(s, s);
    for (Eigen::Index k = 0; k < s; ++k)
      gram[g](k, k) = identify::PriorPrecision(problem.groups[g].parameters[k], identify::Priors::kAll);
    offset_.push_back(size_);
    size_ += s;
  }
  size_ += p;
  for (const Series& rows : series) {
    const Eigen::Index s = gram[rows.group].rows();
    const auto block = columns_.block(rows.begin, widest_ - s, rows.end - rows.begin, s);
    gram[rows.group].noalias() += block.transpose() * block;
  }
  for (size_t g = 0; g < groups; ++g) {
    setup_basis_.push_back(InverseRoot(gram[g]));
    setup_error_.push_back(Eigen::MatrixXd::Zero(gram[g].rows(), p));
  }
  for (const Series& rows : series) {
    const Eigen::Index n = rows.end - rows.begin;
    setup_error_[rows.group] += setup_basis_[rows.group].transpose() *
                                (SetupOf(rows.group, rows.begin, n).transpose() * ErrorsOf(rows.begin, n));
  }
  Eigen::MatrixXd reduced = columns_.rightCols(p).transpose() * columns_.rightCols(p);
  for (size_t g = 0; g < groups; ++g) reduced -= setup_error_[g].transpose() * setup_error_[g];
  reduced.diagonal() += precision;
  error_basis_ = p > 0 ? InverseRoot(reduced) : Eigen::MatrixXd(0, 0);
}

void Nuisance::Finish(Eigen::MatrixXd* raw) const {
  const Eigen::Index p = error_basis_.cols();
  for (size_t g = 0; g < setup_basis_.size(); ++g) {
    const Eigen::Index s = setup_basis_[g].rows();
    raw->middleRows(offset_[g], s) = (setup_basis_[g].transpose() * raw->middleRows(offset_[g], s)).eval();
    if (p > 0) raw->bottomRows(p).noalias() -= setup_error_[g].transpose() * raw->middleRows(offset_[g], s);
  }
  if (p > 0) raw->bottomRows(p) = (error_basis_.transpose() * raw->bottomRows(p)).eval();
}

Eigen::VectorXd Nuisance::OfPriors(const identify::Problem& problem, const std::vector<Eigen::VectorXd>& value) const {
  Eigen::MatrixXd pull = Eigen::MatrixXd::Zero(size_, 1);
  for (size_t g = 0; g < setup_basis_.size(); ++g) {
    for (Eigen::Index k = 0; k < setup_basis_[g].rows(); ++k)
      pull(offset_[g] + k, 0) =
          value[g][k] * identify::PriorPrecision(problem.groups[g].parameters[k], identify::Priors::kAll);
  }
  Finish(&pull);
  return pull.col(0);
}

Eigen::VectorXd Nuisance::Column(const std::vector<Series>& series, const Eigen::VectorXd& coefficients) const {
  const Eigen::Index p = error_basis_.cols();
  const Eigen::VectorXd by_errors = error_basis_ * coefficients.tail(p);
  Eigen::VectorXd column = columns_.rightCols(p) * by_errors;
  for (const Series& rows : series) {
    const Eigen::Index n = rows.end - rows.begin, s = setup_basis_[rows.group].rows();
    const Eigen::VectorXd by_setup = setup_basis_[rows.group] * (coefficients.segment(offset_[rows.group], s) -
                                                                 setup_error_[rows.group] * by_errors);
    column.segment(rows.begin, n) += SetupOf(rows.group, rows.begin, n) * by_setup;
  }
  return column;
}

}  // namespace axiscal::loop
