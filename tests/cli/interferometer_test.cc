// An interferometer that ran both ways along X at five temperatures, from what it wrote to the report, by the commands
// of docs/logs.md. Its readings are made here, by nothing of Axiscal's own.
#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "tests/cli/command_line.h"

namespace axiscal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::Source;

// The slide's true place is q + scale q + backlash / 2 by the side that it comes from, and its glass scale grows.
constexpr double kScalePerMm = 35e-6, kBacklashMm = 3e-3, kGrowthPerK = 9e-6;
constexpr double kNoiseMm = 0.3e-3, kThermometerK = 0.1;
constexpr double kZeroMm = 123.4;  // where the counter was reset

class Interferometer : public testing::CommandLine {
 protected:
  // A mill that states the travel of its X axis, and its plan in line-X.csv with what the user knows of the scale.
  void Plan() {
    std::stringstream text;
    text << std::ifstream(Source("deploy/examples/simulated/machine.json")).rdbuf();
    nlohmann::json machine = nlohmann::json::parse(text.str());
    machine["axes"]["X"]["travel_mm"] = {-300, 300};
    Write("machine.json", machine.dump());
    const auto planned = Run("plan --machine machine.json --tool-tip '0 0 -150' line-X -o line-X.csv");
    ASSERT_EQ(planned.exit_code, 0) << planned.err;
    EXPECT_TRUE(IsInDocs(planned.out)) << planned.out;
    Write("line-X.csv", "# expansion scale X: 9 0.5\n# temperature_sigma_K: 0.1\n" + Read("line-X.csv"));
  }

