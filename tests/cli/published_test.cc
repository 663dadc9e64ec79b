// axiscal published: what publications' own formulas give beside the exact model.
#include <gmock/gmock.h>

#include <map>

#include "tests/cli/command_line.h"

namespace axiscal {
namespace {

using ::testing::HasSubstr;
using testing::Source;

class Published : public testing::CommandLine {
 protected:
  static std::string Example(const std::string& name) { return "'" + Source("deploy/examples/" + name) + "'"; }

  std::map<std::string, nlohmann::json> Rows(const std::string& arguments) const {
    const auto outcome = Run("published --json " + arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    std::map<std::string, nlohmann::json> rows;
    if (outcome.exit_code != 0) return rows;
    const nlohmann::json json = outcome.Json();
    for (const nlohmann::json& row : json["rows"]) rows[row["quantity"]] = row;
    return rows;
  }
};

TEST_F(Published, CompensationFromFilesAndWithSigmaFromACalibration) {
  const std::string rest = "--unit mm --tool-tip '0 0 -356.3945' " + Example("integrex/fig-4.30-original.nc");
  const auto files = Rows("yao-compensation --machine " + Example("integrex/machine.json") + " --errors " +
                          Example("integrex/errors-table-4.5.json") + " " + rest);
  ASSERT_EQ(files.size(), 60u);
  EXPECT_NEAR(files.at("left in X, line 1")["published"].get<double>(), -54.78, 0.02);
  EXPECT_TRUE(files.at("left in X, line 1")["sigma"].is_null());
  ASSERT_EQ(Run("machine add " + Example("integrex/machine.json")).exit_code, 0);
  ASSERT_EQ(Run("upload " + Example("integrex/eccentricity-B.csv")).exit_code, 0);
  ASSERT_EQ(Run("identify --machine integrex-i200 --all --declare EB0B,EA0B,EC0B,EZ0T").exit_code, 0);
  EXPECT_EQ(Run("published yao-compensation --machine integrex-i200 " + rest).exit_code, 4) << "none is approved";
  ASSERT_EQ(Run("approve 1").exit_code, 0);
  const double tilt_sigma =
      Run("calibration show 1 --json").Json()["report"]["errors"][0]["sigma"].get<double>();  // EB0B, urad
  const auto stored = Rows("yao-compensation --machine integrex-i200 " + rest);
  ASSERT_EQ(stored.size(), 60u);
  EXPECT_NEAR(stored.at("left in X, line 1")["sigma"].get<double>() / (tilt_sigma * 0.3563945), 1.0, 1e-3);
  EXPECT_NEAR(stored.at("left in X, line 1")["exact"].get<double>(), 0.0, 0.01);
  const auto twice = Rows("yao-equation-3.13 --calibration 1 --machine integrex-i200 " + rest);
  EXPECT_NEAR(twice.at("change of X, line 1")["published"].get<double>(),
              2.0 * stored.at("change of X, line 1")["published"].get<double>(), 1e-9);
}

TEST_F(Published, BadInputIsRefusedWithWhatWasExpected) {
  const auto message = [&](const std::string& arguments, int exit_code = 3) {
    const auto outcome = Run("published " + arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << arguments;
    return outcome.err;
  };
  const std::string files = " --machine " + Example("integrex/machine.json") + " --errors " +
                            Example("integrex/errors-table-4.5.json") + " ",
                    program = Example("integrex/fig-4.30-original.nc");
  EXPECT_THAT(message("yao --machine m x"), HasSubstr("expected one of yao-table-4.5, yao-compensation"));
  EXPECT_THAT(message("yao-compensation" + files + program), HasSubstr("--tool-tip: ''"));
  EXPECT_THAT(message("yao-compensation --tool-tip '0 0 -1'" + files + program + " " + program),
              HasSubstr("expected one NC program"));
  EXPECT_THAT(message("yao-table-4.5" + files + Example("integrex/eccentricity-B.csv")),
              HasSubstr("expected no --tool-tip, --unit, --errors, --calibration"));
  Write("arc.nc", "G21 G01 X0. Y0. Z0. B0. C0. F100\nG02 X1. Z1. I1. K0.\n");
  EXPECT_THAT(message("yao-compensation --tool-tip '0 0 -1'" + files + "arc.nc"),
              HasSubstr("arc.nc: line 2: expected linear moves"));
  Write("empty.json", "{}");
  EXPECT_THAT(message("yao-compensation --tool-tip '0 0 -1' --errors empty.json --machine " +
                      Example("integrex/machine.json") + " " + program),
              HasSubstr("empty.json: held errors: there is none in it"));
}

}  // namespace
}  // namespace axiscal
