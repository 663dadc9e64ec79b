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

// Steps of 15 and of 20 deg are all whole multiples of 5, and no wave is the same at all of them before 72 per turn.
TEST(Aliases, PositionsOfAllSessionsTellTogether) {
  constexpr double kLimit = 400.0;
  EXPECT_NEAR(HighestFrequency(Turn(15.0), kLimit), 12.0, 0.2);
  std::vector<double> positions = Turn(15.0);
  for (const double position : Turn(20.0)) positions.push_back(position);
  EXPECT_NEAR(HighestFrequency(positions, kLimit), 36.0, 0.2);
  for (size_t i = 0; i < positions.size(); ++i) positions[i] += 0.013 * std::sin(static_cast<double>(i * i));
  EXPECT_EQ(HighestFrequency(positions, kLimit), kLimit);
  EXPECT_NEAR(HighestFrequency(Turn(0.5), kLimit), 360.0, 0.2);
  EXPECT_EQ(HighestFrequency({0.0, 1.0}, kLimit), 0.0);
}

// On the part of a turn that a trunnion has, too.
TEST(Aliases, ImagesReadTheSameAtAllPositions) {
  std::vector<double> positions;
  for (double deg = -90.0; deg <= 30.0; deg += 15.0) positions.push_back(deg * base::kRadPerDeg);
  constexpr double kOrder = 7.3, kShare = 1e-3;
  const Eigen::Vector2d amplitudes(3.0, -1.2);
  const std::vector<Alias> aliases = AliasesOf(positions, kOrder, 60.0, kShare);
  std::vector<double> frequencies;
  for (const Alias& alias : aliases) {
    frequencies.push_back(alias.frequency);
    const Eigen::Vector2d image = alias.of_amplitudes * amplitudes;
    for (const double at : positions) {
      EXPECT_NEAR(image[0] * std::cos(alias.frequency * at) + image[1] * std::sin(alias.frequency * at),
                  amplitudes[0] * std::cos(kOrder * at) + amplitudes[1] * std::sin(kOrder * at), 1e-4)
          << alias.frequency;
    }
  }
  EXPECT_THAT(frequencies, testing::Pointwise(testing::DoubleNear(1e-5), {16.7, 31.3, 40.7, 55.3}));
  for (size_t i = 0; i < positions.size(); ++i) positions[i] += 0.03 * static_cast<double>(i * i % 7);
  EXPECT_THAT(AliasesOf(positions, kOrder, 60.0, kShare), testing::IsEmpty());
  EXPECT_THAT(AliasesOf({}, kOrder, 60.0, kShare), testing::IsEmpty());
}

TEST(Aliases, UnevenStepsTellAllApart) {
  std::vector<double> positions = Turn(10.0);
  for (size_t i = 0; i < positions.size(); ++i) positions[i] += 0.03 * static_cast<double>(i * i % 7);
  EXPECT_THAT(AliasOrders(positions, 9, 100), testing::IsEmpty());
  EXPECT_THAT(AliasOrders({}, 9, 100), testing::IsEmpty());
}

}  // namespace
}  // namespace axiscal::loop
