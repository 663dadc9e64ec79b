#include "core/identify/reduction.h"

#include <gtest/gtest.h>

#include <cmath>

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

// Two offsets, of which readings tell the first to a tenth of its prior and the second not at all, leave log(1 + 10^2);
// one without a prior takes from it what it explains itself, and one that is held counts nothing.
TEST(Reduction, LeaningOnSetupsIsWhatReadingsRuleOut) {
  Problem problem;
  problem.groups.push_back({{{"a", 5.0}, {"b", 2.0}}, {0}});
  NormalEquations normal;
  normal.groups.push_back({Eigen::MatrixXd::Zero(4, 4), 2});
  normal.groups[0].gram(0, 0) = 4.0;  // (10 / 5)^2
  normal.groups[0].gram(2, 2) = 7.0;  // of an error
  EXPECT_NEAR(LeaningOnSetups(problem, normal), std::log(101.0), 1e-12);
  problem.groups[0].parameters[1].prior_sigma = INFINITY;
  normal.groups[0].gram(1, 1) = 1.0;
  normal.groups[0].gram(0, 1) = normal.groups[0].gram(1, 0) = std::sqrt(3.0);  // explains three quarters
  EXPECT_NEAR(LeaningOnSetups(problem, normal), std::log(26.0), 1e-9);
  problem.groups[0].parameters[0].held = 0.0;
  EXPECT_EQ(LeaningOnSetups(problem, normal), 0.0);
}

}  // namespace
}  // namespace axiscal::identify
