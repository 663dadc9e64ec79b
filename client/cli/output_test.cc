#include "client/cli/output.h"

#include <gtest/gtest.h>

namespace axiscal::cli {
namespace {

TEST(Output, TablesAlignNumbersToTheRight) {
  EXPECT_EQ(Table({{"error", "value", "note"}, {"EA0B", "-101.2", ""}, {"EX0C", "5", "x"}}),
            "error   value  note\n"
            "EA0B   -101.2\n"
            "EX0C        5  x\n");
  EXPECT_EQ(Table({{"id", "name"}}), "id  name\n");
}

TEST(Output, NumbersHaveFourDigits) {
  EXPECT_EQ(NumberText(1299.04), "1299.0");
  EXPECT_EQ(NumberText(19.6), "19.60");
  EXPECT_EQ(NumberText(2.9712), "2.971");
  EXPECT_EQ(NumberText(-0.00041), "-0.000410");
  EXPECT_EQ(NumberText(0.0), "0.0");
  EXPECT_EQ(NumberText(std::nullopt), "-");
}

TEST(Output, TimesAreUtcBothWays) {
  const auto time = ParseTime("--from", "2026-05-31T14:03:07Z");
  ASSERT_TRUE(time.ok()) << time.status();
  EXPECT_EQ(TimeText(*time), "2026-05-31 14:03:07");
  EXPECT_EQ(TimeJson(*time), "2026-05-31T14:03:07.000000Z");
  EXPECT_EQ(TimeText(*ParseTime("--from", "2026-05-31")), "2026-05-31 00:00:00");
  EXPECT_TRUE(TimeJson(std::nullopt).is_null());
  EXPECT_EQ(TimeJson(base::FromUtcUs(-1)), "1969-12-31T23:59:59.999999Z");
}

TEST(Output, OtherTimesAreRefused) {
  for (const char* text :
       {"", "yesterday", "2026-13-01", "2026-05-31T", "2026-05-31T25:00:00", "2026-05-31 14:03:07 CET", "2026-02-31"}) {
    EXPECT_EQ(ParseTime("--from", text).status().code(), absl::StatusCode::kInvalidArgument) << text;
  }
}

}  // namespace
}  // namespace axiscal::cli
