#include "core/machine/machine_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/base/testing/source_path.h"
#include "core/base/units.h"
#include "core/machine/program_profile.h"

namespace axiscal::machine {
namespace {

using ::testing::HasSubstr;

constexpr char kMachine[] = R"({
 "id": "mt", "structure": "w-C'bZYXB(C1)-t", "note": "as delivered",
 "axes": {
  "C": {"kind": "rotary", "direction": [0, 0, 1], "point_mm": [-490, 0, 0]},
  "X": {"kind": "linear", "direction": [1, 0, 0], "travel_mm": [-600, 50.5]},
  "B": {"kind": "rotary", "direction": [0, 1, 0], "point_mm": [0, 0, 0], "travel_deg": [-30, 210]}
 },
 "tool_branch": ["X", "B"],
 "work_branch": ["C"],
 "tool_direction": [0, 0, -1],
 "declared": ["EA0B", "XOC", "EZ0T"]
})";

std::string With(const std::string& from, const std::string& to) {
  std::string text = kMachine;
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string Problem(const std::string& text) {
  const auto machine = MachineFromJson(text);
  EXPECT_EQ(machine.status().code(), absl::StatusCode::kInvalidArgument) << text;
  return std::string(machine.status().message());
}

TEST(MachineJson, AxesStandInTheOrderOfTheBranches) {
  const auto machine = MachineFromJson(kMachine);
  ASSERT_TRUE(machine.ok()) << machine.status();
  ASSERT_EQ(machine->axis_count(), 3);
  EXPECT_EQ(machine->axes[0].name, "X");
  EXPECT_EQ(machine->axes[1].name, "B");
  EXPECT_EQ(machine->axes[2].name, "C");
  EXPECT_EQ(machine->tool_branch, (std::vector<int>{0, 1}));
  EXPECT_EQ(machine->work_branch, (std::vector<int>{2}));
  EXPECT_EQ(machine->axes[2].point_mm, Eigen::Vector3d(-490, 0, 0));
  EXPECT_EQ(ToString(machine->declared[1]), "EX0C");
}

TEST(MachineJson, TravelIsInCoreUnits) {
  const auto machine = MachineFromJson(kMachine);
  ASSERT_TRUE(machine.ok());
  EXPECT_EQ(machine->axes[0].max_position, 50.5);
  EXPECT_EQ(machine->axes[1].min_position, -30 * base::kRadPerDeg);
  EXPECT_FALSE(machine->axes[2].max_position.has_value());
}

TEST(MachineJson, WritesWhatReadsBackEqual) {
  const auto machine = MachineFromJson(With("[0, 0, 1]", "[0, 0.6, 0.8]"));
  ASSERT_TRUE(machine.ok());
  const std::string text = MachineToJson(*machine);
  const auto again = MachineFromJson(text);
  ASSERT_TRUE(again.ok()) << again.status() << text;
  EXPECT_EQ(MachineToJson(*again), text);
  EXPECT_EQ(again->axes[1].min_position, machine->axes[1].min_position);
  EXPECT_EQ(again->axes[2].direction, machine->axes[2].direction);
  EXPECT_EQ(again->declared, machine->declared);
  EXPECT_EQ(again->structure, "w-C'bZYXB(C1)-t");
  EXPECT_THAT(text, HasSubstr(R"("X": {"kind": "linear", "direction": [1, 0, 0], "travel_mm": [-600, 50.5]})"));
}

TEST(MachineJson, SaysHowARotaryAxisCounts) {
  const std::pair<const char*, RollOver> kNames[] = {{"none", RollOver::kNone},
                                                     {"shortest", RollOver::kShortest},
                                                     {"sign", RollOver::kBySign},
                                                     {"difference", RollOver::kByDifference}};
  EXPECT_EQ(MachineFromJson(kMachine)->axes[2].roll_over, RollOver::kUnstated);
  EXPECT_EQ(MachineToJson(*MachineFromJson(kMachine)).find("roll_over"), std::string::npos);
  for (const auto& [name, roll_over] : kNames) {
    const auto machine =
        MachineFromJson(With(R"([-490, 0, 0])", absl::StrCat(R"([-490, 0, 0], "roll_over": ")", name, "\"")));
    ASSERT_TRUE(machine.ok()) << machine.status();
    EXPECT_EQ(machine->axes[2].roll_over, roll_over);
    EXPECT_EQ(MachineFromJson(MachineToJson(*machine))->axes[2].roll_over, roll_over);
  }
}

struct BadMachine {
  const char* from;
  const char* to;
  const char* message;
};

class MachineJsonRefuses : public ::testing::TestWithParam<BadMachine> {};

