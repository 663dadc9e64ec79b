// axiscal toolsetter: from files, and on stored sessions through the service.
#include <gmock/gmock.h>

#include "tests/cli/command_line.h"

namespace axiscal {
namespace {

using ::testing::HasSubstr;
using testing::Source;

class ToolSetter : public testing::CommandLine {
 protected:
  ToolSetter() {
    Write("machine.json", R"({"id": "cmx50u", "axes": {"Z": {"kind": "linear", "direction": [0, 0, 1]}},
        "tool_branch": ["Z"], "work_branch": [], "tool_direction": [0, 0, -1]})");
  }
  static std::string Example(const std::string& name) { return "'" + Source("deploy/examples/" + name) + "'"; }
};

TEST_F(ToolSetter, TriggerOfAFileAndOfOneRod) {
  const auto file = Run("toolsetter trigger --json " + Example("fang-tool-setter/tool-setter-misaligned-1.csv"));
  ASSERT_EQ(file.exit_code, 0) << file.err;
  EXPECT_NEAR(file.Json()["rods"][2]["trigger_height_mm"].get<double>(), 0.1119431440, 1e-9);
  const auto one =
      Run("toolsetter trigger --json --beam '0.2 0.6241 0.2836' --rod '5 0.03 88.041 144.086 179.822 0' "
          "--beam-sigma '0 0.1 0.05' --rod-sigma '0 0 0.002 0 0.001'");
  ASSERT_EQ(one.exit_code, 0) << one.err;
  EXPECT_NEAR(one.Json()["rods"][0]["trigger_height_mm"].get<double>(), 0.1119431440, 1e-9);
  EXPECT_GT(one.Json()["rods"][0]["sigma_um"].get<double>(), 4.0);  // 0.05 deg of pitch on 5 mm
}

TEST_F(ToolSetter, BadInputIsRefusedWithWhatWasExpected) {
  auto outcome = Run("toolsetter trigger --beam '0.2 0 0' --rod '5 0.03 -90 0 100 0'");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("phi = -90 deg, expected 45 to 90"));
  outcome = Run("toolsetter trigger --beam '0.2 0 0' --rod '0.05 0 90 0 100 0'");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("expected a thicker rod"));
  EXPECT_EQ(Run("toolsetter trigger --beam '0.2 0 0' --rod '5 0.03'").exit_code, 3);
  EXPECT_EQ(Run("toolsetter trigger").exit_code, 3);
  EXPECT_EQ(Run("toolsetter reference --fit roll " + Example("fang-tool-setter/tool-setter-aligned.csv")).exit_code, 3);
  EXPECT_EQ(Run("toolsetter reference nowhere.csv").exit_code, 4);
  outcome = Run("toolsetter wear " + Example("fang-tool-setter/tool-setter-aligned.csv"));
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("use reference"));
  outcome = Run("toolsetter curve --wear '0 6' " + Example("fang-round-insert/cutter.json"));
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("less than the insert's radius"));
  EXPECT_FALSE(Exists("axiscal.db"));
}

