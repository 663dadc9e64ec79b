// A draw wire at the end of an arm, whose anchor is known to some millimetres only, in three places: from its logs to
// the report. Its readings are made here, by nothing of Axiscal's own.
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

constexpr double kScaleX = 60e-6, kScaleZ = -40e-6;  // mm per mm
constexpr double kSquarenessRad = -150e-6;           // of X, about z: going along X moves the tool along y
constexpr double kWireScale = 20e-6, kWireNoiseMm = 5e-3;

class DrawWire : public testing::CommandLine {
 protected:
  // What the wire's display wrote while the plan ran; it shows 17 mm too little, its anchor and eye are not where the
  // plan says.
  void RunWire(int place) {
    std::mt19937_64 random(static_cast<uint64_t>(place));
    std::normal_distribution<double> normal;
    const std::string number = std::to_string(place);
    std::istringstream plan(Read("wire-" + number + ".csv"));
    double ax = NAN, ay = NAN, az = NAN;
    const double off[6] = {3 * normal(random), 3 * normal(random), 3 * normal(random),
                           2 * normal(random), 2 * normal(random), 2 * normal(random)};
    const double scale = 1.0 + kWireScale * normal(random);
    std::string out = "SENSOR WDS-1500\n";
    for (std::string row; std::getline(plan, row);) {
      if (row.rfind("# anchor_mm:", 0) == 0) {
        ASSERT_EQ(std::sscanf(row.c_str(), "# anchor_mm: %lf %lf %lf", &ax, &ay, &az), 3) << row;
      }
      if (row[0] == '#' || row[0] == 't') continue;
      double t_s, z, y, x;
      ASSERT_EQ(std::sscanf(row.c_str(), "%lf,%lf,%lf,%lf", &t_s, &z, &y, &x), 4) << row;
      const double length =
          std::hypot(x * (1.0 + kScaleX) + off[3] - ax - off[0], y + kSquarenessRad * x + off[4] - ay - off[1],
                     z * (1.0 + kScaleZ) - 150.0 + off[5] - az - off[2]);
      char line[60];
      std::snprintf(line, sizeof line, "%6.1f;%10.3f\n", t_s, scale * length - 17.0 + kWireNoiseMm * normal(random));
      out += line;
    }
    Write("wire-" + number + ".log", out);
  }
};

TEST_F(DrawWire, FromTheLogsToTheReport) {
  std::stringstream text;
  text << std::ifstream(Source("deploy/examples/simulated/machine.json")).rdbuf();
  nlohmann::json machine = nlohmann::json::parse(text.str());
  for (const char* const axis : {"X", "Y", "Z"}) machine["axes"][axis]["travel_mm"] = {-300, 300};
  Write("machine.json", machine.dump());
  ASSERT_EQ(Run("machine add machine.json").exit_code, 0);
  Write("wire.template", "line: {t_s};{L_mm}\nskip: SENSOR {*}\n");
  for (const int place : {1, 2, 3}) {
    const std::string number = std::to_string(place), plan = "wire-" + number + ".csv";
    ASSERT_EQ(Run("plan --machine machine.json --tool-tip '0 0 -150' distances-" + number + " -o " + plan).exit_code,
              0);
    RunWire(place);
    const auto stored = Run("upload wire-" + number + ".log --template wire.template --plan " + plan + " --machine mt");
    ASSERT_EQ(stored.exit_code, 0) << stored.err;
  }
  Write("errors.json", R"({"EC0X": 0, "terms": [{"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 0},)"
                       R"( {"symbol": "EZZ", "shape": "linear", "variable": "Z", "amplitude": 0}]})");
  const auto identified = Run("identify --machine mt --all --model errors.json --json");
  ASSERT_EQ(identified.exit_code, 0) << identified.err;
  std::map<std::string, nlohmann::json> by_error;
  const nlohmann::json result = identified.Json();
  for (const auto& estimate : result["estimates"]) by_error[estimate["symbol"]] = estimate;
  // The wire's own 20 um/m stays in the scales, not in the squareness.
  for (const auto& [error, truth, most_sigma] :
       {std::make_tuple("EC0X", kSquarenessRad * 1e6, 20.0), std::make_tuple("EXX:linear/m", kScaleX * 1e6, 25.0),
        std::make_tuple("EZZ:linear/m", kScaleZ * 1e6, 25.0)}) {
    ASSERT_TRUE(by_error[error].is_object() && by_error[error]["identifiable"]) << identified.out;
    const double sigma = by_error[error]["sigma"];
    EXPECT_NEAR(by_error[error]["value"], truth, 3.0 * sigma) << error;
    EXPECT_LT(sigma, most_sigma) << error;
  }
  EXPECT_EQ(Run("approve 1").exit_code, 0);
  const auto report = Run("report 1 -o report.html");
  ASSERT_EQ(report.exit_code, 0) << report.err;
  EXPECT_THAT(Read("report.html"),
              AllOf(HasSubstr("EC0X"), HasSubstr("length from an anchor"), HasSubstr("anchor at (")));
}

}  // namespace
}  // namespace axiscal
