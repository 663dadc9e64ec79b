// A touch probe's whole way: what to touch, the log of it, the session, what identify makes of it.
#include <gmock/gmock.h>

#include "tests/cli/command_line.h"

namespace axiscal {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::Source;

class Touch : public testing::CommandLine {
 protected:
  // A multi-tasking machine that declares what a sphere on the table shows.
  void SetUp() override {
    std::string machine = ReadSource("tests/data/loop/case-000/machine.json");
    const size_t at = machine.find("\"declared\"");
    ASSERT_NE(at, std::string::npos);
    const size_t end = machine.find(']', at);
    machine.replace(at, end + 1 - at, R"("declared": ["EX0C", "EY0C", "EA0C", "EB0C"])");
    const std::string b = "\"B\": {";
    ASSERT_NE(machine.find(b), std::string::npos);
    machine.replace(machine.find(b), b.size(), b + "\"travel_deg\": [-90, 90], ");
    Write("machine.json", machine);
  }
  static std::string ReadSource(const std::string& name) {
    std::stringstream text;
    text << std::ifstream(Source(name)).rdbuf();
    return text.str();
  }

  // The plan's lines as a control prints them, padded; reading `bad` (from 1) stops `off_mm` late.
  std::string Log(const std::string& plan, int bad, double off_mm) const {
    std::istringstream in(plan);
    std::ostringstream log;
    log << "%\nNumber of Points " << std::count(plan.begin(), plan.end(), '\n') << "\nFeature Model TOUCH\n";
    std::vector<std::string> names;
    int reading = 0;
    for (std::string line; std::getline(in, line);) {
      if (line[0] == '#') continue;
      std::vector<std::string> cells;
      std::istringstream row(line);
      for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
      if (names.empty()) {
        names = cells;
        continue;
      }
      ++reading;
      std::map<std::string, double> of;
      for (size_t i = 0; i + 1 < cells.size(); ++i) of[names[i]] = std::stod(cells[i]);
      for (const char* axis : {"X_mm", "Y_mm", "Z_mm", "B_deg", "C_deg"}) {
        double position = of[axis];
        if (reading == bad && std::string(axis) == "X_mm") position += off_mm * of["nx"];
        if (reading == bad && std::string(axis) == "Y_mm") position += off_mm * of["ny"];
        if (reading == bad && std::string(axis) == "Z_mm") position += off_mm * of["nz"];
        char text[40];
        std::snprintf(text, sizeof(text), "%c%c%9.4f ", axis[0], position < 0 ? '-' : ' ', std::abs(position));
        log << text;
      }
      log << "\n";
    }
    log << "%\n";
    return log.str();
  }
};

TEST_F(Touch, FromPlanToCalibration) {
  const std::string plan =
      "plan touch-sphere-C --machine machine.json --tool-tip '0 0 -350' --ball '90 0 60' --stylus-radius 2 ";
  auto outcome = Run(plan + "-o plan.csv");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(Read("plan.csv"), HasSubstr("# stylus_radius_mm: 2\n"));
  ASSERT_EQ(Run(plan + "--dialect linuxcnc -o probe.ngc").exit_code, 0);
  EXPECT_THAT(Read("probe.ngc"), HasSubstr("G38.2 "));
  Write("probe.log", Log(Read("plan.csv"), 12, 0.120));
  outcome =
      Run("reduce probe.log --template dprnt --plan plan.csv --machine machine.json --session monday -o monday.csv");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  // The same as a Sinumerik program writes it, behind the head of its file.
  ASSERT_EQ(Run(plan + "--dialect sinumerik -o probe.mpf").exit_code, 0);
  EXPECT_THAT(Read("probe.mpf"), HasSubstr("\nMEAS=1 G01 "));
  Write("probe.mpf.log", "%_N_AXISCAL_LOG_MPF\n;$PATH=/_N_MPF_DIR\n" + Read("probe.log"));
  outcome =
      Run("reduce probe.mpf.log --template sinumerik-write --plan plan.csv --machine machine.json --session monday -o "
          "s.csv");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(Read("s.csv"), Read("monday.csv"));
  EXPECT_EQ(Run("reduce probe.mpf.log --template dprnt --plan plan.csv --machine machine.json -o d.csv").exit_code, 3);
  ASSERT_EQ(Run("machine add machine.json").exit_code, 0);
  outcome = Run("upload monday.csv");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  outcome = Run("identify --machine mt --sessions monday");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("rejected touch: session monday, row 12 is 1"));
  EXPECT_THAT(outcome.out, HasSubstr("off its fellows' sphere, gate 20"));
  // A stylus that is another one is not rejected hit by hit: the session is refused, and says so.
  std::string wrong = Read("monday.csv");
  wrong.replace(wrong.find("stylus_radius_mm: 2"), 19, "stylus_radius_mm: 3");
  Write("wrong.csv", wrong);
  outcome = Run("upload wrong.csv");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("lie on a radius of 14.5"));
  EXPECT_THAT(outcome.err, HasSubstr("was it measured with another stylus?"));
}

