#include "core/geometry/two_turns.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace axiscal::geometry {
namespace {

constexpr double kToleranceOfOne = 2.3e-16;  // a double's last place below 1, and what the polynomials leave

TEST(TwoTurns, AgreesWithTheLibraryToTheLastPlaceInEveryQuadrant) {
  std::mt19937_64 random(11);
  for (const double range_rad : {1e-9, 0.7, 3.2, 50.0, 9.9e4, 3e6}) {
    std::uniform_real_distribution<double> angle_rad(-range_rad, range_rad);
    for (int i = 0; i < 20000; ++i) {
      const double angles_rad[2] = {angle_rad(random), angle_rad(random)};
      const TwoTurns turns = SineCosineOfTwo(angles_rad[0], angles_rad[1]);
      for (int k = 0; k < 2; ++k) {
        EXPECT_NEAR(turns.sine[k], std::sin(angles_rad[k]), kToleranceOfOne) << angles_rad[k];
        EXPECT_NEAR(turns.cosine[k], std::cos(angles_rad[k]), kToleranceOfOne) << angles_rad[k];
      }
    }
  }
}

TEST(TwoTurns, ZeroIsExactAndWhatIsNoNumberStaysOne) {
  const TwoTurns none = SineCosineOfTwo(0.0, -0.0);
  EXPECT_EQ(none.sine[0], 0.0);
  EXPECT_EQ(none.cosine[0], 1.0);
  EXPECT_EQ(none.cosine[1], 1.0);
  const TwoTurns nan = SineCosineOfTwo(std::numeric_limits<double>::quiet_NaN(), 1.0);
  EXPECT_TRUE(std::isnan(nan.sine[0]) && std::isnan(nan.cosine[0]));
  EXPECT_NEAR(nan.sine[1], std::sin(1.0), kToleranceOfOne);
}

}  // namespace
}  // namespace axiscal::geometry
