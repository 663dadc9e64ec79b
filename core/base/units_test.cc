#include "core/base/units.h"

#include <gtest/gtest.h>

namespace axiscal::base {
namespace {

TEST(Units, AnArcSecondIsAboutFiveMicroradians) {
  EXPECT_NEAR(kRadPerArcsec * kUradPerRad, 4.848136811095360, 1e-12);
  EXPECT_DOUBLE_EQ(kRadPerArcsec * kArcsecPerRad, 1.0);
  EXPECT_DOUBLE_EQ(kMmPerUm * kUmPerMm, 1.0);
  EXPECT_DOUBLE_EQ(180.0 * kRadPerDeg * kDegPerRad, 180.0);
}

}  // namespace
}  // namespace axiscal::base
