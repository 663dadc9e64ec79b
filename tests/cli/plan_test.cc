// axiscal plan: on a machine.json without a database, and on a stored machine.
#include <gmock/gmock.h>

#include <set>

#include "absl/strings/str_cat.h"
#include "tests/cli/command_line.h"

namespace axiscal {
namespace {

using ::testing::HasSubstr;
using testing::Source;

class Plan : public testing::CommandLine {
 protected:
  static std::string Machine() {
    return " --machine '" + Source("tests/data/loop/case-000/machine.json") +
           "' --tool-tip '0 0 -350' --ball '50 0 65' --travel 'B -90 90' ";
  }
};

TEST_F(Plan, ListSaysRankTimeAndWhatIsNotSeparable) {
  const auto outcome = Run("plan --list --json --declare EX0C,EY0C,EA0C,EB0C" + Machine());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto json = outcome.Json();
  ASSERT_GT(json["tests"].size(), 30u);
  bool any_blind = false;
  for (const auto& test : json["tests"]) {
    EXPECT_LE(test["rank"].get<int>(), 4);
    EXPECT_EQ(test["rank"].get<int>() == 4, test["not_separable"].empty()) << test;
    any_blind |= !test["not_separable"].empty();
    EXPECT_GT(test["seconds"].get<double>(), 0.0);
  }
  EXPECT_TRUE(any_blind);
  EXPECT_FALSE(Exists("axiscal.db"));
}

TEST_F(Plan, ForProposesTestsWithExpectedUncertainty) {
  const auto outcome = Run("plan --json --for EX0C,EB0C" + Machine());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto json = outcome.Json();
  ASSERT_EQ(json["errors"].size(), 2u);
  EXPECT_EQ(json["errors"][0]["symbol"], "EX0C");
  EXPECT_TRUE(json["errors"][0]["identifiable"].get<bool>());
  EXPECT_GT(json["errors"][1]["sigma"].get<double>(), 0.0);
  EXPECT_GE(json["tests"].size(), 1u);
  EXPECT_EQ(Run("plan --json --for EX0C,EB0C" + Machine()).out, outcome.out);  // determined, not drawn
}

// Where the cubes' place is not known, the offsets of the head go with it; stated, they are told (Liu's errors).
TEST_F(Plan, ACertificateSaysWhatAPlanReaches) {
  const std::string certify = "plan --certify '" + Source("deploy/examples/liu-blocks/swivel-head/head.csv") +
                              "' --declare EX0B,EY0B,EA0B,EB0B,EC0B" + " --travel 'B -90 90' --machine '" +
                              Source("deploy/examples/liu-blocks/swivel-head/machine.json") + "' ";
  const auto outcome = Run(certify + "--json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto json = outcome.Json();
  ASSERT_EQ(json["errors"].size(), 5u);
  for (const auto& error : json["errors"]) EXPECT_TRUE(error["identifiable"].get<bool>()) << error;
  EXPECT_GT(json["tool_point"]["as_programmed"]["max_um"].get<double>(), 0.0);
  const auto known = Run(certify + "--setup 'artefact_x 0.1' --json");
  ASSERT_EQ(known.exit_code, 0) << known.err;
  EXPECT_LT(known.Json()["errors"][0]["sigma"].get<double>(), json["errors"][0]["sigma"].get<double>());
  const auto text = Run(certify + "--box 'X -200 200'");
  EXPECT_THAT(text.out, HasSubstr("corrected for what the plan finds"));
  EXPECT_EQ(Run(certify + "--setup 'bar_length 2'").exit_code, 3);
  EXPECT_EQ(Run(certify + "--setup 'artefact_x'").exit_code, 3);
  EXPECT_EQ(Run(certify + "--box 'Q 0 1'").exit_code, 3);
  EXPECT_EQ(Run("plan --certify nothing.csv" + Machine()).exit_code, 4);
  EXPECT_EQ(Run("plan --list --box 'X 0 1'" + Machine()).exit_code, 3);
}

TEST_F(Plan, TheFewestMinutesToAnUncertainty) {
  const auto outcome = Run("plan --json --with ballbar-pattern,rtest-grid --for EX0C=1,EB0C=20" + Machine());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_LE(outcome.Json()["errors"][0]["sigma"].get<double>(), 1.0);
  const auto never = Run("plan --with rtest-grid --for EX0C=0.000001" + Machine());
  EXPECT_THAT(never.out, HasSubstr("not within 0.000001: all known tests together reach"));
  EXPECT_EQ(Run("plan --for EX0C=-1" + Machine()).exit_code, 3);
}

TEST_F(Plan, UnknownErrorsTestsAndWaysAreRefused) {
  auto outcome = Run("plan --for EX0Q" + Machine());
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("EX0Q"));
  EXPECT_EQ(Run("plan --for EXX" + Machine()).exit_code, 3);
  outcome = Run("plan nothing -o a.nc" + Machine());
  EXPECT_EQ(outcome.exit_code, 4);
  EXPECT_THAT(outcome.err, HasSubstr("ballbar-circle"));
  EXPECT_EQ(Run("plan" + Machine()).exit_code, 3);
  EXPECT_EQ(Run("plan --list --for EX0C" + Machine()).exit_code, 3);
  EXPECT_EQ(Run("plan rtest-grid" + Machine()).exit_code, 3);  // no -o
  EXPECT_EQ(Run("plan rtest-grid -o a.nc --dialect okuma" + Machine()).exit_code, 3);
  outcome = Run("plan rtest-grid -o a.nc --ball '0 0 1e9' --machine '" +
                Source("tests/data/loop/case-000/machine.json") + "'");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("--ball '0 0 1e9': expected \"x y z\" in mm within +-100000"));
  EXPECT_FALSE(Exists("a.nc"));
}

TEST_F(Plan, WritesTablesAndPrograms) {
  const auto table = Run("plan CR-350 -o cr.csv" + Machine());
  ASSERT_EQ(table.exit_code, 0) << table.err;
  EXPECT_THAT(Read("cr.csv"), HasSubstr("# instrument: ballbar\n"));
  EXPECT_THAT(Read("cr.csv"), HasSubstr("\nt_s,X_mm,Y_mm,Z_mm,B_deg,C_deg\n"));
  const auto program = Run("plan CR-350 -o cr.nc --dialect sinumerik" + Machine());
  ASSERT_EQ(program.exit_code, 0) << program.err;
  EXPECT_THAT(Read("cr.nc"), HasSubstr("G93\n"));
  ASSERT_EQ(Run("plan sphere-probing -o probe.nc --dialect mazak --sphere-radius 20" + Machine()).exit_code, 0);
  EXPECT_THAT(Read("probe.nc"), HasSubstr("G31 "));
  ASSERT_EQ(Run("plan ballbar-linked -o xc.nc" + Machine()).exit_code, 0);
}

constexpr char kTrunnion[] = R"({"id": "tt", "axes": {
  "X": {"kind": "linear", "direction": [1, 0, 0]}, "Y": {"kind": "linear", "direction": [0, -1, 0]},
  "Z": {"kind": "linear", "direction": [0, 0, 1]},
  "A": {"kind": "rotary", "direction": [1, 0, 0], "point_mm": [0, 0, 0]TRAVEL},
  "C": {"kind": "rotary", "direction": [0, 0, 1], "point_mm": [0, 0, 0]}},
  "tool_branch": ["X", "Z"], "work_branch": ["Y", "A", "C"], "tool_direction": [0, 0, -1]})";

