#include "core/identify/reduction.h"

#include <gtest/gtest.h>

namespace axiscal::identify {
namespace {

Reduced FromJacobian(const Eigen::MatrixXd& jacobian) {
  return {jacobian.transpose() * jacobian, Eigen::VectorXd::Zero(jacobian.cols()),
          jacobian.colwise().norm().transpose()};
}

// An error that another one can take the place of shows only by what the other leaves of it.
TEST(Reduction, InformationBesideIsWhatTheOthersLeave) {
  Eigen::MatrixXd jacobian(3, 3);
  jacobian << 1, 1, 0, 0, 0.5, 0, 0, 0, 2;
  const Reduced reduced = FromJacobian(jacobian);
  EXPECT_NEAR(InformationBeside(reduced, {1})(0, 0), 0.25, 1e-9);
  EXPECT_NEAR(InformationBeside(reduced, {2})(0, 0), 4.0, 1e-9);
  const Eigen::MatrixXd inverse = InverseBeside(reduced, {0});
  EXPECT_NEAR(inverse(1, 1), 1.0 / 1.25, 1e-9);
  EXPECT_EQ(inverse.row(0).norm(), 0.0);
}

}  // namespace
}  // namespace axiscal::identify
