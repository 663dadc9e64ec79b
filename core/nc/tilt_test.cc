// Words that rotations, mirrors, scales and tilted planes turn.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/units.h"
#include "core/machine/chain.h"
#include "core/nc/plain_number.h"
#include "core/nc/testing/rewritten.h"
#include "core/nc/tilted_axes.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using testing::Outcome;
using testing::Rewritten;

const Eigen::Vector3d kGaugeMm(0, 0, 200.0 - testing::kToolMm);

RewriteOptions Options(const std::string& dialect = "fanuc") {
  RewriteOptions options = testing::From({});
  options.dialect = dialect;
  options.tool_lengths = {{1, 200.0}};
  options.work_offsets = {
      {dialect == "heidenhain" ? "PRESET" : "G54", {{"X", 100.0}, {"Y", -50.0}, {"Z", 30.0}}},
      {"G55", {{"X", 1.0}}},
  };
  return options;
}

// The head leans: X + 41.66 um at B = 0 and Z - 41.66 um at B = 90, as axes.
compensate::Compensator Leaning() {
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  return testing::MustCreate(machine, testing::ConstantErrors(machine, {{"EB0B", testing::kTiltRad}}), kGaugeMm);
}

std::string Text(const std::string& program, const RewriteOptions& options) {
  const Outcome outcome = Rewritten(program, options, Leaning());
  EXPECT_TRUE(outcome.status.ok()) << outcome.status << "\n" << program;
  return outcome.text;
}

void ExpectRefused(const std::string& dialect, const std::string& program, const std::string& reason) {
  const Outcome outcome = Rewritten(program, Options(dialect), Leaning());
  EXPECT_THAT(std::string(outcome.status.message()), HasSubstr(reason)) << program;
}

// UMC posts call the dynamic work offset, go above the part and take the tool's length behind that.
TEST(Tilt, RapidMovesInFrontOfTheToolLengthStayAndAreCorrectedWithIt) {
  EXPECT_EQ(Text("G90 G49\nG0 X0 Y0 Z50. B0 C0\nG254\nG0 X10. Y10.\nG43 H1 Z50.\nG1 Z1. F100\nG255\n", Options("haas")),
            "G90 G49\nG0 X0.0183 Y0 Z50. B0 C0\nG254\nG0 X10. Y10.\nG43 H1 Z50. X10.0417\nG1 Z1. F100\nG255\n");
  ExpectRefused("haas", "G90 G49\nG0 X0 Y0 Z50. B0 C0\nG254\nG0 X10. Y10.\nG1 Z50. F100\n",
                "no tool length is in force");
}

// Turned by 90 deg, words of X move the axis Y and words of Y the axis X backwards.
TEST(Tilt, RotatedWordsAreCorrectedAlongThemselves) {
  const std::string head = "G90 G0 G43 H1 Z50.\nG0 X0 Y0 Z50. B0 C0\n";
  const std::string done = "G90 G0 G43 H1 Z50.\nG0 X0.0417 Y0 Z50. B0 C0\n";
  EXPECT_EQ(Text(head + "G68 X5. Y5. R90.\nG0 X10. Y20.\nG1 Z1. F100\nG3 X20. Y30. R10.\nG69\nG0 X0 Y0\n", Options()),
            done + "G68 X5. Y5. R90.\nG0 X10. Y19.9583\nG1 Z1. F100\nG3 X20. Y29.9583 R10.\nG69\nG0 X0.0417 Y0\n");
  EXPECT_EQ(Text(head + "G51.1 X5.\nG0 X10. Y20.\nG1 Z1. F100\nG50.1 X0\nG0 X0\n", Options()),
            done + "G51.1 X5.\nG0 X9.9583 Y20.\nG1 Z1. F100\nG50.1 X0\nG0 X0.0417\n");
  EXPECT_EQ(Text(head + "G51 X0 Y0 Z0 P2.\nG0 X10. Y20. Z50.\nG50\nG0 X0 Y0 Z0\n", Options()),
            done + "G51 X0 Y0 Z0 P2.\nG0 X10.0208 Y20. Z50.\nG50\nG0 X0.0417 Y0 Z0\n");
  EXPECT_EQ(
      Text("G90 G54 D1\nG0 X0 Y0 Z50 B0 C0\nTRANS X10\nAROT RPL=90\nATRANS X5\nG0 X10 Y20\nG1 Z1 F100\nTRANS\nG0 X0 "
           "Y0\n",
           Options("sinumerik")),
      "G90 G54 D1\nG0 X0.0417 Y0 Z50 B0 C0\nTRANS X10\nAROT RPL=90\nATRANS X5\nG0 X10 Y19.9583\nG1 Z1 F100\nTRANS\n"
      "G0 X0.0417 Y0\n");
  EXPECT_EQ(Text("BEGIN PGM A MM\nTOOL CALL 1 Z S100\nL X+0 Y+0 Z+50 B+0 C+0 FMAX\nCYCL DEF 10.0 ROTATION\n"
                 "CYCL DEF 10.1 ROT+90\nL X+10 Y+20 FMAX\nL Z+1 F100\nCYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+0\n"
                 "CYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1 X\nL X+10 Y+20 FMAX\nEND PGM A MM\n",
                 Options("heidenhain")),
            "BEGIN PGM A MM\nTOOL CALL 1 Z S100\nL X+0.0417 Y+0 Z+50 B+0 C+0 FMAX\nCYCL DEF 10.0 ROTATION\n"
            "CYCL DEF 10.1 ROT+90\nL X+10 Y+19.9583 FMAX\nL Z+1 F100\nCYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+0\n"
            "CYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1 X\nL X+9.9583 Y+20 FMAX\nEND PGM A MM\n");
}

