#include "server/handlers/call_rates.h"

#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "core/base/testing/fake_clock.h"

namespace axiscal::handlers {
namespace {

TEST(CallRates, EachMayCallSoOftenAndNobodyPaysForAnother) {
  base::FakeClock clock;
  CallRates rates(10, clock);
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(rates.Take("eve").ok()) << i;
  const absl::Status refused = rates.Take("eve");
  EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
  EXPECT_EQ(base::ErrorReason(refused), "RATE_EXCEEDED");
  EXPECT_TRUE(rates.Take("bob").ok());
  clock.Advance(std::chrono::milliseconds(100));
  EXPECT_TRUE(rates.Take("eve").ok());
  EXPECT_FALSE(rates.Take("eve").ok());
  clock.Advance(std::chrono::hours(1));
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(rates.Take("eve").ok()) << i;
  EXPECT_FALSE(rates.Take("eve").ok());
}

TEST(CallRates, WhoIsQuietIsForgotten) {
  base::FakeClock clock;
  CallRates rates(10, clock);
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(rates.Take(std::to_string(i)).ok());
  EXPECT_EQ(rates.remembered(), 1000u);
  clock.Advance(std::chrono::seconds(3));
  ASSERT_TRUE(rates.Take("0").ok());
  EXPECT_EQ(rates.remembered(), 1u);
}

}  // namespace
}  // namespace axiscal::handlers