TEST_F(ToolSetter, CurveAsTableFileAndJson) {
  const auto outcome =
      Run("toolsetter curve --json --wear '0 0.005' -o curve.csv " + Example("fang-round-insert/cutter.json"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NEAR(outcome.Json()["highest_mm"].get<double>(), -0.001114, 2e-6);
  EXPECT_NEAR(outcome.Json()["inserts"][1]["fires_first_deg"].get<double>(), 120, 1.5);
  EXPECT_EQ(outcome.Json()["curve"].size(), 360u);
  EXPECT_THAT(Read("curve.csv"), HasSubstr("start_deg,Zt_mm,insert,turned_deg,um_per_deg\n0,"));
  const auto slow = Run("toolsetter curve --json --feed 10 " + Example("fang-round-insert/cutter.json"));
  EXPECT_NEAR(slow.Json()["lowest_mm"].get<double>(), -0.005531, 2e-6);
}

// The stored session gives what its file gives, and the job stays.
TEST_F(ToolSetter, StoredSessionsAreEvaluatedAsJobs) {
  ASSERT_EQ(Run("machine add machine.json").exit_code, 0);
  const auto upload = Run("upload " + Example("fang-tool-setter/tool-setter-misaligned-1.csv"));
  ASSERT_EQ(upload.exit_code, 0) << upload.err;
  const auto stored =
      Run("toolsetter reference --json --machine cmx50u --session tool-setter-misaligned-1 --fit pitch");
  ASSERT_EQ(stored.exit_code, 0) << stored.err;
  const auto file =
      Run("toolsetter reference --json --fit pitch " + Example("fang-tool-setter/tool-setter-misaligned-1.csv"));
  EXPECT_EQ(stored.Json(), file.Json());
  EXPECT_GT(file.Json()["reference_mm"]["sigma"].get<double>(), 0.0005);
  EXPECT_THAT(Run("jobs list").out, HasSubstr("tool_setter"));
  std::stringstream text;
  text << std::ifstream(Source("deploy/examples/fang-round-insert/twelve-readings.csv")).rdbuf();
  Write("mill.csv", text.str());
  ASSERT_EQ(Run("upload mill.csv").exit_code, 0);
  const auto wear = Run("toolsetter wear --json --machine cmx50u --session twelve-readings --report wear.json");
  ASSERT_EQ(wear.exit_code, 0) << wear.err;
  EXPECT_EQ(wear.Json(), Run("toolsetter wear --json mill.csv").Json());
  EXPECT_NEAR(wear.Json()["length_mm"].get<double>(), 176.641, 0.002);
  EXPECT_THAT(Read("wear.json"), HasSubstr("\"length_mm\""));
}

// What plan writes is a session once its readings are filled in.
TEST_F(ToolSetter, PlansAreFilledInAndEvaluated) {
  const std::string cutter = Example("fang-round-insert/cutter.json");
  const auto plan =
      Run("toolsetter plan " + cutter + " --starts 12 --machine cmx50u --session mill -o starts.csv --json");
  ASSERT_EQ(plan.exit_code, 0) << plan.err;
  EXPECT_NEAR(plan.Json()["expected"]["length_sigma_um"].get<double>(), 0.8, 0.4);
  EXPECT_NEAR(plan.Json()["unseen_from_um"].get<double>(), 15.0, 1e-9);
  EXPECT_EQ(Run("toolsetter wear starts.csv").exit_code, 3);  // nothing was measured yet
  const auto curve = Run("toolsetter curve --json --step 30 --wear '0 0.003' " + cutter).Json();
  std::istringstream in(Read("starts.csv"));
  std::string filled;
  size_t reading = 0;
  for (std::string line; std::getline(in, line);) {
    const bool is_reading = line.ends_with(",");
    if (is_reading) line += std::to_string(200.0 + curve["curve"][reading++]["Zt_mm"].get<double>());
    filled += line + "\n";
  }
  ASSERT_EQ(reading, 12u);
  Write("filled.csv", filled);
  const auto wear = Run("toolsetter wear --json filled.csv");
  ASSERT_EQ(wear.exit_code, 0) << wear.err;
  EXPECT_NEAR(wear.Json()["length_mm"].get<double>(), 200.0, 1e-5);
  const auto inserts = wear.Json()["inserts"];
  EXPECT_NEAR(std::max(inserts[0]["wear_um"].get<double>(), inserts[1]["wear_um"].get<double>()), 3.0, 0.01);

  const std::string rods = Example("fang-tool-setter/tool-setter-misaligned-1.csv");
  const auto three = Run("toolsetter plan --json -o rods.csv " + rods),
             turned = Run("toolsetter plan --json --turn rod-2 -o turned.csv " + rods);
  ASSERT_EQ(turned.exit_code, 0) << turned.err;
  EXPECT_LT(turned.Json()["expected"]["yaw"]["sigma"].get<double>(),
            0.1 * three.Json()["expected"]["yaw"]["sigma"].get<double>());
  EXPECT_THAT(Read("turned.csv"), HasSubstr("\n# rod rod-2@30: 5 0.03 88.041 144.086 179.822 30\n"));
  EXPECT_THAT(Read("turned.csv"), HasSubstr("\nrod-2@330,3,\n"));
  EXPECT_EQ(Run("toolsetter plan --turn rod-9 -o no.csv " + rods).exit_code, 3);
  EXPECT_EQ(Run("toolsetter plan --starts 3 --machine m -o no.csv " + cutter).exit_code, 3);
  EXPECT_THAT(Run("toolsetter plan -o no.csv " + cutter).err, HasSubstr("--machine"));
  EXPECT_EQ(Run("toolsetter plan -o no.csv missing.json").exit_code, 4);
  EXPECT_FALSE(Exists("no.csv"));
}

// The tests of the tool setter are tests of the machine too, by the same code.
TEST_F(ToolSetter, PlanKnowsBothTestsOfTheMachine) {
  const std::string cutter = Example("fang-round-insert/cutter.json"),
                    rods = Example("fang-tool-setter/tool-setter-misaligned-1.csv"),
                    plan = "plan --machine machine.json ";
  const auto list = Run(plan + "--list --json");
  ASSERT_EQ(list.exit_code, 0) << list.err;
  EXPECT_EQ(list.Json()["tool_setter"][1]["test"], "tool-curve");
  EXPECT_THAT(Run(plan + "--list").out, HasSubstr("tool-curve --tools FILE"));
  ASSERT_EQ(Run(plan + "tool-curve --tools " + cutter + " --starts 24 -o a.csv").exit_code, 0);
  ASSERT_EQ(Run("toolsetter plan " + cutter + " --starts 24 --machine cmx50u -o b.csv").exit_code, 0);
  EXPECT_EQ(Read("a.csv"), Read("b.csv"));
  ASSERT_EQ(Run(plan + "tool-setter --turn rod-2 -o c.csv --tools " + rods).exit_code, 0);
  ASSERT_EQ(Run("toolsetter plan --turn rod-2 -o d.csv " + rods).exit_code, 0);
  EXPECT_EQ(Read("c.csv"), Read("d.csv"));
  const auto message = [&](const std::string& arguments, int exit_code) {
    const auto outcome = Run("plan " + arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << arguments;
    return outcome.err;
  };
  EXPECT_THAT(message("--machine machine.json tool-curve -o no.csv", 3), HasSubstr("expected a cutter.json"));
  EXPECT_THAT(message("--machine machine.json tool-setter -o no.csv --tools " + cutter, 3),
              HasSubstr("expected a tool-setter session"));
  EXPECT_THAT(message("--machine machine.json tool-curve -o no.nc --tools " + cutter, 3),
              HasSubstr("the position of Z over the beam is not stated"));
  EXPECT_THAT(
      message("--machine machine.json tool-curve -o no.csv --session \"$(printf 'a\\nb')\" --tools " + cutter, 3),
      HasSubstr("--session: expected a name on one line"));
  EXPECT_THAT(message("--machine machine.json --list --tools " + cutter, 3), HasSubstr("tool-setter or tool-curve"));
  Write("other.json", R"({"id": "mill", "axes": {"X": {"kind": "linear", "direction": [1, 0, 0]}},
      "tool_branch": ["X"], "work_branch": [], "tool_direction": [0, 0, -1]})");
  EXPECT_THAT(message("--machine other.json tool-curve -o no.csv --tools " + cutter, 5),
              HasSubstr("no linear axis along its tool"));
  Write("mill.json", R"({"id": "mill", "axes": {"Z": {"kind": "linear", "direction": [0, 0, 1]}},
      "tool_branch": ["Z"], "work_branch": [], "tool_direction": [0, 0, -1]})");
  EXPECT_THAT(message("--machine mill.json tool-setter -o no.csv --tools " + rods, 3),
              HasSubstr("expected rods of machine mill"));
  EXPECT_FALSE(Exists("no.csv"));
}

TEST_F(ToolSetter, AJobOnAnotherInstrumentIsRefusedWhenItIsCreated) {
  ASSERT_EQ(Run("machine add machine.json").exit_code, 0);
  Write("bar.csv",
        "# machine: cmx50u\n# session: bar\n# instrument: ballbar\n# sigma_um: 1\n# tool_tip_mm: 0 0 0\n"
        "# table_ball_mm: 0 0 -100\n# bar_length_mm: 100\nt_s,Z_mm,dL_mm\n0,0,0\n");
  ASSERT_EQ(Run("upload bar.csv").exit_code, 0);
  const auto outcome = Run("toolsetter reference --machine cmx50u --session bar");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("must be of tool-setter or tool-curve"));
  EXPECT_THAT(Run("jobs list --json").out, ::testing::Not(HasSubstr("tool_setter")));
}

}  // namespace
}  // namespace axiscal
