// Scores against densities of the normal distribution written out.
#include "core/drift/step_score.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace axiscal::drift {
namespace {

double LogDensity(const Eigen::VectorXd& off, const Eigen::MatrixXd& covariance) {
  return -0.5 * (off.dot(covariance.inverse() * off) + std::log(covariance.determinant()) +
                 static_cast<double>(off.size()) * std::log(2.0 * std::numbers::pi));
}

struct Case {
  Eigen::MatrixXd covariance{{1.0, 0.6, 0.1}, {0.6, 1.5, -0.3}, {0.1, -0.3, 0.7}};
  Eigen::VectorXd off = Eigen::Vector3d(4.0, 0.3, -3.5);
  Evidence evidence() const {
    const Eigen::MatrixXd information = covariance.inverse();
    return {information, information * off, 3};
  }
  double Written(const std::vector<int>& errors) const {
    Eigen::MatrixXd shifted = covariance;
    for (const int j : errors) shifted(j, j) += kShiftVariance;
    return LogDensity(off, shifted) - LogDensity(off, covariance) - static_cast<double>(errors.size()) * std::log(3.0);
  }
};

TEST(StepScore, IsTheLogBayesFactorOfTheSet) {
  const Case one;
  for (const std::vector<int>& errors : {std::vector<int>{0}, {2}, {1, 2}, {2, 0}, {0, 1, 2}})
    EXPECT_NEAR(ScoreOf(one.evidence(), errors), one.Written(errors), 1e-10);
  EXPECT_EQ(ScoreOf(one.evidence(), {}), 0.0);
}

TEST(StepScore, ForwardSelectionTakesTheBestErrorEachTime) {
  const Case one;
  const Shift shift = ChooseShift(one.evidence());
  int best = 0;
  for (int j = 1; j < 3; ++j) {
    if (one.Written({j}) > one.Written({best})) best = j;
  }
  ASSERT_FALSE(shift.errors.empty());
  EXPECT_EQ(shift.errors[0], best);
  EXPECT_NEAR(shift.score, one.Written(shift.errors), 1e-10);
  for (int j = 0; j < 3; ++j) {  // no other one would raise it
    std::vector<int> more = shift.errors;
    if (std::find(more.begin(), more.end(), j) != more.end()) continue;
    more.push_back(j);
    EXPECT_LE(one.Written(more), shift.score);
  }
  EXPECT_EQ(shift.errors.size(), 2u);  // 0 and 2 moved
}

TEST(StepScore, SizesAreGeneralisedLeastSquares) {
  const Case one;
  Eigen::MatrixXd design = Eigen::MatrixXd::Zero(3, 2);  // columns: errors 2 and 0
  design(2, 0) = design(0, 1) = 1.0;
  const Eigen::MatrixXd weight = one.covariance.inverse();
  const Eigen::MatrixXd covariance = (design.transpose() * weight * design).inverse();
  const ShiftSize size = SizeOf(one.evidence(), {2, 0});
  EXPECT_LT((size.covariance - covariance).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((size.size - covariance * design.transpose() * weight * one.off).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(StepScore, WhatNothingIsKnownOfIsNotChosen) {
  Case one;
  Evidence evidence = one.evidence();
  evidence.information.row(0).setZero();
  evidence.information.col(0).setZero();
  evidence.score(0) = 0.0;
  const Shift shift = ChooseShift(evidence);
  EXPECT_EQ(std::count(shift.errors.begin(), shift.errors.end(), 0), 0);
  EXPECT_EQ(ScoreOf(evidence, {0}), 0.0);
}

}  // namespace
}  // namespace axiscal::drift
