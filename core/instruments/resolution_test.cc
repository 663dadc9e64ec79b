#include "core/instruments/resolution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace axiscal::instruments {
namespace {

// A slow wave with Gaussian noise of `sigma_mm`, rounded to `step_mm`, 0: not rounded.
MeasuringRun Waving(double step_mm, double offset_mm = 0.0, double sigma_mm = 3e-4) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  MeasuringRun run;
  run.sigma_mm = 3e-4;
  run.measured_mm.resize(1, 700);
  for (int k = 0; k < 700; ++k) {
    const double reading_mm = 0.02 * std::sin(0.01 * k) + sigma_mm * normal(random);
    run.measured_mm(0, k) = offset_mm + (step_mm > 0.0 ? step_mm * std::round(reading_mm / step_mm) : reading_mm);
  }
  return run;
}

TEST(Resolution, IsTheStepOfTheDisplay) {
  for (const double step_mm : {1e-4, 5e-4, 1e-3, 2.54e-3}) {
    for (const double offset_mm : {0.0, 0.0179, 1234.5678})
      EXPECT_NEAR(ResolutionOf(Waving(step_mm, offset_mm), 0), step_mm, 1e-9 * step_mm + 1e-11 * offset_mm);
  }
}

TEST(Resolution, IsNotKnownOfExactReadingsNorOfAHandful) {
  EXPECT_EQ(ResolutionOf(Waving(0.0), 0), 0.0);
  MeasuringRun few = Waving(1e-3);
  few.measured_mm.conservativeResize(1, 9);
  EXPECT_EQ(ResolutionOf(few, 0), 0.0);
}

TEST(Resolution, OfTwoValuesThatComeOftenIsTheirDifference) {
  MeasuringRun alike = Waving(1e-3);
  alike.measured_mm = alike.measured_mm.unaryExpr([](double mm) { return mm > 0.0 ? 0.01 : 0.0; });
  EXPECT_NEAR(ResolutionOf(alike, 0), 0.01, 1e-12);
}

TEST(Resolution, OfMoreThanTwoSigmaIsCoarse) {
  EXPECT_EQ(CoarseResolutionOf(Waving(5e-4)), 0.0);
  EXPECT_EQ(SigmaWithRounding(Waving(5e-4)), 3e-4);
  EXPECT_NEAR(CoarseResolutionOf(Waving(1e-3)), 1e-3, 1e-12);
  EXPECT_NEAR(SigmaWithRounding(Waving(1e-3)), std::hypot(3e-4, 1e-3 / std::sqrt(12.0)), 1e-12);
}

}  // namespace
}  // namespace axiscal::instruments
