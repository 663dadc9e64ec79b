#include "core/loop/aliases.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/units.h"

namespace axiscal::loop {
namespace {

std::vector<double> Turn(double step_deg) {
  std::vector<double> positions;
  for (double deg = -180.0; deg <= 180.0; deg += step_deg) positions.push_back(deg * base::kRadPerDeg);
  return positions;
}

TEST(Aliases, EvenStepsFoldOrdersAtTheirNumber) {
  EXPECT_THAT(AliasOrders(Turn(10.0), 9, 100), testing::ElementsAre(27, 45, 63, 81, 99));
  EXPECT_THAT(AliasOrders(Turn(10.0), 2, 80), testing::ElementsAre(34, 38, 70, 74));
}

TEST(Aliases, UnevenStepsTellAllApart) {
  std::vector<double> positions = Turn(10.0);
  for (size_t i = 0; i < positions.size(); ++i) positions[i] += 0.03 * static_cast<double>(i * i % 7);
  EXPECT_THAT(AliasOrders(positions, 9, 100), testing::IsEmpty());
  EXPECT_THAT(AliasOrders({}, 9, 100), testing::IsEmpty());
}

}  // namespace
}  // namespace axiscal::loop