// A rule of 20 mm period: at the ends of the move alone the tool would be 5 um off between them.
TEST(Tilt, TheFirstMoveInATurnedFrameIsSplitAlongItsWay) {
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  machine::ErrorModel errors = testing::ConstantErrors(machine, {{"EY0X", 0.005}});
  errors.terms[0].shape = shapes::Harmonic{machine::FindAxis(machine, "X"), 2.0 * 3.14159265358979 / 20.0};
  const compensate::Compensator pitching = testing::MustCreate(machine, errors, kGaugeMm);
  const std::string head = "G90 G0 G43 H1 X0 Y0 Z50. B0 C0\n",
                    klartext = "TOOL CALL 1 Z S100\nL X+0 Y+0 Z+50 B+0 C+0 FMAX\n";
  const std::pair<const char*, std::string> programs[] = {
      {"fanuc", head + "G68 X5. Y5. R30.\nG1 X60. Y10. F100\nG69\nG1 X0 Y0\n"},
      {"fanuc", head + "G51 X5. Y5. Z0. P0.98\nG1 X60. Y10. Z50. F100\n"},
      {"sinumerik", "G90 G54 D1\nG0 X0 Y0 Z50 B0 C0\nAROT Z30\nATRANS X5\nG1 X60 Y10 F100\n"},
      {"heidenhain", klartext + "CYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1 X\nL X+60 Y+10 F100\n"},
  };
  for (const auto& [dialect, program] : programs) {
    RewriteOptions options = Options(dialect);
    options.tolerance_mm = 1e-3;
    const Outcome outcome = Rewritten(program, options, pitching);
    ASSERT_TRUE(outcome.status.ok()) << outcome.status << program;
    EXPECT_GE(outcome.report.blocks_split, 1) << outcome.text;
    VerifyOptions verify;
    verify.tool_tip_mm = kGaugeMm;
    verify.reading = options;
    const auto report = VerifyText(program, outcome.text, machine, errors, verify);
    ASSERT_TRUE(report.ok()) << report.status();
    EXPECT_GT(report->path_before.max_mm, 3.5e-3) << program;
    EXPECT_LT(report->path_after.max_mm, 1.2e-3) << outcome.text;
  }
}

// Whatever a datum shift does under a rotation: where it is back at zero, the rotation is what it was.
TEST(Tilt, BehindAShiftThatWentBackTheRotationGoesOn) {
  RewriteOptions options = Options("heidenhain");
  options.on_unsupported = OnUnsupported::kPass;
  const std::string begin =
      "BEGIN PGM A MM\nTOOL CALL 1 Z S100\nL X+0 Y+0 Z+50 B+0 C+0 FMAX\nCYCL DEF 10.1 ROT+90\nCYCL DEF 7.3 Y+3.74\n"
      "L X+1 Y+2 F100\n";
  const Outcome outcome =
      Rewritten(begin + "CYCL DEF 7.2 Y+0\nL X+10 Y+20 Z+50 B+0 C+0\nEND PGM A MM\n", options, Leaning());
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_THAT(outcome.text, HasSubstr("\nL X+1 Y+2 F100\n"));
  EXPECT_THAT(outcome.text, HasSubstr("\nL X+10 Y+19.9583 Z+50 B+0 C+0\n"));
}