TEST_P(MachineJsonRefuses, NamingFieldValueAndRule) {
  EXPECT_THAT(Problem(With(GetParam().from, GetParam().to)), HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    Table, MachineJsonRefuses,
    ::testing::Values(
        BadMachine{R"("direction": [0, 1, 0])", R"("direction": [0, 2, 0])",
                   "axes.B.direction: [0,2,0], must have length 1"},
        BadMachine{R"("direction": [0, 1, 0])", R"("direction": [0, 1])",
                   "axes.B.direction: [0,1], expected [x, y, z], 3 numbers"},
        BadMachine{R"("direction": [0, 1, 0])", R"("direction": [0, "1", 0])",
                   R"(axes.B.direction: [0,"1",0], expected [x, y, z])"},
        BadMachine{R"("direction": [0, 1, 0])", R"("direction": [0, 1e999, 0])", "number overflow parsing '1e999'"},
        BadMachine{R"("kind": "linear")", R"("kind": "prismatic")",
                   R"(axes.X.kind: "prismatic", expected "linear" or "rotary")"},
        BadMachine{R"("kind": "linear", )", "", "axes.X.kind: is missing"},
        BadMachine{R"(, "point_mm": [0, 0, 0])", "", "axes.B.point_mm: is missing"},
        BadMachine{R"("point_mm": [0, 0, 0])", R"("point": [0, 0, 0])", "axes.B.point: unknown field"},
        BadMachine{R"("travel_mm": [-600, 50.5])", R"("point_mm": [1, 0, 0])",
                   "axes.X.point_mm: [1,0,0], a linear axis has no point"},
        BadMachine{R"("travel_mm": [-600, 50.5])", R"("travel_deg": [-6, 5])",
                   "axes.X.travel_deg: [-6,5], a linear axis has travel_mm"},
        BadMachine{R"("travel_deg": [-30, 210])", R"("travel_deg": [-30, 210], "roll_over": "shortest")",
                   "axes.B.roll_over: \"shortest\", an axis that rolls over has no travel limits"},
        BadMachine{R"("travel_deg": [-30, 210])", R"("roll_over": "modulo")",
                   "axes.B.roll_over: \"modulo\", expected \"none\", \"shortest\", \"sign\" or \"difference\""},
        BadMachine{R"("travel_mm": [-600, 50.5])", R"("roll_over": "none")",
                   "axes.X.roll_over: \"none\", only rotary axes"},
        BadMachine{R"("travel_deg": [-30, 210])", R"("travel_deg": [210, -30])",
                   "axes.B.travel_deg: [210,-30], the lower limit"},
        BadMachine{R"("tool_branch": ["X", "B"])", R"("tool_branch": ["X", "Q"])",
                   "tool_branch[1]: 'Q', expected the name of an axis"},
        BadMachine{R"("tool_branch": ["X", "B"])", R"("tool_branch": ["X"])", "axes.B: is in no branch"},
        BadMachine{R"("tool_branch": ["X", "B"])", R"("tool_branch": ["X", "B", "C"])",
                   "work_branch[0]: 'C', stands in a branch already"},
        BadMachine{R"("tool_branch": ["X", "B"],)", "", "tool_branch: is missing"},
        BadMachine{R"("tool_branch": ["X", "B"])", R"("tool_branch": "XB")", "tool_branch: \"XB\", expected a list"},
        BadMachine{R"("tool_direction": [0, 0, -1])", R"("tool_direction": [0, 0, 0])",
                   "tool_direction: [0,0,0], must have length 1"},
        BadMachine{R"("EA0B")", R"("EA0Q")", "declared[0]: 'EA0Q', the machine has no axis Q"},
        BadMachine{R"("EA0B")", R"("EX0C")", "declared[1]: 'XOC', is there twice"},
        BadMachine{R"("EA0B")", R"("EAB")", "declared[0]: 'EAB', must be a constant error"},
        BadMachine{R"("EA0B")", R"("FOO")", "declared[0]: 'FOO' is not an error symbol"},
        BadMachine{R"("EA0B")", "7", "declared[0]: 7, expected a text"},
        BadMachine{R"("id": "mt")", R"("id": "a b")", "id must be 1 to 100 letters"},
        BadMachine{R"("id": "mt")", R"("id": 5)", "id: 5, expected a text"},
        BadMachine{R"("id": "mt", )", "", "id: is missing"},
        BadMachine{R"("structure")", R"("struktur")", "struktur: unknown field, expected one of id, structure"},
        BadMachine{R"("structure")", R"("id")", "'id' is there twice"},
        BadMachine{R"("B": {)", R"("X": {)", "'X' is there twice"},
        BadMachine{R"("B": {)", R"("b": {)", "axes.b: expected a capital letter"},
        BadMachine{R"("B": {)", R"("T": {)", "axes.T: expected a capital letter other than T and W"},
        BadMachine{R"(["C"],)", R"(["C"])", "line 10, column"}));

// A description that was typed by hand is mended in one go, not by one field per try.
TEST(MachineJson, AllThatIsMissingOrWrongIsNamedAtOnce) {
  EXPECT_EQ(Problem("{}"),
            "5 fields are missing or wrong:\n  id: is missing\n  axes: is missing\n  tool_branch: is missing\n"
            "  work_branch: is missing\n  tool_direction: is missing");
  EXPECT_EQ(
      Problem(R"({"id": "a b", "axes": {
      "X": {"kind": "prismatic", "direction": [2, 0, 0], "travel_mm": [5, -5], "roll": 1},
      "B": {"kind": "rotary", "direction": [0, 1], "travel_mm": [0, 1], "roll_over": "modulo"},
      "C": {"kind": "rotary", "direction": [0, 0, 1], "point_mm": [0, 0, 2e6]}, "Y": 7},
      "tool_branch": ["X", "B", "Y"], "work_branch": ["C"], "tool_direction": [0, 0, 1, 0]})"),
      "12 fields are missing or wrong:\n"
      "  id: \"a b\", an id must be 1 to 100 letters, digits, '-', '_' or '.'\n"
      "  axes.X.roll: unknown field, expected one of kind, direction, point_mm, travel_mm, travel_deg, roll_over\n"
      "  axes.X.kind: \"prismatic\", expected \"linear\" or \"rotary\"\n"
      "  axes.X.direction: [2,0,0], must have length 1\n"
      "  axes.X.travel_mm: [5,-5], the lower limit must be below the upper one\n"
      "  axes.B.direction: [0,1], expected [x, y, z], 3 numbers\n"
      "  axes.B.point_mm: is missing, a rotary axis needs a point on it\n"
      "  axes.B.travel_mm: [0,1], a rotary axis has travel_deg\n"
      "  axes.B.roll_over: \"modulo\", expected \"none\", \"shortest\", \"sign\" or \"difference\"\n"
      "  axes.C.point_mm: [0,0,2000000.0], must be finite, at most 1e6 mm\n"
      "  axes.Y: 7, expected {\"kind\": ..., \"direction\": ...}\n"
      "  tool_direction: [0,0,1,0], expected [x, y, z], 3 numbers");
  EXPECT_EQ(Problem(With(R"("tool_branch": ["X", "B"],
 "work_branch": ["C"])",
                         R"("tool_branch": ["X", "Q", 5, "B"], "programs": {"unit": 5, "offsets": ["G54", 4]},
 "work_branch": ["C", "X"])")),
            "5 fields are missing or wrong:\n"
            "  tool_branch[1]: 'Q', expected the name of an axis in 'axes'\n"
            "  tool_branch[2]: 5, expected a text\n"
            "  work_branch[1]: 'X', stands in a branch already, expected each axis once\n"
            "  programs.unit: 5, expected a text\n"
            "  programs.offsets[1]: 4, expected a text");
  EXPECT_EQ(Problem(With(R"("EA0B", "XOC", "EZ0T")", R"("EA0Q", "EXX", "EZ0T", "EZ0T", 3)")),
            "4 fields are missing or wrong:\n"
            "  declared[0]: 'EA0Q', the machine has no axis Q\n"
            "  declared[1]: 'EXX', must be a constant error, written with a 0: EX0C\n"
            "  declared[3]: 'EZ0T', is there twice\n"
            "  declared[4]: 3, expected a text");
}