// Different positions of the columns `names` of a plan.
std::set<std::vector<double>> Positions(const std::string& csv, const std::vector<std::string>& names) {
  std::istringstream in(csv);
  std::set<std::vector<double>> positions;
  std::vector<std::string> columns;
  for (std::string line; std::getline(in, line);) {
    if (line[0] == '#') continue;
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    if (columns.empty()) {
      columns = cells;
      continue;
    }
    std::vector<double> position;
    for (const std::string& name : names)
      position.push_back(
          std::stod(cells.at(static_cast<size_t>(std::find(columns.begin(), columns.end(), name) - columns.begin()))));
    positions.insert(position);
  }
  return positions;
}

// A table that is tipped goes as far as its travel, one that is not stated is asked for, and what the text says of the
// poses is what the file has.
TEST_F(Plan, ATiltingTableKeepsToItsTravel) {
  std::string unknown = kTrunnion, stated = kTrunnion;
  unknown.replace(unknown.find("TRAVEL"), 6, "");
  stated.replace(stated.find("TRAVEL"), 6, R"(, "travel_deg": [-90, 0])");
  Write("unknown.json", unknown);
  Write("stated.json", stated);
  const std::string columns = "plan touch-columns -o columns.csv --ball '0 0 60' ";
  const auto asked = Run(columns + "--machine unknown.json");
  EXPECT_EQ(asked.exit_code, 3);
  EXPECT_THAT(asked.err, HasSubstr("the travel of A is not stated"));
  EXPECT_THAT(asked.err, HasSubstr("--travel \"A MIN MAX\""));
  EXPECT_FALSE(Exists("columns.csv"));
  const auto written = Run(columns + "--machine stated.json --json");
  ASSERT_EQ(written.exit_code, 0) << written.err;
  using Values = std::set<std::vector<double>>;
  EXPECT_EQ(Positions(Read("columns.csv"), {"A_deg"}), (Values{{-90}, {-60}, {-30}, {0}}));
  EXPECT_EQ(Positions(Read("columns.csv"), {"C_deg"}), (Values{{0}, {60}, {120}, {180}, {240}, {300}}));
  EXPECT_THAT(written.out, HasSubstr("at 24 poses of the rotary axes"));
  ASSERT_EQ(Run(columns + "--machine unknown.json --travel 'A -90 0' --json").out, written.out);
  // Tipped farther than upright, nobody reaches the table's face: such poses are neither in the file nor in the text.
  const auto tipped = Run(columns + "--machine unknown.json --travel 'A 60 170' --json");
  ASSERT_EQ(tipped.exit_code, 0) << tipped.err;
  const size_t poses = Positions(Read("columns.csv"), {"A_deg", "C_deg"}).size();
  EXPECT_THAT(tipped.out, HasSubstr(absl::StrCat("at ", poses, " poses of the rotary axes")));
  EXPECT_EQ(Run(columns + "--machine stated.json --travel 'A -90 0'").exit_code, 3);
  EXPECT_EQ(Run(columns + "--machine unknown.json --travel 'A 0 -90'").exit_code, 3);
  EXPECT_EQ(Run(columns + "--machine unknown.json --travel 'X 0 90'").exit_code, 3);
}

