#include "client/cli/output.h"

#include <gtest/gtest.h>

#include <cmath>

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
  EXPECT_EQ(TimeJson(*time).Dump(), "\"2026-05-31T14:03:07.000000Z\"");
  EXPECT_EQ(TimeText(*ParseTime("--from", "2026-05-31")), "2026-05-31 00:00:00");
  EXPECT_EQ(TimeJson(std::nullopt).Dump(), "null");
  EXPECT_EQ(TimeJson(base::FromUtcUs(-1)).Dump(), "\"1969-12-31T23:59:59.999999Z\"");
}

TEST(Output, JsonIsWrittenInTheOrderInWhichItWasPutTogether) {
  Json json = {{"id", int64_t{-7}},
               {"seed", uint64_t{1} << 63},
               {"rms", 2.0},
               {"none", NAN},
               {"on", true},
               {"nothing", nullptr},
               {"names", std::vector<std::string>{"b", "a"}},
               {"inner", {{"z", "1"}, {"a", Json::Array()}}}};
  json["file"] = "x";
  json["inner"]["late"] = 1;
  EXPECT_EQ(json.Dump(),
            "{\n \"id\": -7,\n \"seed\": 9223372036854775808,\n \"rms\": 2.0,\n \"none\": null,\n \"on\": true,\n"
            " \"nothing\": null,\n \"names\": [\n  \"b\",\n  \"a\"\n ],\n \"inner\": {\n  \"z\": \"1\",\n  \"a\": [],\n"
            "  \"late\": 1\n },\n \"file\": \"x\"\n}");
}

TEST(Output, JsonHoldsDocumentsAsTheyAre) {
  Json document = Json::Document(R"({"b": 1, "a": 2.50})");
  document["job"] = 3;
  EXPECT_EQ(document.Dump(), "{\n \"b\": 1,\n \"a\": 2.5,\n \"job\": 3\n}");
  EXPECT_EQ(Json::Document("no JSON").Dump(), "\"no JSON\"");
  EXPECT_EQ(Json::Object().Dump(), "{}");
}

TEST(Output, OtherTimesAreRefused) {
  for (const char* text :
       {"", "yesterday", "2026-13-01", "2026-05-31T", "2026-05-31T25:00:00", "2026-05-31 14:03:07 CET", "2026-02-31"}) {
    EXPECT_EQ(ParseTime("--from", text).status().code(), absl::StatusCode::kInvalidArgument) << text;
  }
}

}  // namespace
}  // namespace axiscal::cli
