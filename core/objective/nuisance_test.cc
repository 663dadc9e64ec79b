#include "core/objective/nuisance.h"

#include <gtest/gtest.h>

#include <Eigen/QR>

#include "core/objective/testing/made_rows.h"

namespace axiscal::objective {
namespace {

constexpr double kTolerance = 1e-8;  // rounding of sums of 600 products of size 1

// Products after projection are those of the residuals of dense least squares with the priors as further rows.
TEST(Nuisance, ProjectsAsDenseLeastSquaresWithThePriorsAsRowsDoes) {
  Rows rows = MakeRows(1);
  rows.common_precision << 4.0, 0.0, 100.0;
  for (int s = 0; s < kSessions; ++s) rows.own_precision[s][0] = 10.0 * (s + 1);
  const int q = kSessions + 3;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(kRows + q, q);
  for (int s = 0; s < kSessions; ++s) {
    dense.block(s * kSessionRows, s, kSessionRows, 1) = rows.own.middleRows(s * kSessionRows, kSessionRows);
    dense(kRows + s, s) = std::sqrt(rows.own_precision[s][0]);
  }
  dense.topRightCorner(kRows, 3) = rows.common;
  for (int k = 0; k < 3; ++k) dense(kRows + kSessions + k, kSessions + k) = std::sqrt(rows.common_precision[k]);
  std::mt19937 random(2);
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(kRows + q, 2);
  columns.topRows(kRows) = Gaussian(kRows, 2, &random);
  columns.topRows(kRows).col(0) += 5.0 * rows.common.col(2);
  const Eigen::MatrixXd left = columns - dense * dense.colPivHouseholderQr().solve(columns);

  const Nuisance nuisance(rows);
  EXPECT_EQ(nuisance.size(), q);
  Eigen::MatrixXd coefficients(q, 2);
  for (int c = 0; c < 2; ++c) coefficients.col(c) = nuisance.CoefficientsOf(columns.col(c).head(kRows));
  const Eigen::MatrixXd products = columns.transpose() * columns - coefficients.transpose() * coefficients;
  EXPECT_LT((products - left.transpose() * left).cwiseAbs().maxCoeff(), kTolerance);
  for (int c = 0; c < 2; ++c) {
    const Eigen::VectorXd at_rows = columns.col(c).head(kRows) - nuisance.Explained(coefficients.col(c));
    EXPECT_LT((at_rows - left.col(c).head(kRows)).cwiseAbs().maxCoeff(), kTolerance);
  }
}

// A prior whose mean is not where the problem was linearised pulls.
TEST(Nuisance, PriorsPullTowardsTheirMeans) {
  Rows rows = MakeRows(3);
  rows.common.resize(kRows, 0);
  rows.common_precision.resize(0);
  constexpr double kPrecision = 50.0, kValue = 0.4;
  rows.own_precision[2][0] = kPrecision;
  rows.own_value[2][0] = kValue;
  const Nuisance nuisance(rows);
  // The minimum over d of |y - d|^2 + precision (value - d)^2 in one session: y and the value as seen from the point.
  const auto y = rows.y.segment(2 * kSessionRows, kSessionRows);
  const double best = (y.sum() + kPrecision * kValue) / (kSessionRows + kPrecision);
  const double squares = (y.array() - best).square().sum() + kPrecision * (kValue - best) * (kValue - best);
  double others = 0.0;
  for (const int s : {0, 1, 3}) {
    const auto its = rows.y.segment(s * kSessionRows, kSessionRows);
    others += its.squaredNorm() - its.sum() * its.sum() / (kSessionRows + rows.own_precision[s][0]);
  }
  const Eigen::VectorXd of_y = nuisance.CoefficientsOf(rows.y) + nuisance.OfPriors();
  EXPECT_NEAR(rows.y.squaredNorm() + nuisance.PriorSquares() - of_y.squaredNorm(), squares + others, kTolerance);
}

TEST(Whitening, TheAdjointGivesTheProductsOfWhitenedColumns) {
  for (const double echo : {0.0, 0.3}) {
    const Rows rows = MakeRows(4, 0.6, echo);
    std::mt19937 random(5);
    const Eigen::MatrixXd raw = Gaussian(kRows, 3, &random), v = Gaussian(kRows, 2, &random);
    Eigen::MatrixXd whitened = raw;
    rows.whitening.Apply(0, whitened);
    EXPECT_LT((whitened.transpose() * v - raw.transpose() * rows.whitening.Adjoint(v)).cwiseAbs().maxCoeff(),
              kTolerance);
    // One series alone is whitened as it is among all.
    Eigen::MatrixXd one = raw.middleRows(kSessionRows, kSessionRows);
    rows.whitening.Apply(kSessionRows, one);
    EXPECT_LT((one - whitened.middleRows(kSessionRows, kSessionRows)).cwiseAbs().maxCoeff(), kTolerance);
  }
}

}  // namespace
}  // namespace axiscal::objective
