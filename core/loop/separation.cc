#include "core/loop/separation.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/base/demand.h"
#include "core/identify/reduction.h"

namespace axiscal::loop {
namespace {

// Shares of a column's squares below this are rounding.
constexpr double kSeen = 1e-10;

// B with B' G B = 1 on the space that G sees; columns of unit norm before projection.
Eigen::MatrixXd RootOfInverse(const Eigen::MatrixXd& gram) {
  if (gram.rows() == 0) return gram;
  const auto root_of = [](double value) { return value > kSeen ? 1.0 / std::sqrt(value) : 0.0; };
  if (gram.rows() == 1) return Eigen::MatrixXd::Constant(1, 1, root_of(gram(0, 0)));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram);
  Eigen::VectorXd root(gram.rows());
  for (Eigen::Index i = 0; i < gram.rows(); ++i) root[i] = root_of(eigen.eigenvalues()[i]);
  return eigen.eigenvectors() * root.asDiagonal();
}

}  // namespace

Information InformationOf(const identify::Problem& problem, const identify::Point& point,
                          const std::vector<identify::Parameter>& parameters) {
  const identify::NormalEquations normal = identify::Assemble(problem, point, parameters);
  const identify::Reduced reduced = identify::Reduce(problem, point, normal, identify::Priors::kAll);
  return identify::InformationOf(reduced);
}

Separation::Separation(const Information& information, const std::vector<Member>& members) : members_(members) {
  const Eigen::Index count = information.matrix.rows();
  scale_.resize(count);
  for (Eigen::Index i = 0; i < count; ++i)
    scale_[i] = information.norm2[i] > 0.0 ? 1.0 / std::sqrt(information.norm2[i]) : 0.0;
  projected_ = scale_.asDiagonal() * information.matrix * scale_.asDiagonal();
  std::vector<bool> is_member(count, false);
  for (const Member& member : members) {
    Root root;
    root.columns = member.columns;
    root.columns.insert(root.columns.end(), member.nonlinear.begin(), member.nonlinear.end());
    DEMAND(root.columns.size() <= kMostColumns);
    for (const int column : root.columns) is_member[column] = true;
    roots_.push_back(std::move(root));
  }
  std::vector<int> others;
  for (int i = 0; i < count; ++i) {
    if (!is_member[i]) others.push_back(i);
  }
  const Eigen::MatrixXd onto = RootOfInverse(projected_(others, others)).transpose() * projected_(others, Eigen::all);
  projected_ -= onto.transpose() * onto;
  for (size_t m = 0; m < members.size(); ++m) {
    const std::vector<int>& columns = members[m].columns;
    const Small own = SmallBlock(columns, columns);
    Root& root = roots_[m];
    root.amplitudes = RootOfInverse(own);
    root.all = root.amplitudes;
    if (!members[m].nonlinear.empty()) root.all = RootOfInverse(SmallBlock(root.columns, root.columns));
    if (own.diagonal().maxCoeff() > kSeen) root.rank = (root.amplitudes.colwise().squaredNorm().array() > 0.0).count();
    if (members[m].amplitude.size() == 0) continue;
    root.acts = true;
    root.response = Eigen::VectorXd::Zero(count);
    for (size_t i = 0; i < columns.size(); ++i) {
      if (scale_[columns[i]] == 0.0) {
        root.acts = false;
        break;
      }
      root.response += projected_.col(columns[i]) * (members[m].amplitude[i] / scale_[columns[i]]);
    }
    for (size_t i = 0; i < columns.size() && root.acts; ++i)
      root.squares += members[m].amplitude[i] / scale_[columns[i]] * root.response[columns[i]];
  }
}

Separation::Small Separation::SmallBlock(const std::vector<int>& rows, const std::vector<int>& columns) const {
  Small block(rows.size(), columns.size());
  for (size_t i = 0; i < rows.size(); ++i) {
    for (size_t j = 0; j < columns.size(); ++j) block(i, j) = projected_(rows[i], columns[j]);
  }
  return block;
}

double Separation::Correlation(int a, int b) const {
  const Eigen::Index rank = std::min(roots_[a].rank, roots_[b].rank);
  if (rank == 0) return 1.0;
  const Small cross =
      roots_[a].amplitudes.transpose() * SmallBlock(members_[a].columns, members_[b].columns) * roots_[b].amplitudes;
  if (cross.rows() == 1 || cross.cols() == 1) return std::min(1.0, cross.norm());
  return std::min(1.0, Eigen::JacobiSVD<Eigen::MatrixXd>(cross).singularValues()[rank - 1]);
}

double Separation::ExpectedChi2(int truth, int rival) const {
  const Root &own = roots_[truth], &other = roots_[rival];
  if (!own.acts) return 0.0;
  double seen = 0.0;
  for (Eigen::Index k = 0; k < other.all.cols(); ++k) {
    double along = 0.0;
    for (size_t i = 0; i < other.columns.size(); ++i) along += other.all(i, k) * own.response[other.columns[i]];
    seen += along * along;
  }
  return std::max(0.0, own.squares - seen);
}

Eigen::VectorXd Separation::FittedAmplitude(int truth, int rival) const {
  const std::vector<int>& other = members_[rival].columns;
  if (!roots_[truth].acts) return Eigen::VectorXd::Zero(static_cast<Eigen::Index>(other.size()));
  const Small& root = roots_[rival].amplitudes;
  Eigen::VectorXd fitted = root * (root.transpose() * roots_[truth].response(other));
  for (size_t i = 0; i < other.size(); ++i) fitted[i] *= scale_[other[i]];
  return fitted;
}

}  // namespace axiscal::loop
