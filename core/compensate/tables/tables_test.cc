// What holds for tables of every format, and the formats without nodes of a controller's.
#include <gmock/gmock.h>

#include "core/compensate/tables/testing/made.h"
#include "core/compensate/tables/text.h"

namespace axiscal::tables {
namespace {

using testing::CorrectionOf;
using ::testing::HasSubstr;
using testing::kScale;
using testing::Made;
using testing::Make;
using ::testing::Not;
using testing::NotCarried;
using testing::Request;
using testing::WithTravel;

TEST(Text, NumbersHaveNoExponentAndNoNegativeZero) {
  EXPECT_EQ(Fixed(-0.00001, 3), "0.000");
  EXPECT_EQ(Fixed(-0.0, 0), "0");
  EXPECT_EQ(Fixed(1e-9, 4), "0.0000");
  EXPECT_EQ(Fixed(123456789.0, 1), "123456789.0");
  EXPECT_EQ(DecimalsOf(0.0005), 4);
  EXPECT_EQ(DecimalsOf(1.0), 0);
  for (const char* bad : {"", "-", "1e3", "nan", "inf", "0x1", "1 2", "1.2.3", "+-1", "1,5"})
    EXPECT_FALSE(ParseFixed(bad)) << bad;
  EXPECT_EQ(ParseFixed("+1.5"), 1.5);
}

TEST(MakeTable, WhatIsAskedForIsHeldAgainstMachineAndFormat) {
  const auto refused = [](const TableRequest& request, const std::string& text) {
    const Made made = Make(kScale, request);
    EXPECT_EQ(made.status.code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_THAT(std::string(made.status.message()), HasSubstr(text));
  };
  refused(Request("fanuk"), "format 'fanuk', expected one of general, linuxcnc-comp");
  refused(Request("linuxcnc-comp", {"Q"}), "axis 'Q', which machine 'tt' has not");
  refused(Request("linuxcnc-comp", {"X", "X"}), "axis: 'X' stands twice");
  refused(Request("linuxcnc-comp", {"X", "Y"}), "holds one axis");
  refused(Request("linuxcnc-comp", {"Y(X)"}), "over its own position only");
  TableRequest request = Request("linuxcnc-comp", {"X"});
  request.ranges = {{"X", 100, -100}};
  refused(request, "range: X from 100 mm to -100 mm");
  request.ranges = {{"X", -100, std::nan("")}};
  refused(request, "range: X from -100 mm to nan mm");
  request.ranges = {{"X", -400, 100}};
  refused(request, "beyond the travel");
  request.ranges = {{"X", -100, 100}, {"X", -100, 100}};
  refused(request, "range: X stands twice");
  request.ranges = {{"X", -100, 100}};
  request.reference = {{"X", 150}};
  refused(request, "reference: X = 150 mm, must lie in the axis' range");
  request.reference = {};
  request.max_points = 257;
  refused(request, "points = 257, linuxcnc-comp takes 2 to 256");
  request.max_points = 1;
  refused(request, "points = 1");
  request.max_points.reset();
  request.tolerance_mm = 0;
  refused(request, "tolerance = 0 um");
  request.tolerance_mm = 1e-4;
  request.state.temperature_celsius = std::nan("");
  refused(request, "temperature = nan C, must be finite");
  request.state.temperature_celsius.reset();
  request.resolution = 0.001;
  refused(request, "resolution: that of linuxcnc-comp is fixed");
}

TEST(MakeTable, AnAxisWithoutTravelNeedsARange) {
  const machine::Machine machine = machine::testing::TiltingTable();
  EXPECT_THAT(std::string(Make(machine, kScale, Request("linuxcnc-comp", {"X"})).status.message()),
              HasSubstr("range: axis X has none: state it (X=MIN:MAX in mm), or travel_mm in machine.json"));
  const Made made = Make(machine, kScale, Request("linuxcnc-comp"));
  EXPECT_EQ(made.status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(made.status.message()), HasSubstr("without a range"));
}

TEST(MakeTable, WhatTheTableLeavesIsWhatThePosesSay) {
  const Made made = Make(kScale, Request("linuxcnc-comp"));
  ASSERT_TRUE(made.status.ok()) << made.status;
  const auto& error = made.report["tool_point_error"];
  EXPECT_NEAR(error["along_axes"]["before"]["max_um"].get<double>(), 3.0, 0.01);  // 10 um/m over 300 mm
  EXPECT_LT(error["along_axes"]["after"]["max_um"].get<double>(), 0.02);          // 0.01 um steps
  EXPECT_NEAR(error["within_ranges"]["before"]["max_um"].get<double>(), 3.0, 0.02);
  EXPECT_LT(error["within_ranges"]["after"]["max_um"].get<double>(), 0.02);
  EXPECT_TRUE(made.report["not_carried"].empty()) << NotCarried(made);
}

TEST(MakeTable, WhatIsNotCarriedIsListed) {
  const Made made = Make(R"({"EX0C": 53.1, "EA0A": 120, "terms": [
      {"symbol": "EXX", "shape": "linear", "amplitude": 10},
      {"symbol": "EYX", "shape": "quadratic", "amplitude": 4},
      {"symbol": "EZT", "shape": "thermal", "amplitude": 3},
      {"symbol": "EZT", "shape": "drift", "amplitude": 3}]})",
                         Request("linuxcnc-comp", {"X"}));
  ASSERT_TRUE(made.status.ok()) << made.status;
  EXPECT_THAT(NotCarried(made), HasSubstr("EYX:quadratic: "));
  EXPECT_THAT(NotCarried(made), HasSubstr("EZT:thermal: no temperature is stated"));
  EXPECT_THAT(NotCarried(made), HasSubstr("EZT:drift: no time is stated"));
  EXPECT_THAT(NotCarried(made), HasSubstr("X is off by -53.10 um at the reference"));
  EXPECT_THAT(NotCarried(made), HasSubstr("orientation: the tool stays tilted against the table by up to 120.0 urad"));
  EXPECT_THAT(NotCarried(made), Not(HasSubstr("EXX:linear")));
  EXPECT_THAT(made.text, HasSubstr("not carried: EYX:quadratic"));
}