// At B = 90 the plane's Z is the table's X; its X is the table's Y and its Y the table's Z, which the error moves.
TEST(Tilt, WordsOfATiltedPlaneAreCorrectedInIt) {
  const std::string fanuc = "G90\nG0 B90. C0\nG68.2 X0 Y0 Z0 I90. J90. K0\nG53.1\nG43 H1 Z30.\n";
  EXPECT_EQ(Text(fanuc + "G0 X10. Y20.\nG1 Z5. F100\nG2 X20. Y30. R10.\nG69\n", Options()),
            fanuc + "G0 X10. Y19.9583\nG1 Z5. F100\nG2 X20. Y29.9583 R10.\nG69\n");
  const std::string sinumerik = "G90 G54 D1\nG0 B90 C0\nCYCLE800(0,\"TC\",0,57,0,0,0,0,90,0,0,0,0,0)\n";
  // X of this plane points down, Y stays.
  EXPECT_EQ(Text(sinumerik + "G0 X10 Y20 Z30\nCYCLE800()\n", Options("sinumerik")),
            sinumerik + "G0 X10.0417 Y20 Z30\nCYCLE800()\n");
  // The status of ShopMill is a row of digits: the last one says whether the plane is new.
  const std::string shop = "G90 G54 D1\nG0 B90 C0\nCYCLE800(0,\"TC\",200000,57,0,0,0,0,90,0,0,0,0,0,100,1)\n";
  EXPECT_EQ(Text(shop + "G0 X10 Y20 Z30\n", Options("sinumerik")), shop + "G0 X10.0417 Y20 Z30\n");
  ExpectRefused("sinumerik", "G90 G54 D1\nG0 B90 C0\nCYCLE800(0,\"TC\",200001,57,0,0,0,0,90,0,0,0,0,0)\n",
                "adds to a plane");
  const std::string klartext =
      "BEGIN PGM A MM\nTOOL CALL 1 Z S100\nL B+0 C+0 FMAX\nPLANE SPATIAL SPA+0 SPB+90 SPC+0 TURN FMAX SEQ+\n";
  EXPECT_EQ(Text(klartext + "L X+10 Y+20 Z+30 FMAX\nPLANE RESET STAY\nEND PGM A MM\n", Options("heidenhain")),
            klartext + "L X+10.0417 Y+20 Z+30 FMAX\nPLANE RESET STAY\nEND PGM A MM\n");
  const std::string cycle =
      "BEGIN PGM A MM\nTOOL CALL 1 Z S100\nL B+0 C+0 FMAX\nCYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+0 B+90 C+0\n"
      "L B+90 C+0 FMAX\n";
  EXPECT_EQ(Text(cycle + "L X+10 Y+20 Z+30 FMAX\nCYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1\nEND PGM A MM\n",
                 Options("heidenhain")),
            cycle + "L X+10.0417 Y+20 Z+30 FMAX\nCYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1\nEND PGM A MM\n");
  // Words along the axes: at B = 90 the axis Z.
  const std::string haas = "G90 G0 G43 H1 Z50.\nG0 B90. C0\nG254\n";
  EXPECT_EQ(Text(haas + "G0 X10. Y20. Z30.\nG255\n", Options("haas")), haas + "G0 X10. Y20. Z29.9583\nG255\n");
}

TEST(Tilt, HolesAndVerifyStandInThePlane) {
  const std::string program =
      "G90\nG0 B90. C0\nG68.2 X1. Y2. Z3. I90. J90. K15.\nG53.1\nG43 H1 Z30.\nG0 X10. Y20.\nG98 G81 X11. Y21. Z-10. "
      "R2. "
      "F100\nX30.\nG80\nG1 X5. Y6. F100\nG69\n";
  const RewriteOptions options = Options();
  const Outcome outcome = Rewritten(program, options, Leaning());
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_NE(outcome.text, program);
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  VerifyOptions verify;
  verify.reading = options;
  verify.tool_tip_mm = kGaugeMm;
  const auto report = VerifyText(program, outcome.text, machine,
                                 testing::ConstantErrors(machine, {{"EB0B", testing::kTiltRad}}), verify);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_GT(report->end_before.max_mm, 0.04);
  EXPECT_LT(report->end_after.max_mm, 2e-4);  // words of four decimals
}

