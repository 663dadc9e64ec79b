#include "core/instruments/clock.h"

#include <gtest/gtest.h>

namespace axiscal::instruments {
namespace {

using Names = std::optional<std::pair<std::string, std::string>>;

MeasuringRun Between(const std::string& session, double first_s, double last_s) {
  MeasuringRun run;
  run.session = session;
  run.has_time = true;
  run.time_s = {first_s, 0.5 * (first_s + last_s), last_s};
  return run;
}

TEST(Clock, SessionsThatFollowEachOtherHaveOne) {
  EXPECT_EQ(FindOverlap({}), std::nullopt);
  EXPECT_EQ(FindOverlap({Between("b", 100, 200), Between("a", 0, 100), Between("c", 250, 260)}), std::nullopt);
}

TEST(Clock, SessionsThatOverlapCountFromStartsOfTheirOwn) {
  EXPECT_EQ(FindOverlap({Between("a", 0, 100), Between("b", 0, 19)}), Names({"a", "b"}));
  EXPECT_EQ(FindOverlap({Between("b", 90, 190), Between("c", 200, 300), Between("a", 0, 100)}), Names({"a", "b"}));
}

TEST(Clock, SessionsWithoutTimesOverlapNothing) {
  MeasuringRun untimed = Between("u", 0, 0);
  untimed.has_time = false;
  EXPECT_EQ(FindOverlap({Between("a", 0, 100), untimed}), std::nullopt);
}

}  // namespace
}  // namespace axiscal::instruments
