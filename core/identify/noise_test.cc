#include "core/identify/noise.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

#include "core/identify/whitening.h"

namespace axiscal::identify {
namespace {

// Noise of unit standard deviation on a slow wave that a lacking effect would leave.
Eigen::VectorXd Series(double phi, double wave, double white_share = 0.0) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  Eigen::VectorXd series(2000);
  double ripple = normal(random);
  for (int k = 0; k < series.size(); ++k) {
    series[k] = std::sqrt(1 - white_share) * ripple + wave * std::sin(0.01 * k);
    if (white_share > 0.0) series[k] += std::sqrt(white_share) * normal(random);
    ripple = phi * ripple + std::sqrt(1 - phi * phi) * normal(random);
  }
  return series;
}

Noise FitOf(const Eigen::VectorXd& series) {
  Variogram variogram;
  variogram.Add(series, std::vector<bool>(series.size(), true), 1.0);
  return variogram.Fit();
}

TEST(Noise, SigmaAndCorrelationComeOutBesideAnEffectThatIsLacking) {
  for (const double wave : {0.0, 5.0}) {
    const Noise noise = FitOf(Series(0.6, wave));
    EXPECT_NEAR(noise.sigma_mm, 1.0, 0.1) << wave;  // 2000 correlated readings: 0.03 per standard deviation
    EXPECT_NEAR(noise.ar1, 0.6, 0.07) << wave;
  }
}

TEST(Noise, WhiteNoiseHasNoCorrelation) {
  const Noise noise = FitOf(Series(0.0, 3.0));
  EXPECT_EQ(noise.ar1, 0.0);
  EXPECT_NEAR(noise.sigma_mm, 1.0, 0.06);
}

// Instrument noise on top of what the servo remembers: neither alone has such a variogram.
TEST(Noise, AWhiteShareComesOutBesideAnEffectThatIsLacking) {
  for (const double wave : {0.0, 3.0}) {
    Variogram variogram;
    const Eigen::VectorXd series = Series(0.8, wave, 0.5);
    variogram.Add(series, std::vector<bool>(series.size(), true), 1.0);
    const Noise noise = variogram.Fit();
    EXPECT_NEAR(noise.sigma_mm, 1.0, 0.12) << wave;
    EXPECT_NEAR(noise.ar1, 0.8, 0.12) << wave;
    EXPECT_NEAR(noise.white_share, 0.5, 0.2) << wave;
    EXPECT_NEAR(LongRunShare(noise), 5.0, 1.7) << wave;
  }
}

TEST(Noise, NoWhiteShareWhereOneKindOfNoiseIsEnough) {
  for (const double phi : {0.0, 0.4, 0.6, 0.8}) {
    for (const double wave : {0.0, 3.0}) EXPECT_EQ(FitOf(Series(phi, wave)).white_share, 0.0) << phi << " " << wave;
  }
}

// Covariance of readings at `times`, the slow and obvious way.
Eigen::MatrixXd Covariance(const Noise& noise, const std::vector<int>& times) {
  const auto n = static_cast<Eigen::Index>(times.size());
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < n; ++k) {
      covariance(i, k) = noise.sigma_mm * noise.sigma_mm *
                         ((i == k ? noise.white_share : 0.0) +
                          (1.0 - noise.white_share) * std::pow(noise.ar1, std::abs(times[i] - times[k])));
    }
  }
  return covariance;
}

TEST(Whitening, WhitenedRowsHaveUnitVarianceAndNoCorrelation) {
  const std::vector<int> times = {0, 1, 2, 3, 5, 6, 9, 10, 11, 12};  // some set aside
  const auto n = static_cast<Eigen::Index>(times.size());
  for (const Noise& noise : {Noise{2.0, 0.0, 0.0}, Noise{0.5, 0.6, 0.0}, Noise{1.5, 0.8, 0.5}, Noise{1.0, 0.9, 0.2}}) {
    Eigen::MatrixXd whitening = Eigen::MatrixXd::Identity(n, n);
    SeriesWhitener whitener(noise, n);
    for (Eigen::Index k = 0; k < n; ++k) whitener.Apply(times[k], whitening.row(k));
    const Eigen::MatrixXd white = whitening * Covariance(noise, times) * whitening.transpose();
    EXPECT_LT((white - Eigen::MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff(), 1e-12) << noise.ar1;
  }
}

TEST(Whitening, WhatIsNewInAReadingSettles) {
  const Noise noise{1.0, 0.8, 0.5};
  SeriesWhitener whitener(noise, 1);
  double weight = 0.0;
  for (int k = 0; k < 100; ++k) weight = whitener.Next(k).weight;
  EXPECT_NEAR(InnovationShare(noise), 1.0 / (weight * weight), 1e-12);
  EXPECT_DOUBLE_EQ(InnovationShare({1.0, 0.6, 0.0}), 1.0 - 0.6 * 0.6);
}

TEST(Noise, TheBoundIsNowhereBelowTheNoiseNorAboveItByMoreThanItSays) {
  std::vector<int> times(200);
  for (int k = 0; k < 200; ++k) times[k] = k;
  for (const Noise& noise : {Noise{1.5, 0.8, 0.5}, Noise{1.0, 0.95, 0.2}, Noise{1.0, 0.4, 0.9}}) {
    const Ar1Bound bound = BoundingAr1(noise);
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> ratio(Covariance(bound.noise, times),
                                                                          Covariance(noise, times));
    EXPECT_GT(ratio.eigenvalues().minCoeff(), 1.0 - 1e-9);
    EXPECT_LT(ratio.eigenvalues().minCoeff(), 1.05);  // tight somewhere
    EXPECT_LT(ratio.eigenvalues().maxCoeff(), 1.001 * bound.excess);
  }
}

TEST(Noise, SeriesPool) {
  Variogram together;
  for (int part = 0; part < 4; ++part)
    together.Add(Series(0.6, 0.0).segment(500 * part, 500), std::vector<bool>(500, true), 1.0);
  EXPECT_NEAR(together.Fit().ar1, FitOf(Series(0.6, 0.0)).ar1, 0.03);
  EXPECT_EQ(together.differences(), 4 * 499);
}

TEST(Noise, AReadingSetAsideTakesItsDifferencesAlong) {
  Eigen::VectorXd series = Series(0.0, 0.0);
  std::vector<bool> is_used(series.size(), true);
  for (int k = 50; k < series.size(); k += 100) {
    series[k] = 100.0;
    is_used[k] = false;
  }
  Variogram variogram;
  variogram.Add(series, is_used, 1.0);
  EXPECT_NEAR(variogram.Fit().sigma_mm, 1.0, 0.06);
}

}  // namespace
}  // namespace axiscal::identify