TEST_F(Touch, ListAndProposalKnowTouches) {
  auto outcome = Run("plan --list --json --machine machine.json --tool-tip '0 0 -350' --ball '90 0 60'");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  std::map<std::string, int> ranks;
  const auto json = outcome.Json();
  for (const auto& test : json["tests"]) ranks[test["session"]] = test["rank"];
  for (const char* session : {"touch-sphere-B", "touch-sphere-C", "touch-plate-C", "touch-columns", "touch-blocks"})
    EXPECT_EQ(ranks.count(session), 1u) << session;
  EXPECT_EQ(ranks["touch-columns"], 4);
  EXPECT_EQ(ranks["touch-sphere-C"], 4);
  EXPECT_LT(ranks["touch-plate-C"], 4);  // a plate knows nothing of where C stands
}

// Touch patterns beside all others: what a probe can do is proposed where it sees most.
TEST_F(Touch, ForProposesTouchPatterns) {
  auto outcome = Run(
      "plan --for EX0C,EY0C,EA0C,EB0C --json --machine machine.json --tool-tip '0 0 -350' --ball '90 0 60' --with "
      "touch-sphere,touch-plate,touch-columns,touch-blocks");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto json = outcome.Json();
  ASSERT_GE(json["tests"].size(), 1u);
  for (const auto& test : json["tests"])
    EXPECT_EQ(test["test"].get<std::string>().rfind("touch-", 0), 0u) << test["test"];
  for (const auto& error : json["errors"]) EXPECT_TRUE(error["identifiable"].get<bool>()) << error;
  outcome = Run("plan --list --with touch-ball --machine machine.json");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("touch-ball"));
  EXPECT_THAT(outcome.err, HasSubstr("touch-columns"));
}

// A pattern of another machine, or one that this one cannot run, is refused with what was expected.
TEST_F(Touch, PatternsThatDoNotMatchTheMachineAreRefused) {
  ASSERT_EQ(Run("plan touch-columns --machine machine.json -o plan.csv").exit_code, 0);
  Write(
      "mill.json",
      R"({"id": "mill", "axes": {"X": {"kind": "linear", "direction": [1, 0, 0]},
            "Y": {"kind": "linear", "direction": [0, 1, 0]},
            "Z": {"kind": "linear", "direction": [0, 0, 1]}},
            "tool_branch": ["X", "Y", "Z"], "work_branch": [], "tool_direction": [0, 0, -1]})");
  Write("probe.log", "X1.0 Y2.0 Z3.0\n");
  auto outcome = Run("reduce probe.log --template dprnt --plan plan.csv --machine mill.json -o s.csv");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("expected 'mill'"));
  outcome = Run("plan touch-columns --machine mill.json -o mill.csv");
  EXPECT_EQ(outcome.exit_code, 4);
  EXPECT_THAT(outcome.err, HasSubstr("is no test that machine mill can run"));
  EXPECT_EQ(Run("plan touch-sphere --stylus-radius 0 --machine machine.json -o a.csv").exit_code, 3);
  EXPECT_EQ(Run("plan touch-sphere --dialect heidenhain --machine machine.json -o a.h").exit_code, 5);
  for (const char* file : {"s.csv", "mill.csv", "a.csv", "a.h"}) EXPECT_FALSE(Exists(file)) << file;
}

}  // namespace
}  // namespace axiscal
