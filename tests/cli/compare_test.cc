// axiscal compare on files, without a database.
#include <gmock/gmock.h>

#include <cmath>

#include "tests/cli/command_line.h"

namespace axiscal {
namespace {

using ::testing::HasSubstr;
using testing::Source;

class Compare : public testing::CommandLine {
 protected:
  static std::string Case(const std::string& file) { return "'" + Source("tests/data/loop/" + file) + "'"; }
};

constexpr char kJune[] = R"({"EX0C": 50, "EY0C": -20,
 "covariance": {"of": ["EX0C", "EY0C"], "sigma": [3, 3], "correlation": [[], [0]]}})";
constexpr char kJuly[] = R"({"EX0C": 80, "EY0C": -22,
 "covariance": {"of": ["EX0C", "EY0C"], "sigma": [4, 4], "correlation": [[], [0]]}})";

// 30 um of 5 um differ, 2 of 5 do not.
TEST_F(Compare, ComparesTwoErrorFiles) {
  Write("june.json", kJune);
  Write("july.json", kJuly);
  const std::string machine = " --machine " + Case("case-000/machine.json");
  const std::string box =
      " --tool-tip '0 0 -350' --box 'X -200 200' --box 'Y 0 0' --box 'Z 0 0' --box 'B 0 0' --box 'C 0 360'";
  const auto outcome = Run("compare june.json july.json --json" + machine + box);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto json = outcome.Json();
  ASSERT_EQ(json["errors"].size(), 2u);
  EXPECT_EQ(json["errors"][0]["verdict"], "differs");
  EXPECT_NEAR(json["errors"][0]["sigma"].get<double>(), 5.0, 1e-6);
  EXPECT_EQ(json["errors"][1]["verdict"], "agrees");
  EXPECT_NEAR(json["joint"]["chi2"].get<double>(), 36.16, 1e-6);
  EXPECT_NEAR(json["tool_point"]["as_programmed"]["rms_um"].get<double>(), std::sqrt(904.0), 1e-3);
  const auto text = Run("compare june.json july.json" + machine + box);
  EXPECT_THAT(text.out, HasSubstr("this is more"));
  EXPECT_FALSE(Exists("axiscal.db"));
}

TEST_F(Compare, ComparesFitsOfSessions) {
  const auto outcome = Run("compare --json " + Case("case-000") + " " + Case("case-000") + " --machine " +
                           Case("case-000/machine.json"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto json = outcome.Json();
  EXPECT_NEAR(json["tool_point"]["as_programmed"]["max_um"].get<double>(), 0.0, 1e-9);
  EXPECT_EQ(json["tool_point"]["box_from"], "the measured positions");
  EXPECT_THAT(json["notes"].dump(), HasSubstr("not independent"));
}

TEST_F(Compare, CompareSaysWhatIsWrong) {
  Write("june.json", kJune);
  Write("bad.json", R"({"EX0Q": 1})");
  const std::string machine = " --machine " + Case("case-000/machine.json");
  auto outcome = Run("compare june.json bad.json" + machine);
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("bad.json"));
  EXPECT_EQ(Run("compare june.json june.json").exit_code, 3);  // no machine
  EXPECT_EQ(Run("compare june.json missing.json" + machine).exit_code, 4);
  outcome = Run("compare june.json june.json --tool-tip '0 0 -350' --box 'Q 0 1'" + machine);
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("--box"));
  EXPECT_EQ(Run("compare june.json june.json --box 'X 0 1'" + machine).exit_code, 3);  // no tool tip
}

}  // namespace
}  // namespace axiscal
