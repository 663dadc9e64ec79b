#include "core/information/information.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

namespace axiscal::information {
namespace {

TEST(Information, IndependentRowsAddUp) {
  Eigen::MatrixXd first(2, 3), second(3, 3), both(5, 3);
  first << 1, 2, 0, 0, 1, -1;
  second << 3, -1, 2, 1, 0, 4, 0.5, 1, 1;
  both << first, second;
  Information sum = OfRows(first);
  sum += OfRows(second);
  const Information together = OfRows(both);
  EXPECT_LT((sum.matrix - together.matrix).norm(), 1e-13);
  EXPECT_LT((sum.norm2 - together.norm2).norm(), 1e-13);
  EXPECT_NEAR(together.norm2[1], 4.0 + 1.0 + 1.0 + 0.0 + 1.0, 1e-13);
}

// In units that differ by nine decades (mm beside rad of a short lever).
TEST(Information, CovarianceIsTheInverseOfWhatIsFree) {
  const Eigen::Vector3d unit(1.0, 1e9, 1e-3);
  Eigen::MatrixXd rows(4, 3);
  rows << 1, 2, 0.5, 0, 1, -1, 3, -1, 2, 1, 1, 1;
  const Eigen::MatrixXd gram = rows.transpose() * rows;
  const Information scaled = OfRows(rows * unit.asDiagonal());
  const Eigen::MatrixXd covariance = unit.asDiagonal() * CovarianceOf(scaled, {0, 1, 2}) * unit.asDiagonal();
  EXPECT_LT((covariance * gram - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  const std::vector<int> two = {2, 0};
  const Eigen::Matrix2d held = CovarianceOf(scaled, two);
  const Eigen::Matrix2d expected = Eigen::Matrix2d(gram(two, two)).inverse();
  EXPECT_NEAR(held(0, 0) * 1e-6, expected(0, 0), 1e-13);
  EXPECT_NEAR(held(0, 1) * 1e-3, expected(0, 1), 1e-13);
}

}  // namespace
}  // namespace axiscal::information