// Yao's machine has its table 490 mm from the pivot: all twelve patterns, in every dialect.
TEST_F(Plan, TheTwelvePatternsOfTheIntegrex) {
  const std::string options = " --machine '" + Source("deploy/examples/integrex/machine.json") +
                              "' --tool-tip '0 0 -356.4' --ball '-440 0 65.5' --bar 120 --travel 'B -90 90' -o p.nc "
                              "--dialect ";
  for (const char* pattern :
       {"BX", "BY", "BZ", "B-axial", "B-radial", "B-tangential", "CR", "CT", "CA", "CX", "CY", "CZ"}) {
    const auto outcome = Run(std::string("plan ") + pattern + "-356" + options + "mazak");
    EXPECT_EQ(outcome.exit_code, 0) << pattern << outcome.err;
  }
  EXPECT_THAT(Read("p.nc"), HasSubstr("G01 Z541.9000 Y0.0000 X-440.0000 B0.0000 C0.0000"));  // CZ: a bar above the ball
}

TEST_F(Plan, StoredMachines) {
  ASSERT_EQ(Run("machine add '" + Source("tests/data/loop/case-000/machine.json") + "'").exit_code, 0);
  const std::string id = Run("machine list --json").Json()["machines"][0]["id"].get<std::string>();
  const auto outcome =
      Run("plan --for EX0C --json --tool-tip '0 0 -350' --ball '50 0 65' --travel 'B -90 90' "
          "--machine " +
          id);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, Run("plan --for EX0C --json" + Machine()).out);
}

}  // namespace
}  // namespace axiscal
