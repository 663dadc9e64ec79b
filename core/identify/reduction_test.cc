#include "core/identify/reduction.h"

#include <gtest/gtest.h>

namespace axiscal::identify {
namespace {

Reduced FromJacobian(const Eigen::MatrixXd& jacobian) {
  return {jacobian.transpose() * jacobian, Eigen::VectorXd::Zero(jacobian.cols()),
          jacobian.colwise().norm().transpose()};
}

TEST(NullSpace, TwoEqualColumnsAreOneDirectionAndTheLastIsHeld) {
  Eigen::MatrixXd jacobian(4, 3);
  jacobian << 1, 2, 2, 0, 1, 1, 3, -1, -1, 1, 1, 1;
  const NullSpace space = FindNullSpace(FromJacobian(jacobian));
  EXPECT_EQ(space.rank, 2);
  ASSERT_EQ(space.fixed, std::vector<int>{2});
  EXPECT_NEAR(space.directions(0, 1), -1.0, 1e-9);
  EXPECT_EQ(space.directions(0, 0), 0.0);
  EXPECT_EQ(space.involved, (std::vector<bool>{false, true, true}));
}

TEST(NullSpace, ScalesOfUnitsDoNotMatter) {
  Eigen::MatrixXd jacobian(4, 3);
  jacobian << 1, 2, 2e6, 0, 1, 1e6, 3, -1, -1e6, 1, 1, 1e6;
  const NullSpace space = FindNullSpace(FromJacobian(jacobian));
  EXPECT_EQ(space.rank, 2);
  EXPECT_NEAR(space.directions(0, 1) / space.directions(0, 2), -1e6, 1.0);
}

TEST(NullSpace, AnErrorWithoutAnyEffectIsADirectionOfItsOwn) {
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Identity(3, 3);
  jacobian.col(1).setZero();
  const NullSpace space = FindNullSpace(FromJacobian(jacobian));
  EXPECT_EQ(space.rank, 2);
  EXPECT_EQ(space.fixed, std::vector<int>{1});
  EXPECT_EQ(space.involved, (std::vector<bool>{false, true, false}));
}

TEST(NullSpace, PoorIsNotNothing) {
  Eigen::MatrixXd jacobian(2, 2);
  jacobian << 1, 1, 0, 1e-3;
  const NullSpace space = FindNullSpace(FromJacobian(jacobian));
  EXPECT_EQ(space.rank, 2);
  EXPECT_GT(space.condition, 1e3);
}

}  // namespace
}  // namespace axiscal::identify
