#include "core/loop/separation.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/identify/reduction.h"

namespace axiscal::loop {
namespace {

// Shares of a column's squares below this are rounding.
constexpr double kSeen = 1e-10;

// B with B' G B = 1 on the space that G sees; columns of unit norm before projection.
Eigen::MatrixXd InverseRoot(const Eigen::MatrixXd& gram) {
  if (gram.rows() == 0) return gram;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram);
  Eigen::VectorXd root(gram.rows());
  for (Eigen::Index i = 0; i < gram.rows(); ++i)
    root[i] = eigen.eigenvalues()[i] > kSeen ? 1.0 / std::sqrt(eigen.eigenvalues()[i]) : 0.0;
  return eigen.eigenvectors() * root.asDiagonal();
}

}  // namespace

Information InformationOf(const identify::Problem& problem, const identify::Point& point,
                          const std::vector<identify::Parameter>& parameters) {
  const identify::NormalEquations normal = identify::Assemble(problem, point, parameters);
  const identify::Reduced reduced = identify::Reduce(problem, point, normal, identify::Priors::kAll);
  return {reduced.information, reduced.column_norm.cwiseAbs2()};
}

Separation::Separation(const Information& information, const std::vector<Member>& members) : members_(members) {
  const Eigen::Index count = information.matrix.rows();
  scale_.resize(count);
  for (Eigen::Index i = 0; i < count; ++i)
    scale_[i] = information.norm2[i] > 0.0 ? 1.0 / std::sqrt(information.norm2[i]) : 0.0;
  projected_ = scale_.asDiagonal() * information.matrix * scale_.asDiagonal();
  std::vector<bool> is_member(count, false);
  for (size_t m = 0; m < members.size(); ++m) {
    for (const int column : AllColumns(static_cast<int>(m))) is_member[column] = true;
  }
  std::vector<int> others, all;
  for (int i = 0; i < count; ++i) {
    if (!is_member[i]) others.push_back(i);
    all.push_back(i);
  }
  const Eigen::MatrixXd onto = InverseRoot(Block(others, others)).transpose() * Block(others, all);
  projected_ -= onto.transpose() * onto;
  for (size_t m = 0; m < members.size(); ++m) {
    const Eigen::MatrixXd own = Block(members[m].columns, members[m].columns);
    const std::vector<int> columns = AllColumns(static_cast<int>(m));
    const Eigen::MatrixXd root = InverseRoot(own);
    const Eigen::Index rank = (root.colwise().squaredNorm().array() > 0.0).count();
    roots_.push_back({root, members[m].nonlinear.empty() ? root : InverseRoot(Block(columns, columns)),
                      own.diagonal().maxCoeff() > kSeen ? rank : 0});
  }
}

std::vector<int> Separation::AllColumns(int member) const {
  std::vector<int> columns = members_[member].columns;
  columns.insert(columns.end(), members_[member].nonlinear.begin(), members_[member].nonlinear.end());
  return columns;
}

Eigen::MatrixXd Separation::Block(const std::vector<int>& rows, const std::vector<int>& columns) const {
  Eigen::MatrixXd block(rows.size(), columns.size());
  for (size_t i = 0; i < rows.size(); ++i) {
    for (size_t j = 0; j < columns.size(); ++j) block(i, j) = projected_(rows[i], columns[j]);
  }
  return block;
}

double Separation::Correlation(int a, int b) const {
  const Eigen::Index rank = std::min(roots_[a].rank, roots_[b].rank);
  if (rank == 0) return 1.0;
  const Eigen::MatrixXd cross =
      roots_[a].amplitudes.transpose() * Block(members_[a].columns, members_[b].columns) * roots_[b].amplitudes;
  if (cross.rows() == 1 || cross.cols() == 1) return std::min(1.0, cross.norm());
  const Eigen::VectorXd values = Eigen::JacobiSVD<Eigen::MatrixXd>(cross).singularValues();
  return std::min(1.0, values[rank - 1]);
}

double Separation::ExpectedChi2(int truth, int rival) const {
  const std::vector<int>& own = members_[truth].columns;
  const std::vector<int> other = AllColumns(rival);
  Eigen::VectorXd amplitude = members_[truth].amplitude;
  for (size_t i = 0; i < own.size(); ++i) {
    if (scale_[own[i]] == 0.0) return 0.0;
    amplitude[i] /= scale_[own[i]];
  }
  const Eigen::VectorXd seen = roots_[rival].all.transpose() * (Block(other, own) * amplitude);
  return std::max(0.0, amplitude.dot(Block(own, own) * amplitude) - seen.squaredNorm());
}

Eigen::VectorXd Separation::FittedAmplitude(int truth, int rival) const {
  const std::vector<int>&own = members_[truth].columns, &other = members_[rival].columns;
  Eigen::VectorXd amplitude = members_[truth].amplitude;
  for (size_t i = 0; i < own.size(); ++i) {
    if (scale_[own[i]] == 0.0) return Eigen::VectorXd::Zero(other.size());
    amplitude[i] /= scale_[own[i]];
  }
  const Eigen::MatrixXd& root = roots_[rival].amplitudes;
  Eigen::VectorXd fitted = root * (root.transpose() * (Block(other, own) * amplitude));
  for (size_t i = 0; i < other.size(); ++i) fitted[i] *= scale_[other[i]];
  return fitted;
}

}  // namespace axiscal::loop
