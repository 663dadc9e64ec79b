// axiscal simulate: a case that the other commands read, the truth beside it, and refusals that leave nothing behind.
#include <gmock/gmock.h>

#include <filesystem>

#include "tests/cli/command_line.h"

namespace axiscal {
namespace {

using ::testing::HasSubstr;
using testing::Source;

class Simulate : public testing::CommandLine {
 protected:
  void WriteScenario(const std::string& members, const std::string& plan = "") const {
    Write("scenario.json", "{\"axiscal\": \"scenario/1\", \"plan\": {" +
                               (plan.empty() ? "\"case\": \"" + Source("tests/data/loop/case-003") + "\"" : plan) +
                               "}, " + members + "}");
  }
  // Every file of a folder with its name.
  std::string AllOf(const std::string& folder) const {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / folder)) {
      const std::string name = std::filesystem::relative(entry.path(), folder_).string();
      if (entry.is_regular_file()) files[name.substr(folder.size())] = Read(name);
    }
    std::string all;
    for (const auto& [name, content] : files) all += name + "\n" + content;
    return all;
  }
};

TEST_F(Simulate, TheLoopFindsWhatWentIn) {
  WriteScenario(
      R"("errors": {"EX0C": 25, "EA0B": -40, "terms": [{"symbol": "EXX", "shape": "backlash", "amplitude": 4}]})");
  const auto outcome = Run("simulate scenario.json -o made --seed 5");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("made: seed 5, form own\n"));
  EXPECT_THAT(outcome.out, HasSubstr("errors.json holds all that is wrong with the machine\n"));
  EXPECT_TRUE(Exists("made/fit/00-BX.csv"));
  EXPECT_TRUE(Exists("made/check/03-CT.csv"));
  EXPECT_THAT(Read("made/errors.json"), HasSubstr("backlash"));
  EXPECT_FALSE(Exists("axiscal.db"));
  const auto loop = Run("close-loop made");
  ASSERT_EQ(loop.exit_code, 0) << loop.err;
  EXPECT_THAT(loop.out, HasSubstr("EXX:backlash"));
  // And it is a case folder: poses.csv beside fit/ is no session.
  ASSERT_TRUE(Exists("made/poses.csv"));
  const auto upload = Run("upload made");
  ASSERT_EQ(upload.exit_code, 0) << upload.err;
  EXPECT_THAT(upload.out, HasSubstr("made/fit/00-BX.csv"));
  EXPECT_THAT(upload.err, HasSubstr("made/poses.csv"));
}

TEST_F(Simulate, TheSameSeedGivesTheSameBytes) {
  WriteScenario(R"("errors": {"EX0C": 25}, "effects": [{"kind": "curve", "symbol": "EYX", "rms": 4},
      {"kind": "thermal", "symbol": "EZT", "rms": 6, "channel": "temp_C", "tau_s": 900}],
      "temperatures": [{"rise_C": 4, "tau_s": 3000}], "faults": [{"kind": "gain", "gain_percent": 2}],
      "noise": {"ar1": 0.5, "bad_share": 0.01}, "sampling": {"kept_share": 0.7})");
  for (const char* const form : {"own", "independent"}) {
    const std::string options = std::string(" --form ") + form;
    ASSERT_EQ(Run("simulate scenario.json -o a-" + std::string(form) + options).exit_code, 0);
    ASSERT_EQ(Run("simulate scenario.json -o b-" + std::string(form) + options).exit_code, 0);
    ASSERT_EQ(Run("simulate scenario.json --seed 2 -o c-" + std::string(form) + options).exit_code, 0);
    EXPECT_EQ(AllOf("a-" + std::string(form)), AllOf("b-" + std::string(form)));
    EXPECT_NE(AllOf("a-" + std::string(form)), AllOf("c-" + std::string(form)));
  }
  EXPECT_NE(Read("a-own/truth.csv"), Read("a-independent/truth.csv"));
  EXPECT_FALSE(Exists("a-own/errors.json"));  // late warmth and instruments stand in truth.json alone
  EXPECT_THAT(Read("a-own/truth.csv"), HasSubstr("ex_um,ey_um,ez_um,ea_urad,eb_urad,ec_urad\n"));
  EXPECT_THAT(Read("a-own/poses.csv"), HasSubstr("t_s,Z_mm,Y_mm,X_mm,B_deg,C_deg,temp_C\n"));
  EXPECT_EQ(Run("close-loop a-independent --max-effects 1").exit_code, 0);
}

