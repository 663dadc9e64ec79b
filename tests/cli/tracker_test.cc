// A tracker whose stand warms up and is knocked once while it measures, from its log to the report, by the commands of
// docs/logs.md. Its readings are made here, by nothing of Axiscal's own.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <random>

#include "tests/cli/command_line.h"

namespace axiscal {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Source;

constexpr double kScaleX = 60e-6, kScaleZ = -40e-6;  // mm per mm
constexpr double kSquarenessRad = -150e-6;           // of X, about z: going along X moves the tool along y
constexpr double kNoiseMm = 4e-3;

class Tracker : public testing::CommandLine {
 protected:
  void AddMachine() {
    std::stringstream text;
    text << std::ifstream(Source("deploy/examples/simulated/machine.json")).rdbuf();
    nlohmann::json machine = nlohmann::json::parse(text.str());
    for (const char* const axis : {"X", "Y", "Z"}) machine["axes"][axis]["travel_mm"] = {-300, 300};
    Write("machine.json", machine.dump());
    ASSERT_EQ(Run("machine add machine.json").exit_code, 0);
    Write("errors.json",
          R"({"EC0X": 0, "terms": [{"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 0})"
          R"(, {"symbol": "EZZ", "shape": "linear", "variable": "Z", "amplitude": 0}]})");
  }

  // What the tracker wrote while `plan` ran: time, target, x, y, z. Its references stand some cm from where the plan
  // wants them, its target is not at the tool's tip, and its stand moves by `drift_mm` and turns with the time;
  // at `knocked_s` it goes by a tenth of a mm more.
  void RunTracker(const std::string& plan, double drift_mm, double knocked_s, const std::string& log) {
    std::mt19937_64 random(7);
    std::normal_distribution<double> normal;
    std::map<std::string, Eigen::Vector3d> references;
    std::istringstream lines(Read(plan));
    const Eigen::Vector3d target(0.7, -1.2, -148.5);  // on the tool
    const Eigen::Affine3d frame = Eigen::Translation3d(-3100.0, 1250.0, 180.0) *
                                  Eigen::AngleAxisd(0.8, Eigen::Vector3d(0.05, -0.1, 1.0).normalized());
    std::string out = "# LT 5500 station 1\r\n";
    bool is_row = false;
    for (std::string row; std::getline(lines, row);) {
      char name[20];
      double t_s, z, y, x, b, c;
      if (std::sscanf(row.c_str(), "# reference %19[^:]: %lf %lf %lf", name, &x, &y, &z) == 4)
        references[name] =
            Eigen::Vector3d(x, y, z) + 20.0 * Eigen::Vector3d(normal(random), normal(random), normal(random));
      if (row.rfind("t_s,", 0) == 0) {
        ASSERT_EQ(row, "t_s,Z_mm,Y_mm,X_mm,B_deg,C_deg,target");
        is_row = true;
        continue;
      }
      if (!is_row) continue;
      ASSERT_EQ(std::sscanf(row.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf,%19s", &t_s, &z, &y, &x, &b, &c, name), 7) << row;
      Eigen::Vector3d place;
      if (references.count(name) != 0) {
        place = references[name];
      } else {
        const Eigen::Vector3d slide(x * (1.0 + kScaleX), y + kSquarenessRad * x, z * (1.0 + kScaleZ));
        place = slide + Eigen::AngleAxisd(b * M_PI / 180.0, Eigen::Vector3d::UnitY()) * target;
      }
      // Warming up: fast at first.
      const double share = 1.0 - std::exp(-t_s / 600.0);
      Eigen::Vector3d shift = drift_mm * share * Eigen::Vector3d(0.4, -0.7, 0.6);
      if (t_s >= knocked_s) shift += Eigen::Vector3d(0.08, 0.05, -0.03);
      const Eigen::AngleAxisd turn(3e-4 * drift_mm * share, Eigen::Vector3d(0.3, 0.9, 0.3).normalized());
      Eigen::Vector3d seen = turn * (frame * place) + shift;
      for (double& value : seen) value += kNoiseMm * normal(random);
      char line[120];
      std::snprintf(line, sizeof line, "%7.1f;%s;%.4f;%.4f;%.4f\r\n", t_s, name, seen.x(), seen.y(), seen.z());
      out += line;
    }
    Write(log, out);
  }

  static bool IsInDocs(const std::string& output) {
    std::stringstream docs;
    docs << std::ifstream(Source("docs/logs.md")).rdbuf();
    return docs.str().find(output) != std::string::npos;
  }

  std::map<std::string, nlohmann::json> Estimates(const nlohmann::json& result) {
    std::map<std::string, nlohmann::json> by_error;
    for (const auto& estimate : result["estimates"]) by_error[estimate["symbol"]] = estimate;
    return by_error;
  }

  void ExpectTruth(const nlohmann::json& result) {
    std::map<std::string, nlohmann::json> by_error = Estimates(result);
    for (const auto& [error, truth] :
         {std::make_pair("EC0X", kSquarenessRad * 1e6), std::make_pair("EXX:linear/m", kScaleX * 1e6),
          std::make_pair("EZZ:linear/m", kScaleZ * 1e6)}) {
      ASSERT_TRUE(by_error[error].is_object() && by_error[error]["identifiable"]) << result;
      const double sigma = by_error[error]["sigma"];
      EXPECT_NEAR(by_error[error]["value"], truth, 3.0 * sigma) << error;
      EXPECT_LT(sigma, 20.0) << error;
    }
  }
};

constexpr char kTemplate[] = "line: {t_s};{target};{px_mm};{py_mm};{pz_mm}\nskip: # {*}\n";
const double kNever = INFINITY;

TEST_F(Tracker, FromTheLogToTheReport) {
  AddMachine();
  const auto planned = Run("plan --machine machine.json --tool-tip '0 0 -150' tracker-references -o tracker.csv");
  ASSERT_EQ(planned.exit_code, 0) << planned.err;
  EXPECT_TRUE(IsInDocs(planned.out)) << planned.out;
  RunTracker("tracker.csv", 0.25, kNever, "tracker.log");
  Write("tracker.template", kTemplate);
  const auto stored = Run("upload tracker.log --template tracker.template --plan tracker.csv --machine mt");
  ASSERT_EQ(stored.exit_code, 0) << stored.err;
  const auto identified = Run("identify --machine mt --all --model errors.json --json");
  ASSERT_EQ(identified.exit_code, 0) << identified.err;
  const nlohmann::json result = identified.Json();
  ExpectTruth(result);
  EXPECT_LT(result["report"]["fit"]["chi2_per_dof"], 2.0);
  // The motion has its name: the tracker's.
  std::string moved;
  for (const auto& warning : result["report"]["warnings"])
    if (warning["kind"] == "moved") moved = warning["text"];
  EXPECT_THAT(moved, HasSubstr("session 'tracker-references': the tracker itself moved, not the machine"));
  EXPECT_THAT(moved, HasSubstr("3 reference targets"));
  EXPECT_EQ(Run("approve 1").exit_code, 0);
  const auto report = Run("report 1 -o report.html");
  ASSERT_EQ(report.exit_code, 0) << report.err;
  EXPECT_THAT(Read("report.html"), HasSubstr("the tracker itself moved"));
  // The loop names nothing of it that would be corrected: how the stand went between two looks, beyond steadily, may
  // stay as a curve over the time.
  const auto found = Run("close-loop --machine mt --fit tracker-references");
  ASSERT_EQ(found.exit_code, 0) << found.err;
  EXPECT_THAT(found.out, HasSubstr("the tracker itself moved"));
  EXPECT_THAT(found.out, Not(ContainsRegex("[+] [^\n]*drift")));
}

// Without the references the same readings tell another machine.
TEST_F(Tracker, ThatWasNotWatchedIsTakenForTheMachine) {
  AddMachine();
  ASSERT_EQ(Run("plan --machine machine.json --tool-tip '0 0 -150' tracker-references -o tracker.csv").exit_code, 0);
  RunTracker("tracker.csv", 0.25, kNever, "tracker.log");
  std::string log = Read("tracker.log"), plan = Read("tracker.csv"), kept_log, kept_plan;
  std::istringstream logged(log), planned(plan);
  for (std::string line; std::getline(logged, line);)
    if (line.find(";R") == std::string::npos) kept_log += line + "\n";
  for (std::string line; std::getline(planned, line);)
    if (line.find(",R") == std::string::npos && line.rfind("# reference", 0) != 0) kept_plan += line + "\n";
  Write("alone.log", kept_log);
  Write("alone.csv", kept_plan);
  Write("tracker.template", kTemplate);
  ASSERT_EQ(Run("upload alone.log --template tracker.template --plan alone.csv --machine mt").exit_code, 0);
  const auto identified = Run("identify --machine mt --all --model errors.json --json");
  ASSERT_EQ(identified.exit_code, 0) << identified.err;
  EXPECT_GT(identified.Json()["report"]["fit"]["chi2_per_dof"], 4.0);
}

TEST_F(Tracker, ThatWasKnockedAtAKnownTime) {
  AddMachine();
  ASSERT_EQ(Run("plan --machine machine.json --tool-tip '0 0 -150' tracker-references -o tracker.csv").exit_code, 0);
  RunTracker("tracker.csv", 0.02, 303.0, "tracker.log");
  Write("tracker.csv", "# knocked_s: 303\n" + Read("tracker.csv"));
  Write("tracker.template", kTemplate);
  ASSERT_EQ(Run("upload tracker.log --template tracker.template --plan tracker.csv --machine mt").exit_code, 0);
  const auto identified = Run("identify --machine mt --all --model errors.json --json");
  ASSERT_EQ(identified.exit_code, 0) << identified.err;
  ExpectTruth(identified.Json());
  EXPECT_LT(identified.Json()["report"]["fit"]["chi2_per_dof"], 1.5);
}

// What a new user states wrong.
TEST_F(Tracker, WhatIsStatedWrongIsToldHow) {
  AddMachine();
  ASSERT_EQ(Run("plan --machine machine.json --tool-tip '0 0 -150' tracker-references -o tracker.csv").exit_code, 0);
  RunTracker("tracker.csv", 0.02, kNever, "tracker.log");
  Write("tracker.template", kTemplate);
  const std::string plan = Read("tracker.csv");
  const auto refused = [&](const std::string& from, const std::string& to) {
    std::string changed = plan;
    for (size_t at = changed.find(from); at != std::string::npos; at = changed.find(from, at + to.size()))
      changed.replace(at, from.size(), to);
    Write("wrong.csv", changed);
    std::string log = Read("tracker.log");
    const auto reduced =
        Run("reduce tracker.log --template tracker.template --plan wrong.csv --machine machine.json -o session.csv");
    EXPECT_NE(reduced.exit_code, 0);
    EXPECT_FALSE(Exists("session.csv"));
    return reduced.err;
  };
  EXPECT_THAT(refused("# reference R2:", "# was R2:"),
              HasSubstr("target R2, tool: expected '# reference NAME: x y z' of what stands beside the machine"));
  EXPECT_THAT(refused("# tool_tip_mm:", "# setup: one\n# tool_tip_mm:"), HasSubstr("has a set-up of its own"));
  EXPECT_THAT(refused("# tool_tip_mm:", "# knocked_s: at noon\n# tool_tip_mm:"), HasSubstr("expected times t_s"));
  EXPECT_THAT(refused("# reference R1:", "# reference R1: 1 2\n# note:"), HasSubstr("expected its place x y z in mm"));
}

}  // namespace
}  // namespace axiscal