TEST(Tilt, WhatCannotBeProvedNamesWhatHelps) {
  // From B0 C0 to the plane by B90 C0 or B-90 C180: the first is nearer in both axes. From C90 neither is.
  ExpectRefused("fanuc", "G90\nG0 G43 H1 Z9.\nG0 B0 C90.\nG68.2 X0 Y0 Z0 I90. J90. K0\nG53.1\nG0 X0 Y0 Z0\n",
                "several positions of the rotary axes");
  ExpectRefused("fanuc", "G90\nG0 G43 H1 Z9.\nG0 B0 C0\nG68.2 X0 Y0 Z0 I90. J90. K0\nG0 X0 Y0 Z0\n", "upright");
  ExpectRefused("fanuc", "G90\nG0 B90. C0\nG68.2 X0 Y0 Z0 I90. J90. K0\nG53.1\nG1 X0 Y0 Z0 F100\n", "no tool length");
  ExpectRefused("fanuc", "G90\nG51 X0 Y0 Z0 P2000\nG0 X1.\n", "no point");
  ExpectRefused("fanuc", "G90\nG68 R30.\nG0 X1.\n", "all three words");
  ExpectRefused("fanuc", "G90\nG68 X0 Y0 R30.\nG55\nG0 X1.\n", "work offset");
  ExpectRefused("fanuc", "G90\n/G68 X0 Y0 R30.\nG0 X1.\n", "--block-delete");
  ExpectRefused("sinumerik", "G90 G54\nROT X30\nG0 X1\n", "away from the tool");
  ExpectRefused("sinumerik", "G90 G54 D1\nCYCLE800(0,\"TC\",0,57,0,0,0,0,90,0,0,0,0,-1)\nG0 X1\n", "several positions");
  ExpectRefused("heidenhain",
                "BEGIN PGM A MM\nTOOL CALL 1 Z S100\nPLANE SPATIAL SPA+0 SPB+90 SPC+0 STAY\nL B+Q121 C+Q122 FMAX\n",
                "travel limits in machine.json that leave one, or SEQ");
  ExpectRefused("heidenhain",
                "BEGIN PGM A MM\nTOOL CALL 1 Z S100\nL B+0 FMAX\nPLANE SPATIAL SPA+0 SPB+90 SPC+0 TURN FMAX\n",
                "since where C stood before is not known: program it in front, or state --start");
  ExpectRefused("haas", "G90\nG268 X0 Y0 Z0 I10. J10. K0\nG0 X1.\n", "more than one angle");
}

// What turns nothing back stops nothing. Without the tool the head leans by 18.3 um.
TEST(Tilt, EmptyFormsStopNothing) {
  EXPECT_EQ(Text("G90\nG69\nG50.1\nG0 X0 Y0 Z0 B0 C0\n", Options()), "G90\nG69\nG50.1\nG0 X0.0183 Y0 Z0 B0 C0\n");
  EXPECT_EQ(Text("G90 G54\nROT\nMIRROR\nSCALE\nTRANS\nG0 X0 Y0 Z0 B0 C0\n", Options("sinumerik")),
            "G90 G54\nROT\nMIRROR\nSCALE\nTRANS\nG0 X0.0183 Y0 Z0 B0 C0\n");
  EXPECT_EQ(Text("BEGIN PGM A MM\nTOOL CALL 1 Z S100\nPLANE RESET STAY\nCYCL DEF 19.0 WORKING PLANE\n"
                 "CYCL DEF 19.1 A+0 B+0 C+0\nL B+Q121 C+Q122 R0 FMAX\nCYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1\n"
                 "CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL 1\nL X+0 Y+0 Z+0 FMAX\nEND PGM A MM\n",
                 Options("heidenhain")),
            "BEGIN PGM A MM\nTOOL CALL 1 Z S100\nPLANE RESET STAY\nCYCL DEF 19.0 WORKING PLANE\n"
            "CYCL DEF 19.1 A+0 B+0 C+0\nL B+Q121 C+Q122 R0 FMAX\nCYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1\n"
            "CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL 1\nL X+0.0417 Y+0 Z+0 FMAX\nEND PGM A MM\n");
}

TEST(TiltedAxes, BothWaysBringTheToolThere) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const Eigen::Vector3d direction = Eigen::Vector3d(0.3, -0.4, -0.8).normalized();
  const std::vector<AxisAngles> ways = ToolAlong(machine, direction);
  ASSERT_EQ(ways.size(), 2u);
  for (const AxisAngles& way : ways) {
    const auto pose = machine::EvaluateChain<double>(machine, way.position_rad.data(), machine::JointErrors<double>());
    EXPECT_LT((machine::ToolDirectionInTable(machine, pose) - direction).norm(), 1e-12);
    EXPECT_EQ(way.free_axis, -1);
  }
  EXPECT_GE(ToolAlong(machine, machine.tool_direction).front().free_axis, 0);
  EXPECT_EQ(machine.axes[MasterAxis(machine)].name, "B");
}

TEST(PlainNumber, OneReaderForNumbersInText) {
  EXPECT_EQ(PlainTicks(" -20.5 ", kTicksPerMm), -205 * kTicksPerMm / 10);
  EXPECT_EQ(PlainTicks("+2", kTicksPerInch), 2 * kTicksPerInch);
  for (const char* const text : {"", "-", "2e3", "Q5", "1.2.3", "123456", "1 2", "+-1"})
    EXPECT_FALSE(PlainTicks(text, kTicksPerMm)) << text;
}

}  // namespace
}  // namespace axiscal::nc
