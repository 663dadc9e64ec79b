// axiscal figures on files, without a database.
#include <gmock/gmock.h>

#include "tests/cli/command_line.h"

namespace axiscal {
namespace {

using ::testing::HasSubstr;
using testing::Source;

class Figures : public testing::CommandLine {
 protected:
  static std::string Case(const std::string& file) { return "'" + Source("tests/data/loop/" + file) + "'"; }
};

TEST_F(Figures, FiguresOfBallBarCircles) {
  const std::string folder = "case-001/fit/";
  const auto outcome =
      Run("figures --json --machine " + Case("case-001/machine.json") + " " + Case(folder + "02-circle-XY-ccw.csv") +
          " " + Case(folder + "03-circle-XY-cw.csv") + " " + Case(folder + "00-nest-inner.csv"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto json = outcome.Json();
  ASSERT_EQ(json["tests"].size(), 1u);
  EXPECT_EQ(json["tests"][0]["sessions"].size(), 2u);
  std::map<std::string, double> um;
  for (const auto& figure : json["tests"][0]["figures"]) um[figure["symbol"]] = figure["value"];
  ASSERT_TRUE(um.contains("G(b)"));
  EXPECT_GT(um["G ccw"], 0.5);
  EXPECT_GE(um["G(b)"] + 1e-6, std::max(um["G ccw"], um["G cw"]));
  EXPECT_GE(um["F ccw max"] - um["F ccw min"] + 1e-6, um["G ccw"]);
  EXPECT_EQ(json["left_out"].size(), 1u);
}

TEST_F(Figures, FiguresOfNothingFail) {
  const auto outcome =
      Run("figures --machine " + Case("case-001/machine.json") + " " + Case("case-001/fit/00-nest-inner.csv"));
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("none of these sessions has any"));
  EXPECT_EQ(Run("figures --machine " + Case("case-001/machine.json") + " missing.csv").exit_code, 4);
}

}  // namespace
}  // namespace axiscal