TEST_F(Simulate, PlansTestsOfTheMachine) {
  WriteScenario(R"("machine": ")" + Source("tests/data/loop/case-003/machine.json") + R"(", "errors": {"EX0C": 25})",
                R"("tests": ["CR-350", "CR-350"], "check_tests": ["ballbar-circle"], "tool_tip_mm": [0, 0, -350],
                    "table_ball_mm": [50, 0, 65], "travel_deg": {"B": [-90, 90]})");
  const auto outcome = Run("simulate scenario.json -o made --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto json = outcome.Json();
  ASSERT_EQ(json["sessions"].size(), 3u);
  EXPECT_EQ(json["sessions"][0]["session"], "CR-350");
  EXPECT_EQ(json["sessions"][1]["session"], "CR-350-2");
  EXPECT_EQ(json["is_all_in_errors"], true);
  EXPECT_NEAR(json["rms_um"].get<double>(), 25.0, 1e-6);
}

TEST_F(Simulate, WrongNominalDataAreWrittenNotTrue) {
  WriteScenario(R"("errors": {"EX0C": 25}, "nominal": [{"kind": "pivot", "axis": "B", "offset_mm": [0, 0, 0.5]}])");
  ASSERT_EQ(Run("simulate scenario.json -o made").exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(Read("made/machine.json"))["axes"]["B"]["point_mm"][2], 0.5);
  const auto truth = nlohmann::json::parse(Read("made/truth.json"));
  EXPECT_EQ(truth["errors"]["EX0C"], 25.0);
  EXPECT_FALSE(truth["is_all_in_errors"]);
  EXPECT_EQ(truth["scenario"]["nominal"][0]["kind"], "pivot");
}

TEST_F(Simulate, BadScenariosAreRefusedAndNothingIsWritten) {
  const auto refusal = [&](const std::string& members, const std::string& plan = "") {
    WriteScenario(members, plan);
    const auto outcome = Run("simulate scenario.json -o made");
    EXPECT_NE(outcome.exit_code, 0) << members;
    EXPECT_FALSE(Exists("made")) << members;
    return outcome.err;
  };
  EXPECT_EQ(refusal(R"("effects": [{"kind": "curve", "symbol": "EYX", "rms": -4}])"),
            "axiscal: scenario.json: effects[0].rms: -4, expected a number from 1e-06 to 10000\n");
  EXPECT_EQ(refusal(R"("effects": [{"kind": "curve", "symbol": "EYZ", "rms": 4, "length": 4}])")
                .find("axiscal: scenario.json: effects[0].length: unknown field"),
            0u);
  EXPECT_THAT(refusal(R"("faults": [{"kind": "ball", "rms_um": 1, "sessions": ["nobody"]}])"),
              HasSubstr("scenario.json: faults[0] (ball): the plan has no session 'nobody'"));
  // Micrometres in place of millimetres make readings that no session file holds.
  EXPECT_THAT(refusal(R"("errors": {"EX0C": 500}, "nominal": [{"kind": "unit", "column": "dL_mm", "factor": 1000}])"),
              HasSubstr("scenario.json: session 'BX': line"));
  EXPECT_THAT(refusal(R"("errors": {})", R"("case": "nowhere")"), HasSubstr("nowhere/machine.json"));
  EXPECT_THAT(refusal(R"("machine": ")" + Source("tests/data/loop/case-003/machine.json") + "\"",
                      R"("tests": ["nothing"], "travel_deg": {"B": [-90, 90]})"),
              HasSubstr("scenario.json: plan.tests: 'nothing' is no session that machine mt can run"));
  EXPECT_THAT(
      refusal(R"("machine": ")" + Source("tests/data/loop/case-003/machine.json") + "\"", R"("tests": ["CR-350"])"),
      HasSubstr("plan.travel_deg: the travel of B is not stated"));
  WriteScenario(R"("errors": {})");
  std::filesystem::create_directory(folder_ / "full");
  Write("full/mine.txt", "mine");
  const auto outcome = Run("simulate scenario.json -o full");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_EQ(outcome.err, "axiscal: full: is there and not empty, expected a new folder\n");
  EXPECT_EQ(Run("simulate scenario.json -o made --form other").exit_code, 2);
}

TEST_F(Simulate, AHistoryIsAFileOfLinesWithTheTruth) {
  const std::string options = " --history --machines 3 --years 2 --interval-days 14 --seed 11";
  const auto outcome = Run("simulate -o fleet.jsonl" + options);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("fleet.jsonl: seed 11, 3 machines, "));
  const std::string file = Read("fleet.jsonl");
  EXPECT_EQ(file.substr(0, file.find('\n')),
            R"({"axiscal": "history/1", "machines": 3, "years": 2, "interval_days": 14, "seed": 11})");
  for (const char* const machine : {"m00001", "m00002", "m00003"}) {
    EXPECT_THAT(file, HasSubstr("{\"machine\": \"" + std::string(machine) + "\", \"units\": {\"EC0Y\": \"urad\", "));
    EXPECT_THAT(file, HasSubstr("{\"machine\": \"" + std::string(machine) + "\", \"truth\": {\"sigma_factor\": "));
  }
  ASSERT_EQ(Run("simulate -o again.jsonl" + options).exit_code, 0);
  EXPECT_EQ(Read("again.jsonl"), file);
  EXPECT_FALSE(Exists("axiscal.db"));
}

TEST_F(Simulate, AHistoryIsRefusedWhole) {
  const auto refused = [&](const std::string& options, const std::string& what) {
    const auto outcome = Run("simulate -o refused.jsonl" + options);
    EXPECT_NE(outcome.exit_code, 0) << options;
    EXPECT_THAT(outcome.err, HasSubstr(what));
    EXPECT_FALSE(Exists("refused.jsonl")) << options;
  };
  refused(" --history --machines 0", "machines = 0, must be > 0");
  refused(" --history --years 60", "years = 60, must be 0.1 to 50");
  refused(" --history --interval-days 0", "interval_days = 0, must be 0.5 to 60");
  refused(" --history --machines 100000 --years 50", "must be at most 5e+06");
  refused(" --history scenario.json", "--history");
  refused(" --history --form own", "--history");
  refused(" --machines 3", "--history");
  refused("", "SCENARIO");
}

}  // namespace
}  // namespace axiscal