  // What the laser wrote while the plan ran: seconds, mm, deg C. The thermometer shows `off_K` too much.
  void RunLaser(double temperature_C, double off_K, const std::string& log) {
    std::mt19937_64 random(static_cast<uint64_t>(temperature_C));
    std::normal_distribution<double> noise(0.0, kNoiseMm);
    std::istringstream plan(Read("line-X.csv"));
    std::string out = "LASER LINEAR mm degC\r\n";
    for (std::string row; std::getline(plan, row);) {
      if (row[0] == '#' || row[0] == 't') continue;
      double t_s, z, y, x, b, c, sense;
      ASSERT_EQ(std::sscanf(row.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf,%lf", &t_s, &z, &y, &x, &b, &c, &sense), 7) << row;
      const double place = x + kScalePerMm * x + sense * kBacklashMm / 2.0 + kGrowthPerK * (temperature_C - 20.0) * x;
      char line[80];
      std::snprintf(line, sizeof line, "%8.1f  %12.5f  %6.2f\r\n", t_s, place + kZeroMm + noise(random),
                    temperature_C + off_K);
      out += line;
    }
    Write(log, out);
  }

  static bool IsInDocs(const std::string& output) {
    std::stringstream docs;
    docs << std::ifstream(Source("docs/logs.md")).rdbuf();
    return docs.str().find(output) != std::string::npos;
  }
};

TEST_F(Interferometer, FromTheLogToTheReport) {
  Plan();
  Write("laser.template", "line: {t_s} {L_mm} {temp_C}\nskip: LASER {*}\n");
  ASSERT_EQ(Run("machine add machine.json").exit_code, 0);
  for (const int temperature_C : {16, 18, 20, 22, 24}) {
    const std::string name = std::to_string(temperature_C);
    RunLaser(temperature_C, -kThermometerK, "laser-" + name + ".log");
    const auto reduced = Run("reduce laser-" + name +
                             ".log --template laser.template --plan line-X.csv --machine machine.json --session X-" +
                             name + " -o X-" + name + ".csv");
    ASSERT_EQ(reduced.exit_code, 0) << reduced.err;
    EXPECT_TRUE(temperature_C != 16 || IsInDocs(reduced.out)) << reduced.out;
    ASSERT_EQ(Run("upload X-" + name + ".csv").exit_code, 0);
  }
  // The reversal of ISO 230-2 as each session shows it.
  const auto figures = Run("figures --json --machine machine.json X-16.csv X-18.csv X-20.csv X-22.csv X-24.csv");
  ASSERT_EQ(figures.exit_code, 0) << figures.err;
  const nlohmann::json tests = figures.Json()["tests"];
  ASSERT_EQ(tests.size(), 5u);
  int reversals = 0;
  for (const auto& test : tests) {
    for (const auto& figure : test["figures"]) {
      if (figure["symbol"] != "B mean") continue;
      const double sigma = figure["sigma"];
      EXPECT_NEAR(figure["value"], kBacklashMm * 1e3, 3.0 * sigma);
      ++reversals;
    }
  }
  EXPECT_EQ(reversals, 5);
  Write("errors.json", R"({"terms": [{"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 0},)"
                       R"( {"symbol": "EXX", "shape": "backlash", "variable": "X", "amplitude": 0}]})");
  const auto identified = Run("identify --machine mt --all --model errors.json --json");
  ASSERT_EQ(identified.exit_code, 0) << identified.err;
  std::map<std::string, nlohmann::json> by_error;
  const nlohmann::json result = identified.Json();
  for (const auto& estimate : result["estimates"]) by_error[estimate["symbol"]] = estimate;
  for (const auto& [error, truth_um] : {std::make_pair("EXX:linear/m", kScalePerMm * 1e6),  // um per metre
                                        std::make_pair("EXX:backlash", kBacklashMm * 1e3)}) {
    ASSERT_TRUE(by_error[error].is_object()) << identified.out;
    const double sigma_um = by_error[error]["sigma"];
    EXPECT_NEAR(by_error[error]["value"], truth_um, 3.0 * sigma_um) << error;
  }
  // The thermometer's 0.1 K is 0.9 um/m in every session: five of them know the scale no better.
  EXPECT_GT(by_error["EXX:linear/m"]["sigma"], kThermometerK * kGrowthPerK * 1e6);
  EXPECT_EQ(Run("approve 1").exit_code, 0);
  const auto shown = Run("calibration show 1");
  EXPECT_THAT(shown.out, HasSubstr("EXX:linear"));
  EXPECT_THAT(shown.out, HasSubstr("EXX:backlash"));
  const auto report = Run("report 1 -o report.html");
  ASSERT_EQ(report.exit_code, 0) << report.err;
  EXPECT_THAT(Read("report.html"),
              AllOf(HasSubstr("EXX:linear"), HasSubstr("length along a beam"), HasSubstr("beam along (")));
  // The loop finds both by itself; from one line along X it cannot tell whether X lags or tilts as it turns around.
  const auto found = Run("close-loop --machine mt --fit X-16,X-18,X-20,X-22 --check X-24");
  ASSERT_EQ(found.exit_code, 0) << found.err;
  EXPECT_THAT(found.out, HasSubstr("+ EXX:linear"));
  EXPECT_THAT(found.out, HasSubstr("\n  EXX:backlash  "));
  EXPECT_THAT(found.out, HasSubstr("EBX:backlash"));
}

// Where a new user ends up first: the travel of X typed as that of a rotary axis, an error typed as a report names it.
TEST_F(Interferometer, WhatIsTypedWrongIsToldHow) {
  Plan();
  const auto travel = Run("plan --machine machine.json --travel 'X -250 250' line-X -o other.csv");
  EXPECT_EQ(travel.exit_code, 3);
  EXPECT_THAT(travel.err, HasSubstr("X is linear, expected a rotary axis"));
  EXPECT_THAT(travel.err, HasSubstr("travel_mm of machine.json"));
  EXPECT_FALSE(Exists("other.csv"));
  ASSERT_EQ(Run("machine add machine.json").exit_code, 0);
  RunLaser(20, 0, "laser.log");
  Write("laser.template", "line: {t_s} {L_mm} {temp_C}\nskip: LASER {*}\n");
  ASSERT_EQ(Run("upload laser.log --template laser.template --plan line-X.csv --machine mt").exit_code, 0);
  const auto declared = Run("identify --machine mt --all --declare EXX:linear");
  EXPECT_EQ(declared.exit_code, 3);
  EXPECT_THAT(declared.err, HasSubstr("'EXX:linear' has a shape, expected a symbol alone (EX0C)"));
  EXPECT_THAT(declared.err, HasSubstr("\"terms\" of errors.json"));
  EXPECT_EQ(Run("calibration show 1").exit_code, 4);
}

}  // namespace
}  // namespace axiscal
