#include "core/identify/noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace axiscal::identify {
namespace {

// AR(1) noise of unit standard deviation on a slow wave that a lacking effect would leave.
Eigen::VectorXd Series(double phi, double wave) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  Eigen::VectorXd series(2000);
  double ripple = normal(random);
  for (int k = 0; k < series.size(); ++k) {
    series[k] = ripple + wave * std::sin(0.01 * k);
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
