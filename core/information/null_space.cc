#include "core/information/null_space.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>

namespace axiscal::information {
namespace {

// Which unknowns to hold so that no null direction is left: those with the largest share in the null space first, each
// time in what is left of it. Shares do not depend on how rounding turned the basis (orthonormal rows). Of equal
// candidates the last declared is held, so that the first carries the combination.
std::vector<int> HeldColumns(const Eigen::MatrixXd& basis) {
  constexpr double kTie = 0.99;
  Eigen::MatrixXd left = basis;
  std::vector<int> held;
  for (int step = 0; step < basis.rows(); ++step) {
    int best = -1;
    for (int column = static_cast<int>(left.cols()) - 1; column >= 0; --column) {
      if (best < 0 || left.col(column).norm() * kTie > left.col(best).norm()) best = column;
    }
    const Eigen::VectorXd direction = left.col(best).normalized();
    left -= direction * (direction.transpose() * left).eval();
    held.push_back(best);
  }
  return held;
}

}  // namespace

NullSpace FindNullSpace(const Information& information, double threshold) {
  const int p = static_cast<int>(information.norm2.size());
  NullSpace out;
  out.involved.assign(p, false);
  out.directions.resize(0, p);
  if (p == 0) return out;
  const Eigen::VectorXd column_norm = information.norm2.cwiseSqrt();
  Eigen::VectorXd scale(p);
  // An unknown whose whole effect is rounding (a turn about the line through the point) has none; scaled up it would
  // look like one.
  constexpr double kRounding = 1e-9;
  const double floor = kRounding * column_norm.maxCoeff();
  for (int i = 0; i < p; ++i)
    scale[i] = column_norm[i] > floor ? 1.0 / column_norm[i] : floor > 0.0 ? kRounding / floor : 1.0;
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information.matrix * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  int nullity = 0;
  while (nullity < p && eigen.eigenvalues()[nullity] < threshold * threshold) ++nullity;
  out.rank = p - nullity;
  if (out.rank > 0) out.condition = std::sqrt(eigen.eigenvalues()[p - 1] / eigen.eigenvalues()[nullity]);

  if (nullity == 0) return out;
  const Eigen::MatrixXd basis = eigen.eigenvectors().leftCols(nullity).transpose();
  out.fixed = HeldColumns(basis);
  Eigen::MatrixXd rows = basis(Eigen::all, out.fixed).colPivHouseholderQr().solve(basis);
  constexpr double kTakesPart = 1e-3;  // scaled share of a direction below which an unknown is only rounding in it
  for (int row = 0; row < nullity; ++row) {
    for (int column = 0; column < p; ++column) {
      if (std::abs(rows(row, column)) < kTakesPart) rows(row, column) = 0.0;
      if (rows(row, column) != 0.0) out.involved[column] = true;
    }
  }
  out.directions = rows * scale.asDiagonal();
  for (int row = 0; row < nullity; ++row)
    out.directions.row(row) /= Eigen::RowVectorXd(out.directions.row(row))[out.fixed[row]];
  return out;
}

}  // namespace axiscal::information