// What follows from another fault is no fault: axes of which some names are wrong stand in no branch, and whether a
// point is missing depends on the kind.
TEST(MachineJson, WhatOnlyFollowsIsNotNamed) {
  EXPECT_EQ(Problem(With(R"("tool_branch": ["X", "B"])", R"("tool_branch": ["X", "A"])")),
            "tool_branch[1]: 'A', expected the name of an axis in 'axes'");
  EXPECT_EQ(Problem(With(R"("kind": "rotary", "direction": [0, 1, 0], "point_mm": [0, 0, 0], )",
                         R"("direction": [0, 1, 0], )")),
            "axes.B.kind: is missing");
  EXPECT_EQ(Problem(With(R"("axes": {)", R"("axes": 7, "note2": {)")),
            "2 fields are missing or wrong:\n  note2: unknown field, expected one of id, structure, axes, tool_branch, "
            "work_branch, tool_direction, declared, note, source, programs\n"
            "  axes: 7, expected an object with a member for each axis");
}

// The wire carries no long errors.
TEST(MachineJson, OfManyFaultsTheFirstAreNamed) {
  std::string declared;
  for (int i = 0; i < 500; ++i) absl::StrAppend(&declared, i == 0 ? "" : ", ", i);
  const std::string problem = Problem(With(R"("EA0B", "XOC", "EZ0T")", declared));
  EXPECT_THAT(problem, HasSubstr("500 fields are missing or wrong:\n  declared[0]: 0, expected a text\n"));
  EXPECT_THAT(problem, ::testing::ContainsRegex("\n  and [0-9]+ more$"));
  EXPECT_LT(problem.size(), 2000u);
}

