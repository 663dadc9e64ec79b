#include "core/information/null_space.h"

#include <gtest/gtest.h>

#include <cmath>

namespace axiscal::information {
namespace {

TEST(NullSpace, TwoEqualColumnsAreOneDirectionAndTheLastIsHeld) {
  Eigen::MatrixXd jacobian(4, 3);
  jacobian << 1, 2, 2, 0, 1, 1, 3, -1, -1, 1, 1, 1;
  const NullSpace space = FindNullSpace(OfRows(jacobian));
  EXPECT_EQ(space.rank, 2);
  ASSERT_EQ(space.fixed, std::vector<int>{2});
  EXPECT_NEAR(space.directions(0, 1), -1.0, 1e-9);
  EXPECT_EQ(space.directions(0, 0), 0.0);
  EXPECT_EQ(space.involved, (std::vector<bool>{false, true, true}));
}

TEST(NullSpace, ScalesOfUnitsDoNotMatter) {
  Eigen::MatrixXd jacobian(4, 3);
  jacobian << 1, 2, 2e6, 0, 1, 1e6, 3, -1, -1e6, 1, 1, 1e6;
  const NullSpace space = FindNullSpace(OfRows(jacobian));
  EXPECT_EQ(space.rank, 2);
  EXPECT_NEAR(space.directions(0, 1) / space.directions(0, 2), -1e6, 1.0);
}

TEST(NullSpace, AnErrorWithoutAnyEffectIsADirectionOfItsOwn) {
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Identity(3, 3);
  jacobian.col(1).setZero();
  const NullSpace space = FindNullSpace(OfRows(jacobian));
  EXPECT_EQ(space.rank, 2);
  EXPECT_EQ(space.fixed, std::vector<int>{1});
  EXPECT_EQ(space.involved, (std::vector<bool>{false, true, false}));
}

// Three errors of which only one sum is seen: two directions, whose basis is a matter of rounding. Names are not.
TEST(NullSpace, WhichErrorsAreHeldDoesNotDependOnRounding) {
  for (int seed = 0; seed < 20; ++seed) {
    Eigen::MatrixXd jacobian = Eigen::VectorXd::Ones(4) * Eigen::RowVector3d(1, -1, 1);
    jacobian += 1e-13 * Eigen::MatrixXd::NullaryExpr(
                            4, 3, [&](int row, int column) { return std::sin(7.0 * seed + 3.0 * row + column); });
    const NullSpace space = FindNullSpace(OfRows(jacobian));
    ASSERT_EQ(space.fixed, (std::vector<int>{2, 1}));
    EXPECT_NEAR(space.directions(0, 0), -1.0, 1e-9);
    EXPECT_NEAR(space.directions(1, 0), 1.0, 1e-9);
  }
}

TEST(NullSpace, AnEffectOfRoundingIsNoEffect) {
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Identity(3, 3);
  jacobian.col(1) *= 1e-13;
  const NullSpace space = FindNullSpace(OfRows(jacobian));
  EXPECT_EQ(space.rank, 2);
  EXPECT_EQ(space.fixed, std::vector<int>{1});
}

TEST(NullSpace, PoorIsNotNothing) {
  Eigen::MatrixXd jacobian(2, 2);
  jacobian << 1, 1, 0, 1e-3;
  const NullSpace space = FindNullSpace(OfRows(jacobian));
  EXPECT_EQ(space.rank, 2);
  EXPECT_GT(space.condition, 1e3);
}

}  // namespace
}  // namespace axiscal::information