// X errs by -10 um/m at the reference's height, by +10 um/m where the work is: a table for the reference doubles it.
TEST(MakeTable, ATableThatMakesItWorseIsNotHandedOut) {
  TableRequest request = Request("linuxcnc-comp", {"X"});
  request.ranges = {{"Z", 100, 300}};
  request.reference = {{"Z", 100}};
  const char* const errors = R"({"terms": [{"symbol": "EXX", "shape": "linear", "amplitude": -30},
      {"symbol": "EBX", "shape": "linear", "variable": "X", "amplitude": 150}]})";
  const Made worse = Make(errors, request);
  EXPECT_EQ(worse.status.code(), absl::StatusCode::kFailedPrecondition) << worse.text;
  EXPECT_THAT(std::string(worse.status.message()), HasSubstr("the table would make the tool point worse: "));
  EXPECT_THAT(std::string(worse.status.message()),
              HasSubstr("Its values hold for one position of Z, Y, A, C. Narrow the ranges"));
  request.reference = {{"Z", 200}};
  EXPECT_TRUE(Make(errors, request).status.ok());
}

// A tilt of C turns with A: the grid of A = 0 is wrong for it elsewhere, though the machine is better with the grid.
TEST(MakeTable, ATermThatATableMakesWorseIsSaidToBe) {
  TableRequest request = Request("fanuc-3d");
  const Made made =
      Make(R"({"EB0C": 60, "EC0Y": 200, "terms": [{"symbol": "EXX", "shape": "linear", "amplitude": 90}]})", request);
  ASSERT_TRUE(made.status.ok()) << made.status;
  EXPECT_THAT(NotCarried(made), HasSubstr("EB0C: alone it would be worse with the table, "));
  EXPECT_THAT(NotCarried(made), HasSubstr("it turns with axes that the table is not over"));
  EXPECT_THAT(made.text, HasSubstr("(assumed: the layout of the data lines"));
  const auto& within = made.report["tool_point_error"]["within_ranges"];
  EXPECT_LT(within["after"]["rms_um"].get<double>(), within["before"]["rms_um"].get<double>());
}

TEST(General, ErrorsKeepTheirNamesSignsAndUnits) {
  const Made made = Make(R"({"EC0Y": -20.5, "EX0C": 53.1, "terms": [
      {"symbol": "EXX", "shape": "linear", "amplitude": 10}, {"symbol": "EXX", "shape": "backlash", "amplitude": 3},
      {"symbol": "EAX", "shape": "linear", "amplitude": 40},
      {"symbol": "ECC", "shape": "harmonic", "order": 4, "amplitude": 30, "phase_deg": 0}]})",
                         Request("general"));
  ASSERT_TRUE(made.status.ok()) << made.status;
  EXPECT_THAT(made.text, HasSubstr("# block: constant\nEC0Y_urad,EX0C_um\n-20.500,53.100\n"));
  EXPECT_THAT(made.text, HasSubstr("# block: X\nX_mm,sense,EXX_um,EAX_urad\n-300.0000,1,-1.500,-12.000\n"
                                   "-300.0000,-1,-4.500,-12.000\n"));
  EXPECT_THAT(made.text, HasSubstr("# block: C\nC_deg,ECC_urad\n0.0000,30."));
  EXPECT_EQ(made.table.blocks.size(), 3u);
  // Error +10 um/m at X 200 in the forward sense: +2 + 1.5 um; the controller commands that much less. C of the table
  // beside it: X moved by 53.1 um.
  EXPECT_NEAR(CorrectionOf(WithTravel(), made.table, "X", {{"X", 200}}, 1.0) -
                  CorrectionOf(WithTravel(), made.table, "X", {{"X", 0}}, 1.0),
              -0.002, 1e-5);
}

