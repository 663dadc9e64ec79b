// The filter against generalised least squares over all levels at once.
#include "core/drift/joint_filter.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "core/base/random.h"

namespace axiscal::drift {
namespace {

constexpr int kErrors = 2, kTimes = 6;
constexpr double kStartVariance = 30.0, kSeasonVariance = 0.25, kRate = 0.4;

struct Measured {
  Regressors at;
  std::vector<int> seen;
  Eigen::VectorXd y;
  Eigen::MatrixXd noise;
  double weeks = 0.0;  // since the one before
};

std::vector<Measured> Draw() {
  base::Random random(3);
  std::vector<Measured> all;
  for (int k = 0; k < kTimes; ++k) {
    Measured one;
    one.at = {1.0, std::sin(0.7 * k), std::cos(0.7 * k), k % 2 == 0 ? 0.4 * k : 0.0};
    one.seen = k == 2 ? std::vector<int>{1} : std::vector<int>{0, 1};
    one.y = Eigen::Vector2d(random.Normal() + 3.0, random.Normal() - 2.0);
    one.noise = Eigen::Matrix2d{{1.0 + 0.1 * k, 0.3}, {0.3, 0.8}};
    one.weeks = k == 0 ? 0.0 : 1.0 + k % 3;
    all.push_back(one);
  }
  return all;
}

TEST(JointFilter, IsGeneralisedLeastSquares) {
  const std::vector<Measured> all = Draw();
  Joint joint;
  joint.mean = Eigen::VectorXd::Zero(kParts * kErrors);
  joint.covariance = kSeasonVariance * Eigen::MatrixXd::Identity(kParts * kErrors, kParts * kErrors);
  joint.covariance.diagonal().head(kErrors).setConstant(kStartVariance);
  for (const Measured& one : all) {
    Loosen(Eigen::VectorXd::Constant(kErrors, kRate * one.weeks), &joint);
    Update(one.at, one.y, one.noise, one.seen, &joint);
  }

  // Unknowns: the levels at every time, then sine, cosine and temperature. Rows: priors, walks, measurements.
  const int levels = kErrors * kTimes, unknowns = levels + 3 * kErrors;
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns);
  for (int j = 0; j < kErrors; ++j) {
    information(j, j) += 1.0 / kStartVariance;
    for (int part = 0; part < 3; ++part) {
      const int at = levels + part * kErrors + j;
      information(at, at) += 1.0 / kSeasonVariance;
    }
    for (int k = 1; k < kTimes; ++k) {
      const int now = k * kErrors + j, before = now - kErrors;
      const double weight = 1.0 / (kRate * all[k].weeks);
      information(now, now) += weight;
      information(before, before) += weight;
      information(now, before) -= weight;
      information(before, now) -= weight;
    }
  }
  for (int k = 0; k < kTimes; ++k) {
    const Measured& one = all[k];
    const Eigen::MatrixXd weight = Eigen::MatrixXd(one.noise(one.seen, one.seen)).inverse();
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(static_cast<long>(one.seen.size()), unknowns);
    for (size_t i = 0; i < one.seen.size(); ++i) {
      const auto row = static_cast<long>(i);
      rows(row, k * kErrors + one.seen[i]) = 1.0;
      for (int part = 0; part < 3; ++part) rows(row, levels + part * kErrors + one.seen[i]) = one.at[part + 1];
    }
    information += rows.transpose() * weight * rows;
    right += rows.transpose() * weight * one.y(one.seen);
  }
  const Eigen::MatrixXd covariance = information.inverse();
  const Eigen::VectorXd mean = covariance * right;
  const int last = kErrors * (kTimes - 1);
  EXPECT_LT((joint.mean - mean.tail(kParts * kErrors)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((joint.covariance - covariance.bottomRightCorner(kParts * kErrors, kParts * kErrors)).cwiseAbs().maxCoeff(),
            1e-9);
  EXPECT_EQ(last + kParts * kErrors, unknowns);  // so the tail is the last levels and the seasons
}

TEST(JointFilter, WhatIsNotSeenTellsNothing) {
  Eigen::MatrixXd matrix(3, 3);
  matrix << 2.0, 0.5, 9.0, 0.5, 1.0, 9.0, 9.0, 9.0, 1.0;
  const Eigen::MatrixXd inverse = InverseOf(matrix, {0, 1});
  EXPECT_EQ(inverse.row(2).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ(inverse.col(2).cwiseAbs().maxCoeff(), 0.0);
  const Eigen::Matrix2d product = inverse.topLeftCorner(2, 2) * matrix.topLeftCorner(2, 2);
  EXPECT_LT((product - Eigen::Matrix2d::Identity()).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(JointFilter, TheYearComesRoundAndUnknownTemperaturesCountNothing) {
  const base::UtcTime start = base::FromUtcUs(1'600'000'000'000'000);
  const Regressors now = RegressorsAt(start, std::nullopt), cold = RegressorsAt(start, 17.0);
  const Regressors later = RegressorsAt(start + std::chrono::microseconds(31'556'952'000'000), std::nullopt);
  EXPECT_NEAR(now[1], later[1], 1e-9);
  EXPECT_NEAR(now[2], later[2], 1e-9);
  EXPECT_NEAR(now[1] * now[1] + now[2] * now[2], 1.0, 1e-12);
  EXPECT_EQ(now[3], 0.0);
  EXPECT_DOUBLE_EQ(cold[3], -1.0);
}

}  // namespace
}  // namespace axiscal::drift