TEST(MachineJson, WhatIsNoObjectIsRefused) {
  EXPECT_EQ(Problem("[1, 2]"), "machine: [1,2], expected a JSON object");
  EXPECT_THAT(Problem(""), HasSubstr("is empty"));
  EXPECT_THAT(Problem(std::string("{\"id\": \"m\0\"}", 12)), HasSubstr("line 1"));
  EXPECT_THAT(Problem(R"({"id": "m", "axes": {}})"), HasSubstr("axes: {}, expected an object with a member"));
}

void ExpectEveryMachineLoads(const std::filesystem::path& folder, size_t at_least) {
  size_t count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const auto& path = entry.path();
    if (path.extension() != ".json" ||
        (path.filename() != "machine.json" && path.parent_path().filename() != "machines"))
      continue;
    std::stringstream text;
    text << std::ifstream(path).rdbuf();
    const auto machine = MachineFromJson(text.str());
    EXPECT_TRUE(machine.ok()) << path << ": " << machine.status();
    ++count;
  }
  EXPECT_GE(count, at_least);
}

TEST(MachineJson, SharedMachinesAndArmsLoad) {
  const std::filesystem::path shared = std::filesystem::path(base::SourcePath("")) / ".." / "shared" / "data";
  if (!std::filesystem::exists(shared)) GTEST_SKIP() << "../shared is absent";
  ExpectEveryMachineLoads(shared / "machines", 5);
  ExpectEveryMachineLoads(shared / "robots", 2);
}

// Placing the axes compares each with each: too many are refused before that.
TEST(MachineJson, TooManyAxesAreRefusedBeforeTheyAreRead) {
  std::string axes, names;
  for (int i = 1; i <= kMaxAxes + 1; ++i) {
    absl::StrAppend(&axes, i == 1 ? "" : ",", "\"A", i, "\": 0");  // no axis at all
    absl::StrAppend(&names, i == 1 ? "" : ",", "\"A", i, "\"");
  }
  const auto machine = MachineFromJson(absl::StrCat(R"({"id": "mt", "axes": {)", axes, R"(}, "tool_branch": [)", names,
                                                    R"(], "work_branch": [], "tool_direction": [0, 0, -1]})"));
  EXPECT_EQ(machine.status().message(), "axes: 15 axes, expected 1 to 14");
}

TEST(ProgramProfile, StandsInTheDescriptionAndLeavesTheRestOfIt) {
  EXPECT_EQ(*ProgramProfileFromJson(kMachine), ProgramProfile());
  ProgramProfile profile;
  profile.tool_tip = "0 0 -350";
  profile.dialect = "haas";
  profile.decimals = "3";
  profile.offsets = {"G54 X=-490 C=90", "G55=0 0 0 0 0"};
  profile.tool_lengths = {"H1=120.5"};
  const auto with = WithProgramProfile(kMachine, profile);
  ASSERT_TRUE(with.ok()) << with.status();
  EXPECT_EQ(*ProgramProfileFromJson(*with), profile);
  EXPECT_THAT(*with, HasSubstr("\n \"note\": \"as delivered\",\n"));
  EXPECT_EQ(MachineToJson(*MachineFromJson(*with)), MachineToJson(*MachineFromJson(kMachine)));
  // Anew, and none.
  profile.offsets.clear();
  profile.dialect = "fanuc";
  EXPECT_EQ(*ProgramProfileFromJson(*WithProgramProfile(*with, profile)), profile);
  EXPECT_EQ(WithProgramProfile(*with, {})->find("programs"), std::string::npos);
  EXPECT_FALSE(WithProgramProfile("{}", profile).ok());
}

TEST(ProgramProfile, WhatIsNoneIsRefused) {
  const auto refusal = [](const std::string& programs) {
    std::string text = kMachine;
    text.insert(text.find("\"note\""), "\"programs\": " + programs + ", ");
    return std::string(MachineFromJson(text).status().message());
  };
  EXPECT_THAT(refusal("[]"), HasSubstr("programs: [], expected an object"));
  EXPECT_THAT(refusal(R"({"unit": 5})"), HasSubstr("programs.unit: 5, expected a text"));
  EXPECT_THAT(refusal(R"({"offsets": "G54"})"), HasSubstr("programs.offsets: \"G54\", expected a list of texts"));
  EXPECT_THAT(refusal(R"({"units": "mm"})"), HasSubstr("programs.units: unknown field, expected one of tool_tip,"));
}

}  // namespace
}  // namespace axiscal::machine
