#include "core/compensate/nodes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace axiscal::compensate {
namespace {

Curve CurveOf(double (*function)(double), double from, double to, int samples) {
  Curve curve;
  curve.values.resize(1);
  for (int i = 0; i <= samples; ++i) {
    curve.position.push_back(from + (to - from) * i / samples);
    curve.values[0].push_back(function(curve.position.back()));
  }
  return curve;
}

std::vector<double> PositionsOf(const Curve& curve, const std::vector<size_t>& indices) {
  std::vector<double> positions;
  for (const size_t i : indices) positions.push_back(curve.position[i]);
  return positions;
}

TEST(Nodes, AStraightLineNeedsTwo) {
  const Curve line = CurveOf([](double q) { return 3.0 * q - 40.0; }, -100, 250, 1000);
  EXPECT_EQ(FreeNodes(line, 1e-6, 256).size(), 2u);
}

TEST(Nodes, AKinkGetsANode) {
  const Curve kink = CurveOf([](double q) { return std::abs(q); }, -100, 300, 1000);
  const std::vector<size_t> nodes = FreeNodes(kink, 0.01, 256);
  ASSERT_EQ(nodes.size(), 3u);
  EXPECT_NEAR(kink.position[nodes[1]], 0.0, 0.4);
}

// A chord over h of a parabola a q^2 departs by a h^2 / 4.
TEST(Nodes, AParabolaNeedsWhatTheChordSays) {
  const Curve parabola = CurveOf([](double q) { return q * q; }, 0, 10, 20000);
  const double tolerance = 0.25;  // pieces of 1
  const std::vector<size_t> nodes = FreeNodes(parabola, tolerance, 256);
  EXPECT_GE(nodes.size(), 11u);
  EXPECT_LE(nodes.size(), 12u);  // samples are 0.0005 apart
}

TEST(Nodes, TheBestThatTheLimitAllows) {
  const Curve wave = CurveOf([](double q) { return 20.0 * std::cos(q); }, 0, 40 * 2 * M_PI, 20000);
  EXPECT_TRUE(FreeNodes(wave, 1.0, 100).empty());
  const std::vector<size_t> nodes = BestFreeNodes(wave, 160);  // four per period
  EXPECT_LE(nodes.size(), 160u);
  EXPECT_GE(nodes.size(), 80u);
  // Half of 20 (1 - cos 45 deg) where least squares share it, the whole where they do not.
  EXPECT_LT(LargestDeparture(wave, PositionsOf(wave, nodes)), 20.0 * (1 - std::sqrt(0.5)) * 1.2);
}

TEST(Nodes, LeastSquaresHalvesWhatAChordLeaves) {
  const Curve parabola = CurveOf([](double q) { return q * q; }, -1, 1, 2000);
  const std::vector<double> fitted = FitNodes(parabola.position, parabola.values[0], {-1, 0, 1});
  EXPECT_LT(LargestDeparture(parabola, {-1, 0, 1}), 0.75 * 0.25);
  EXPECT_NEAR(fitted[0], fitted[2], 1e-9);
}

}  // namespace
}  // namespace axiscal::compensate
