// Blocks that are passed: which modes stay in force behind them, dialect by dialect.
#include <gmock/gmock.h>

#include "core/base/units.h"
#include "core/nc/testing/rewritten.h"

namespace axiscal::nc {
namespace {

using testing::kAtZero;
using testing::Outcome;
using testing::Rewritten;

RewriteOptions PassingIn(const std::string& dialect) {
  RewriteOptions options = kAtZero;
  options.dialect = dialect;
  options.on_unsupported = OnUnsupported::kPass;
  options.tool_lengths = {{1, 0.0}, {2, 10.0}};
  options.work_offsets = {{"G54", {}}};
  return options;
}

// Whether a move that states everything is corrected behind `blocks`.
bool IsCorrectedBehind(const std::string& dialect, const std::string& blocks) {
  const bool is_klartext = dialect == "heidenhain";
  // Behind calls the unit is to be stated again; the cases with G20 are about the unit.
  const std::string unit = blocks.find("G20") != std::string::npos ? "" : dialect == "sinumerik" ? "G71 " : "G21 ";
  const std::string move = is_klartext ? "L X+5. Y+0 Z+0 B+0 C+0 R0 F500" : unit + "G1 X5. Y0. Z0. B0. C0.";
  Outcome outcome;
  const auto text =
      RewriteText((is_klartext ? "" : "G90 G94 G17\n") + blocks + "\n" + move + "\n", testing::LeaningHead(),
                  PassingIn(dialect), &outcome.report);
  EXPECT_TRUE(text.ok()) << text.status() << blocks;
  return text.ok() && text->find("5.0417") != std::string::npos;
}

struct Case {
  const char* dialect;
  const char* blocks;
};

// The block that brings the control back to the programmed position needs an F, and to know whether G00 is in force.
TEST(Passed, TheWayBackIsRefusedWhereItsFeedIsNotKnown) {
  const auto status_of = [](const std::string& blocks, BlockDelete block_delete) {
    RewriteOptions options = PassingIn("linuxcnc");
    options.block_delete = block_delete;
    RewriteReport report;
    return RewriteText("G21 G90 G17\n" + blocks, testing::LeaningHead(), options, &report).status();
  };
  const std::string feedless = "G93 G1 X5. F10.\nG94\nG81 X9. Z-1. R2.\n";
  EXPECT_THAT(std::string(status_of(feedless, BlockDelete::kExecuted).message()), ::testing::HasSubstr("no F"));
  EXPECT_TRUE(status_of("G93 G1 X5. F10.\nG94 F100.\nG81 X9. Z-1. R2.\n", BlockDelete::kExecuted).ok());
  EXPECT_TRUE(status_of("G93 G1 X5. F10.\nG94\nX6. F100.\nX7.\nG81 X9. Z-1. R2.\n", BlockDelete::kExecuted).ok());
  EXPECT_TRUE(status_of("G93 G1 X5. F10.\nG94\nG0 X7.\nG81 X9. Z-1. R2.\n", BlockDelete::kExecuted).ok());
  const std::string skipped = "G0 X1.\n/G1 X5. F100.\nX6. Y0. Z0. B0. C0.\nG81 X9. Z-1. R2.\n";
  EXPECT_THAT(std::string(status_of(skipped, BlockDelete::kEither).message()), ::testing::HasSubstr("in G00 or not"));
  EXPECT_TRUE(status_of(skipped, BlockDelete::kExecuted).ok());
  EXPECT_TRUE(status_of(skipped, BlockDelete::kSkipped).ok());
}

// What begins a mode, and codes that end others.
TEST(Passed, AModeStaysUntilItsOwnCodeEndsIt) {
  const Case kStay[] = {
      {"fanuc", "G43.5 H1"},
      {"fanuc", "G43.5 H1\nH1"},
      {"fanuc", "G43.4 H1\nT2 M6"},
      {"fanuc", "G43.4 H1\nM98 P5\nG90 G54 G94 G17 G21"},
      {"fanuc", "/G43.4 H1"},
      {"fanuc", "G43.5 H1\nG43 H1"},
      {"fanuc", "G43.4 H1\nG44 H1"},
      {"fanuc", "G43.4\nH0"},
      {"haas", "G234 H1\nG43 H1"},
      {"haas", "G234\nG43 H1"},
      {"haas", "G143 H1"},
      {"linuxcnc", "M428\nG49"},
      {"linuxcnc", "M428\nG43 H1"},
      {"linuxcnc", "M430\nG49"},
      {"linuxcnc", "G43.1 Z5\nG43 H1"},
      {"sinumerik", "TRAORI(2)\nD1"},
      {"sinumerik", "TCARR=1\nTRAFOOF"},
      {"heidenhain", "TOOL CALL 1 Z\nM128\nTOOL CALL 1 Z"},
      {"heidenhain", "L Z+5 M128\nL Z+6 M145"},
      {"heidenhain", "L Z+5 M144\nL Z+6 M129"},
      {"heidenhain", "L Z+5 M114\nL Z+6 M129"},
      {"heidenhain", "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS\nL Z+5 M129"},
      {"heidenhain", "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+Q1\nPLANE RESET STAY"},
      {"sinumerik", "TRAORI\nTRAFOOF"},
      {"haas", "G268 X0 Y0 Z0 I30\nG69"},
      {"haas", "G68 R30.\nG269"},
      {"haas", "G254\nG92 A5.\nG255"},
      {"fanuc", "G68.5\nG69"},
      {"fanuc", "G68 R30.\nG69.1"},
      {"fanuc", "G12.1\nG15"},
      {"fanuc", "G16\nG13.1"},
      {"fanuc", "G41.1 D1\nG40"},
      {"fanuc", "G51.1 X0 Y0\nG50.1 X0"},
      {"fanuc", "G51.1 X#1\nG50.1 X0"},
      {"haas", "G101 X0 Y0\nG100 Y0"},
      {"fanuc", "G66 P1 A1.\nG66 P2 A1.\nG67\nG90 G94 G17 G54 G49"},
      {"fanuc", "G66 P1 A1.\nG67"},
      {"fanuc", "G51 X0 Y0 P2000\nG50 X5."},
      {"fanuc", "G999\nG90 G54 G49 G94 G17"},
  };
  for (const Case& known : kStay)
    EXPECT_FALSE(IsCorrectedBehind(known.dialect, known.blocks)) << known.dialect << ": " << known.blocks;
  const Case kEnd[] = {
      {"fanuc", "G43.4 H1\nG49"},
      {"haas", "G234 H1\nG49"},
      {"linuxcnc", "G43.1 Z5\nG49"},
      {"sinumerik", "TRAORI\nTRAFOOF\nG54"},
      {"sinumerik", "TRANSMIT\nTRAFOOF"},
      {"sinumerik", "G111 X5 Y5"},
      {"heidenhain", "L Z+5 M128\nL Z+6 M129"},
      {"heidenhain", "L Z+5 M144\nL Z+6 M145"},
      {"heidenhain", "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS\nFUNCTION RESET TCPM"},
      {"heidenhain", "PLANE SPATIAL SPA+0 SPB+45 SPC+0 STAY\nPLANE RESET STAY"},
      {"heidenhain", "PLANE SPATIAL SPA+0 SPB+45 SPC+0 STAY\nPLANE RESET TURN FMAX"},
      {"heidenhain", "CYCL DEF 19.0 WORKING PLANE\nPLANE RESET STAY"},
      {"haas", "G268 X0 Y0 Z0 I30\nG269"},
      {"haas", "G68 X0 Y0 R30.\nG69"},
      {"haas", "G254\nG255"},
      {"fanuc", "G68 X0 Y0 R30.\nG69"},
      {"fanuc", "G12.1\nG13.1"},
      {"fanuc", "G16\nG15"},
      {"fanuc", "G41.1 D1\nG40.1"},
      {"fanuc", "G51.1 X0 Y0\nG50.1 X0\nG50.1 Y0"},
      {"fanuc", "G51.1 X0 Y0\nG50.1"},
      {"fanuc", "G66 P1 A1.\nG67\nG90 G94 G17 G54 G49"},
      {"fanuc", "G51 X0 Y0 P2000\nG50"},
  };
  for (const Case& known : kEnd)
    EXPECT_TRUE(IsCorrectedBehind(known.dialect, known.blocks)) << known.dialect << ": " << known.blocks;
}

TEST(Passed, WhatWritesOffsetsOrLengthsForgetsThoseStated) {
  for (const Case& known : {Case{"fanuc", "G10 L2 P0 X100."}, {"fanuc", "G10 L2 P0 X100.\nG54"},
                            {"fanuc", "#5221=100."}, {"fanuc", "#5221 = #1\nG54 G49"},
                            {"haas", "#[5221]=100.\nG54 G49"},
                            {"fanuc", "N1 /G10 L2 P1 X5.\nG54 G49 G90 G17 G21 G94 G1"},
                            {"fanuc", "G43 H1 Z5.\nG10 L11 P1 R5."}, {"linuxcnc", "G10 L2 P1 X100 R5\nG54 G49"},
                            {"sinumerik", "$P_UIFR[1,X,TR]=100\nG54 D1 G71 G17 G90 G94"}})
    EXPECT_FALSE(IsCorrectedBehind(known.dialect, known.blocks)) << known.blocks;
  for (const Case& known : {Case{"fanuc", "#1=#5221"}, {"fanuc", "#1=#[#2]"}, {"fanuc", "#3006=1"}})
    EXPECT_TRUE(IsCorrectedBehind(known.dialect, known.blocks)) << known.blocks;
}

// Numbers that are not read select, shift and set all the same.
TEST(Passed, WhatABlockDoesWhoseNumbersAreNotReadIsNotKnown) {
  for (const Case& known : {Case{"fanuc", "G54\nG54.1 P#1\nG90"},
                            {"fanuc", "G54 P#1"},
                            {"fanuc", "G54.1"},
                            {"fanuc", "G43 H1 Z5.\nG43 H#2"},
                            {"fanuc", "G43 H1 Z5.\nH#2"},
                            {"fanuc", "G43 H1 Z5.\nX#1 H2"},
                            {"fanuc", "G52 X#1"},
                            {"fanuc", "G92 X#1"},
                            {"fanuc", "G50 X#1"},
                            {"linuxcnc", "G92 X[#1+1]"},
                            {"fanuc", "G18 G43 H2 Z5.\nG17"},
                            {"fanuc", "G54 G55"},
                            {"fanuc", "G53.5"},
                            {"haas", "G37 H1 Z5."},
                            {"fanuc", "G65 P9811 X5.\nG54 G49 G94"},
                            {"sinumerik", "CYCLE978(1,2)\nG54 D1"},
                            {"sinumerik", "GEOAX(1,U)\nG54 D1"},
                            {"sinumerik", "TOFRAME"},
                            {"heidenhain", "TCH PROBE 411 DATUM OUTS. RECTAN."}})
    EXPECT_FALSE(IsCorrectedBehind(known.dialect, known.blocks)) << known.blocks;
  for (const Case& known : {Case{"fanuc", "G54.1 P#1\nG54"}, {"fanuc", "G43 H1 Z5.\nG43 H#2\nG49"},
                            {"fanuc", "G43 H#2\nG43 H1"}, {"heidenhain", "TCH PROBE 0.0 REF. PLANE Q5 X-"}})
    EXPECT_TRUE(IsCorrectedBehind(known.dialect, known.blocks)) << known.blocks;
}

// Skipped or not, what such a block changes is not known.
TEST(Passed, CodesOfBlocksThatMayBeSkippedLeaveBothStates) {
  for (const Case& known : {Case{"fanuc", "/G91"}, {"fanuc", "G91\n/G90"}, {"fanuc", "/G20"}, {"fanuc", "/G92 X5."},
                            {"fanuc", "G41 D1\n/G40"}, {"fanuc", "G68 X0 Y0 R5.\n/G69 X#1"}, {"fanuc", "/G43 H2"},
                            {"fanuc", "G16\n/M30"}, {"fanuc", "G16\n/M99"}, {"fanuc", "/G51.1 X0\nG50.1 Y0"}})
    EXPECT_FALSE(IsCorrectedBehind(known.dialect, known.blocks)) << known.blocks;
  EXPECT_TRUE(IsCorrectedBehind("fanuc", "/M8"));
  EXPECT_TRUE(IsCorrectedBehind("fanuc", "/G91\nG90 G54 G49 G94 G17 G21"));
  EXPECT_TRUE(IsCorrectedBehind("fanuc", "G1 X1.\n/M99"));
}

TEST(Passed, CalledProgramsHaveTheModesOfTheirCaller) {
  const std::string restated = "\nG90 G54 G49 G94 G17 G21";
  EXPECT_TRUE(IsCorrectedBehind("fanuc", "G1 X1.\nM98 P2\nM30\nO2" + restated));
  for (const std::string mode : {"G68 R30.", "G43.4 H1", "G92 X5.", "G52 X5.", "G51.1 Z0"}) {
    const std::string called = "G1 X1.\n" + mode + "\nM98 P2\nG69 G49 G52 X0 Y0\nM30\nO2\nG90 G54 G94 G17 G21";
    EXPECT_FALSE(IsCorrectedBehind("fanuc", called)) << mode;
  }
  // Controls differ on whether M30 ends preset coordinates.
  EXPECT_FALSE(IsCorrectedBehind("fanuc", "G1 X1.\nG92 X0\nM30\nO2"));
  EXPECT_FALSE(IsCorrectedBehind("linuxcnc", "G1 X1.\nG41 D1\no100 call" + restated));
  EXPECT_FALSE(IsCorrectedBehind("linuxcnc", "G41 D1\nM70\nG40\nM72" + restated));
  EXPECT_TRUE(IsCorrectedBehind("linuxcnc", "M70\nM72" + restated));
}

// G50 with axis words sets coordinates on lathes, as G92 does; alone it ends scaling, with S it limits the spindle.
TEST(Passed, PresetsOfAllKindsAreNoMoves) {
  EXPECT_REWRITTEN(kAtZero, "G1 X1.\nG50 X0\nX5.\nG50 S2000\nX6.\n", "G1 X1.0417\nG50 X0\nX5.\nG50 S2000\nX6.\n");
  // B90 stands at 0 from then on.
  EXPECT_REWRITTEN(kAtZero, "G1 X1. Z0.\nG50 B90.\nX2. B90.\n", "G1 X1.0417 Z0.\nG50 B90.\nX2.0417 B90.\n");
  EXPECT_REFUSED(testing::InMm(), "G50 X0\n", "line 1: 'G50 X0': G50 (");
  EXPECT_REFUSED(kAtZero, "G50 X200. A0\n", "word A");
  EXPECT_REFUSED(kAtZero, "G1 X1.\nG92 X20. Z-30. F1.5\nX19.\n", "a thread of lathes");
  RewriteOptions options = kAtZero;
  for (const char* const dialect : {"mazak", "haas"}) {
    options.dialect = dialect;
    EXPECT_REWRITTEN(options, "G1 X1.\nG50 X0\nX5.\n", "G1 X1.0417\nG50 X0\nX5.\n");
    EXPECT_REWRITTEN(options, "G1 X1.\nG92 X0\nX5.\n", "G1 X1.0417\nG92 X0\nX5.\n");
    EXPECT_REWRITTEN(options, "G1 X1.\nG92 S2000\nX5.\n", "G1 X1.0417\nG92 S2000\nX5.0417\n");
  }
  options.dialect = "linuxcnc";
  EXPECT_REWRITTEN(options, "G1 X1.\nG92 X0 F100\nX5.\n", "G1 X1.0417\nG92 X0 F100\nX5.\n");
  // It limits the spindle, whatever is in force.
  EXPECT_FALSE(IsCorrectedBehind("fanuc", "G43.5 H1\nG92 S2000"));
  EXPECT_TRUE(IsCorrectedBehind("fanuc", "G43.5 H1\nG92 S2000\nG49"));
}

RewriteOptions Passing(const std::string& dialect = "fanuc") {
  RewriteOptions options = kAtZero;
  options.dialect = dialect;
  options.on_unsupported = OnUnsupported::kPass;
  return options;
}

// A full circle of 314 mm from a point that was corrected by 42 um would be an arc of 42 um.
TEST(Passed, BlocksBeginWhereTheProgramSays) {
  const std::string to = "G1 X50. Y0. F100\n", corrected = "G1 X50.0417 Y0. F100\n", back = "G01 X50.0000\n";
  for (const std::string block :
       {"G2 X50. Y0. I-50. P2", "G2 X50. Y0. I-#1", "G2 X#1 Y0. I-50.", "M98 P1000", "G65 P1000", "#1=#2+1", "G43.4 H1",
        "G68 X0 Y0 R5.", "G41 D1", "T2 M6", "M99", "G28", "G81 Z-5. R2. F50", "IF [#1 EQ 0] GOTO 10"})
    EXPECT_REWRITTEN(Passing(), to + block + "\n", corrected + back + block + "\n");
  // Once, and not where every axis is told where to go.
  EXPECT_REWRITTEN(Passing(), to + "G41 D1\nG2 X50. I-50.\nG40\n", corrected + back + "G41 D1\nG2 X50. I-50.\nG40\n");
  for (const std::string block : {"G28 Z0", "G53 G0 Z0", "G4 P1", "G91 G28 X0", "M3", "M30"})
    EXPECT_REWRITTEN(Passing(), to + block + "\n", corrected + block + "\n");
  // In front of feed moves whose axes are not all known, too.
  EXPECT_REWRITTEN(Passing(), to + "G28 Z0\nG2 X50. I-50.\n", corrected + "G28 Z0\n" + back + "G2 X50. I-50.\n");
  // In the state in which the control is then.
  EXPECT_REWRITTEN(Passing(), "G0 X50. Y0.\nG91 G2 X#1 I-50.\n", "G0 X50.0417 Y0.\nG00 X50.0000\nG91 G2 X#1 I-50.\n");
  EXPECT_REWRITTEN(Passing(), to + "G91\nM98 P1\n", corrected + "G91\nG01 X-0.0417\nM98 P1\n");
  EXPECT_REWRITTEN(Passing(), "G20 G1 X2.123456 F10\nG21 M98 P1\n",
                   "G20 G1 X2.125096 F10\nG01 X2.123456\nG21 M98 P1\n");
  EXPECT_REWRITTEN(Passing(), "G93 G1 X50. F10.\nM98 P1\n", "G93 G1 X50.0417 F10.\nG01 X50.0000 F1000.\nM98 P1\n");
  EXPECT_REWRITTEN(Passing(), to + "G80\nG68 X0 Y0 R5.\n", corrected + "G80\nG01 X50.0000\nG80\nG68 X0 Y0 R5.\n");
  EXPECT_REWRITTEN(Passing(), to + "G92 X0\nX5. B90.\nM98 P1\n",
                   corrected + "G92 X0\nX4.9583 B90. Z-0.0417\nG01 X5.0000 Z0.0000\nM98 P1\n");
  EXPECT_REWRITTEN(Passing(), "G1 X50. Y0. F100\r\nM98 P1",
                   "G1 X50.0417 Y0. F100\r\nG01 X50.0000\n"
                   "M98 P1");
  // Behind the end nothing is known of where the control is.
  EXPECT_REWRITTEN(Passing(), to + "M30\nO2\nM98 P1\n", corrected + "M30\nO2\nM98 P1\n");
  EXPECT_REWRITTEN(Passing(), to + "X60. M99\n", corrected + back + "X60. M99\n");
}

TEST(Passed, TheMotionCodeOfAnArcComesBackInFrontOfWhatMovesByIt) {
  const std::string arc = "G1 X0 Y0 F100\nG2 X20. Y0 I10. J0\n",
                    written = "G1 X0.0417 Y0 F100\nG2 X20.0417 Y0 I10. J0\n";
  EXPECT_REWRITTEN(Passing(), arc + "X#1 I5.\n", written + "G01 X20.0000\n G02 X#1 I5.\n");
  EXPECT_REWRITTEN(Passing(), arc + "T1 M6\nX30. Y0 I5.\n", written + "G01 X20.0000\nT1 M6\n G02 X30. Y0 I5.\n");
  EXPECT_REWRITTEN(Passing(), arc + "G68 X0 Y0 R5.\n", written + "G01 X20.0000\nG68 X0 Y0 R5.\n");
  EXPECT_REWRITTEN(Passing(), arc + "G1\nM98 P1\n", written + "G1\nG01 X20.0000\nM98 P1\n");
  for (const std::string block : {"M98 P1", "M99", "G65 P1", "WHILE [#1 LT 3] DO1"})
    EXPECT_REFUSED(Passing(), arc + block + "\n", "state G00 or G01 in front of it");
  for (const std::string block : {"o100 call", "O<sub> call [1]", "o100 while [#1 lt 3]"})
    EXPECT_REFUSED(Passing("linuxcnc"), arc + block + "\n", "state G00 or G01 in front of it");
  EXPECT_REWRITTEN(Passing("linuxcnc"), arc + "G1\no100 call\n", written + "G1\nG01 X20.0000\no100 call\n");
}

TEST(Passed, KlartextReturnsToItsPoleToo) {
  const std::string begin = "CC X+0 Y+0\nL X+50 Y+0 F500\nC X-50 Y+0 DR-\n";
  EXPECT_REWRITTEN(Passing("heidenhain"), begin + "CP IPA+180 DR-\n",
                   "CC X+0 Y+0\nL X+50.0417 Y+0 F500\nCC X+0.0417 Y+0.0000\nC X-49.9583 Y+0 DR-\n"
                   "L X-50.0000\nCC X+0.0000 Y+0.0000\nCP IPA+180 DR-\n");
  EXPECT_REWRITTEN(Passing("heidenhain"), "L X+50 Y+0 FMAX\nCALL LBL 1\n",
                   "L X+50.0417 Y+0 FMAX\nL X+50.0000 FMAX\nCALL LBL 1\n");
  EXPECT_REFUSED(Passing("heidenhain"), "L X+50 Y+0 F500\nRND R5\nCP IPA+90 DR+\n", "the corner in front of it");
}

TEST(Passed, ArcsFromWhereABlockThatMayBeSkippedLedAreRefused) {
  EXPECT_REFUSED(Passing(), "G1 X0 F100\n/X50.\nG2 X50. I-50.\n", "state --block-delete");
  EXPECT_REFUSED(Passing(), "G1 X0 F100\n/X50.\nM98 P1\n", "state --block-delete");
  EXPECT_REWRITTEN(Passing(), "G1 X0 F100\n/X50.\nG41 X60.\nG2 X60. I-60.\n",
                   "G1 X0.0417 F100\n/X50.0417\nG41 X60.\nG2 X60. I-60.\n");
}

// What follows the direction of the move in front of it gets no short move there.
TEST(Passed, TangentialMovesFollowTheMoveInFrontOfThem) {
  EXPECT_REWRITTEN(Passing("heidenhain"), "L X+50 Y+0 F500\nCT X+60 Y+10\nCP IPA+90 DR+\n",
                   "L X+50.0417 Y+0 F500\nCT X+60 Y+10\nCP IPA+90 DR+\n");
  EXPECT_REFUSED(Passing("heidenhain"), "L X+50 Y+0 F500\nCT Y+10\nCP IPA+90 DR+\n",
                 "an arc from a corrected position of X");
  EXPECT_REWRITTEN(Passing("sinumerik"), "G1 X50 Y0 F500\nCT X60 Y10\n", "G1 X50.0417 Y0 F500\nCT X60 Y10\n");
}

// G43.1 Z5 of LinuxCNC is an offset: no G02 belongs in front of it, though a straight block was inserted.
TEST(Passed, WordsOfAnOffsetAreNoMove) {
  EXPECT_REWRITTEN(Passing("linuxcnc"), "G1 X0 Y0 F100\nG2 X10 Y0 I5\nG43.1 Z5\n",
                   "G1 X0.0417 Y0 F100\nG2 X10.0417 Y0 I5\nG01 X10.0000\nG43.1 Z5\n");
}

// Corrected blocks have inserted words and differences that hold for what stands in front of them only.
TEST(Passed, AJumpBackToCorrectedBlocksIsRefused) {
  const std::string moves = "G1 X0 F100\nN10 G2 X50. Y0. R50.\n",
                    reason = "may lead back to blocks that were corrected";
  for (const std::string jump : {"IF [#1 LT 5] GOTO 10", "GOTO 10", "GOTO #1", "GOTO 123456", "M99 P10"})
    EXPECT_REFUSED(Passing(), moves + "G1\n" + jump + "\n", reason);
  EXPECT_REFUSED(Passing("haas"), moves + "G1\nM97 P10\n", reason);
  EXPECT_REFUSED(Passing("sinumerik"), "G1 X5\nGOTOB START\n", reason);
  EXPECT_REFUSED(Passing("sinumerik"), "G1 X5\nREPEAT START P=3\n", reason);
  for (const std::string jump : {"IF [#1 LT 5] GOTO 20", "GOTO 20", "M99 P20", "WHILE [#1 LT 5] DO1", "M98 P10"})
    EXPECT_TRUE(Rewritten("G1 X1.\nN10 X2.\n" + jump + "\n", Passing()).status.ok()) << jump;
  for (const std::string jump : {"IF R1==0 GOTOF ENDE", "REPEAT", "WHILE R1>0"})
    EXPECT_TRUE(Rewritten("G1 X1\nN10 X2\n" + jump + "\n", Passing("sinumerik")).status.ok()) << jump;
  RewriteReport report;
  EXPECT_TRUE(RewriteText("N10 #1=#1+1\nGOTO 10\n", testing::LeaningHead(), Passing(), &report).ok());
}

}  // namespace
}  // namespace axiscal::nc
