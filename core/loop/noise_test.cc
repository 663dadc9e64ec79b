#include "core/loop/noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace axiscal::loop {
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

const std::vector<bool> kAll(2000, true);

TEST(Noise, SigmaAndCorrelationComeOutBesideAnEffectThatIsLacking) {
  for (const double wave : {0.0, 5.0}) {
    const identify::Noise noise = NoiseFromDifferences(Series(0.6, wave), kAll);
    EXPECT_NEAR(noise.sigma_mm, 1.0, 0.12) << wave;  // 2000 correlated readings: 0.04 per standard deviation
    EXPECT_NEAR(noise.ar1, 0.6, 0.1) << wave;
  }
}

TEST(Noise, WhiteNoiseHasNoCorrelation) {
  const identify::Noise noise = NoiseFromDifferences(Series(0.0, 3.0), kAll);
  EXPECT_EQ(noise.ar1, 0.0);
  EXPECT_NEAR(noise.sigma_mm, 1.0, 0.06);
}

TEST(Noise, AShortSeriesSaysNothing) {
  EXPECT_EQ(NoiseFromDifferences(Series(0.0, 0.0).head(30), std::vector<bool>(30, true)).sigma_mm, 0.0);
}

}  // namespace
}  // namespace axiscal::loop