// Location errors have no argument, and yet act along the axes.
TEST(General, ConstantsAreJudgedAlongEveryAxis) {
  const Made made = Make(R"({"EX0C": 50})", Request("general"));
  ASSERT_TRUE(made.status.ok()) << made.status;
  EXPECT_NEAR(made.report["tool_point_error"]["along_axes"]["before"]["max_um"].get<double>(), 100.0, 0.1);  // C at 180
  EXPECT_LT(made.report["tool_point_error"]["along_axes"]["after"]["max_um"].get<double>(), 0.01);
}

TEST(General, AxesNamedTogetherAreArgumentsOfOneBlock) {
  const char* const errors = R"({"terms": [{"symbol": "EXX", "shape": "linear", "amplitude": 10},
      {"symbol": "EXX", "shape": "backlash", "amplitude": 3},
      {"symbol": "EXX", "shape": "linear", "variable": "C", "amplitude": 2},
      {"symbol": "EZC", "shape": "harmonic", "order": 2, "amplitude": 5, "phase_deg": 0}]})";
  const Made made = Make(errors, Request("general", {"X", "C"}));
  ASSERT_TRUE(made.status.ok()) << made.status;
  EXPECT_THAT(made.text, HasSubstr("# block: X C\nX_mm,C_deg,sense,EXX_um,EZC_um\n-300.0000,0.0000,1,-1.500,5."));
  EXPECT_LT(made.report["tables"][0]["left_max"].get<double>(), 0.15);
  EXPECT_LT(made.report["tool_point_error"]["within_ranges"]["after"]["max_um"].get<double>(), 0.3);
  EXPECT_THAT(std::string(Make(errors, Request("general", {"C", "X"})).status.message()),
              HasSubstr("depend on its sense of motion: name it first"));
  EXPECT_THAT(std::string(Make(errors, Request("general", {"X", "X"})).status.message()), HasSubstr("stands twice"));
}

TEST(General, BadTablesAreNamedByLine) {
  const auto refused = [](const std::string& text, const std::string& message) {
    const auto table = GeneralFormat().read(WithTravel(), text);
    EXPECT_EQ(table.status().code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_THAT(std::string(table.status().message()), HasSubstr(message)) << text;
  };
  refused("# block: X\nX_mm,EXX_urad\n0,1\n", "line 2: 'EXX_urad', expected 'EXX_um'");
  refused("# block: X\nX_deg,EXX_um\n0,1\n", "line 2: 'X_deg'");
  refused("# block: X\nX_mm,EXX_um\n0,1\n0,2\n", "no whole grid");
  refused("# block: X\nX_mm,EXX_um\n1,1\n0,2\n", "no whole grid");
  refused("# block: X\nX_mm,EXX_um\n0,1e-3\n", "line 3: '1e-3', expected a decimal number");
  refused("# block: X\nX_mm,EXX_um\n0\n", "line 3: '0', expected 2 cells");
  refused("# block: X\nX_mm,EXX_um\n", "the block ends too early");
  refused("# block: X\nX_mm,sense,EXX_um\n0,1,1\n", "the block ends too early");
  refused("# block: X\nX_mm,sense,EXX_um\n0,2,1\n", "line 3: '2', expected 1");
  refused("# block: X\nX_mm,EXX_um,EXX_um\n0,1,2\n", "expected every column once");
  refused("# block: X\nX_mm,EX0X_um\n0,1\n", "names with 0");
  refused("# block: X\nX_mm\n0\n", "at least one error");
  refused("# block: X\nQ_mm,EXX_um\n0,1\n", "line 2: 'Q_mm'");
}

// Any axis positions as arguments: two axes make a grid.
TEST(General, TwoArgumentsAreInterpolatedBetweenFourRows) {
  const auto table = GeneralFormat().read(WithTravel(), "X_mm,C_deg,EZX_um\n0,0,0\n100,0,10\n0,90,20\n100,90,50\n");
  ASSERT_TRUE(table.ok()) << table.status();
  compensate::Pose pose;
  pose.position[machine::FindAxis(WithTravel(), "X")] = 50;
  pose.position[machine::FindAxis(WithTravel(), "C")] = 45 * base::kRadPerDeg;
  EXPECT_NEAR(ValueAt(table->blocks[0], table->blocks[0].columns[0], pose), 0.020, 1e-12);
}

}  // namespace
}  // namespace axiscal::tables
