// Drilling cycles: X and Y right where the drill goes in, Z at the bottom, and what the cycle has no word for.
#include "core/nc/testing/rewritten.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using testing::kAtZero;

RewriteOptions In(const std::string& dialect) {
  RewriteOptions options = kAtZero;
  options.dialect = dialect;
  options.tool_lengths = {{1, 10.0}};
  return options;
}

// Z leans by 100 urad about Y, and the head as in LeaningHead.
constexpr double kLeanRad = 1e-4;
compensate::Compensator LeaningZ() {
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  return testing::MustCreate(machine, testing::ConstantErrors(machine, {{"EB0Z", kLeanRad}}),
                             {0, 0, -testing::kToolMm});
}

TEST(Cycles, EachHoleIsCorrectedWhereItIs) {
  const std::string head = "G90 G17 G21 G94\nG0 X0. Y0. Z50. B0. C0.\n",
                    corrected = "G90 G17 G21 G94\nG0 X0.0417 Y0. Z50. B0. C0.\n";
  for (const char* dialect : {"fanuc", "mazak", "haas", "linuxcnc"}) {
    EXPECT_REWRITTEN(In(dialect), head + "G98 G81 X10. Y5. Z-8. R2. F200\nX20.\nY7.\nG80\nG0 X30.\n",
                     corrected + "G98 G81 X10.0417 Y5. Z-8. R2. F200\nX20.0417\nY7.\nG80\nG0 X30.0417\n");
    EXPECT_REWRITTEN(In(dialect), head + "G99G83X10.Y5.Z-8.R2.Q1.F200\nM8\nX20.\nG80\n",
                     corrected + "G99G83X10.0417Y5.Z-8.R2.Q1.F200\nM8\nX20.0417\nG80\n");
  }
  EXPECT_REWRITTEN(In("fanuc"), head + "G81 Z-8. R2. F200\n", corrected + "G81 Z-8. R2. F200\n");
}

TEST(Cycles, DepthAndRFollowEachHole) {
  // Y leans by 100 urad about X, seen along Y in Z: EA0Y turns what Y carries.
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  const auto compensator =
      testing::MustCreate(machine, testing::ConstantErrors(machine, {{"EA0Y", 1e-4}}), {0, 0, -testing::kToolMm});
  const std::string program =
      "G90 G17 G21 G94\nG0 X0. Y0. Z50. B0. C0.\nG99 G81 X10. Y0. Z-8. R2. F200\nY100. (SECOND)\nX20.\nG80\n";
  const testing::Outcome outcome = testing::Rewritten(program, In("fanuc"), compensator);
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_THAT(outcome.text, HasSubstr(" Z-8.01"));  // 10 um deeper or higher at Y100: inserted, and R with it
  EXPECT_THAT(outcome.text, HasSubstr(" R1.99"));
  EXPECT_EQ(outcome.report.holes, 3);
  VerifyOptions verify;
  verify.tool_tip_mm = {0, 0, -testing::kToolMm};
  verify.reading = In("fanuc");
  const auto report = VerifyText(program, outcome.text, machine, compensator.carried(), verify);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->moves, 4);
  EXPECT_EQ(report->blocks_unsupported, 0);
  EXPECT_GT(report->end_before.max_mm, 9e-3);
  EXPECT_LT(report->end_after.max_mm, 1.5e-3);  // the lean of 10 mm by 100 urad, and rounding
}

TEST(Cycles, TheLeanIsSaidPerHoleAndRefusedAboveTheTolerance) {
  const std::string program = "G90 G17 G21 G94\nG0 X0. Y0. Z50. B0. C0.\nG81 X10. Y0. Z-48. R2. F200\nX20.\nG80\n";
  RewriteOptions options = In("fanuc");
  const testing::Outcome outcome = testing::Rewritten(program, options, LeaningZ());
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_NEAR(outcome.report.max_hole_left_mm, 50 * kLeanRad, 2e-4);
  ASSERT_EQ(outcome.report.left.size(), 2u);
  EXPECT_EQ(outcome.report.left[1].line, 4);
  EXPECT_THAT(outcome.report.left[0].reason, HasSubstr("um are left at the hole: the drill leans"));
  options.cycle_tolerance_mm = 0.004;
  EXPECT_REFUSED_BY(LeaningZ(), options, program, "the limit is 4.0 um");
  EXPECT_REFUSED_BY(LeaningZ(), options, program, "--cycle-tolerance-um");
  options.cycle_tolerance_mm = 0.0;
  EXPECT_FALSE(Validate(options).ok());
}

TEST(Cycles, WhatIsNotFollowedIsRefused) {
  const std::string head = "G90 G17 G21 G94\nG0 X0. Y0. Z50. B0. C0.\n";
  const std::vector<std::pair<std::string, std::string>> blocks = {
      {"G81 X10. Z-8. F200\n", "its first block must state R and Z"},
      {"G81 X10. R2. F200\n", "its first block must state R and Z"},
      {"G81 R2. F200\n", "without words of X, Y or Z"},
      {"G81 X10. Z-8. R2. F200\nR3.\n", "without words of X, Y or Z"},
      {"G81 X10. Z8. R2. F200\n", "its bottom is not below R"},
      {"G81 X10. Z-8. R60. F200\n", "R is above where Z stood"},
      {"G91 G81 X10. Z-8. R-40. F200\n", "in G91"},
      {"G81 X10. Z-8. R2. F200\nG91 X5. L3\n", "in G91"},
      {"G18 G81 X10. Z-8. R2. F200\n", "in another plane"},
      {"G93 G81 X10. Z-8. R2. F200\n", "in G93"},
      {"G81 X10. Z-8. R2. C5. F200\n", "with a word of C"},
      {"G81 X10. Z-8. R2. F200\nG83 X20. Q1.\n", "its first block must state R and Z"},
      {"G81 X10. Z-8. R2. F200\nG52 Z3.\nX20.\n", "work offset or tool length changed in it"},
      {"G81 X10. Z-8. R2. E5. F200\n", "with a word E"},
      {"G81 X10. Z-8. R2. F200\n/G99\nX20.\n", "may be skipped"},
      {"G87 X10. Z-8. R2. F200\n", "boring cycle from behind"},
      {"G88 X10. Z-8. R2. F200\n", "program its moves, or G86 or G89"},
      {"G81 X10. Z-8. R2. L0 F200\n", "no repeat"},
      {"G81 X#1 Z-8. R2. F200\n", "line 3"},
  };
  for (const auto& [block, reason] : blocks) EXPECT_REFUSED(In("fanuc"), head + block, reason);
  EXPECT_REFUSED(In("linuxcnc"), head + "G76 X10. Z-8. R2. F200\n", "canned cycle");
  RewriteOptions turning = In("fanuc");
  turning.orientation = true;
  EXPECT_REFUSED(turning, head + "G81 X10. Z-8. R2. F200\n", "with --orientation");
  EXPECT_REFUSED(In("fanuc"), "M6\nG0 X0. Y0. Z50.\nG81 X10. Z-8. R2. F200\n", "the position of B is unknown");
}

// G80 ends the cycle alone: G00 and G01 are of another group of codes. LinuxCNC counts all as one.
TEST(Cycles, BehindThemTheMotionCodeInFrontIsInForceAgain) {
  const std::string head = "G90 G17 G21 G94\nG0 X0. Y0. Z50. B0. C0.\n",
                    done = "G90 G17 G21 G94\nG0 X0.0417 Y0. Z50. B0. C0.\n";
  const std::string hole = "G98 G81 X10. Y5. Z-8. R2. F200\nG80\n", made = "G98 G81 X10.0417 Y5. Z-8. R2. F200\nG80\n";
  for (const char* dialect : {"fanuc", "mazak", "haas"}) {
    EXPECT_REWRITTEN(In(dialect), head + hole + "X30.\n", done + made + "X30.0417\n");
    EXPECT_REFUSED(In(dialect), head + "G80\nX30.\n" + hole, "no motion code is in force");
    EXPECT_REFUSED(In(dialect), head + "G2 X10. Y0. R5. F100\n" + hole + "X30.\n", "no motion code is in force");
  }
  EXPECT_REFUSED(In("linuxcnc"), head + hole + "X30.\n", "no motion code is in force");
}

TEST(Cycles, DataWithoutAHoleAndHolesThatMayBeSkipped) {
  const std::string head = "G90 G17 G21 G94\nG0 X0. Y0. Z50. B0. C0.\n",
                    corrected = "G90 G17 G21 G94\nG0 X0.0417 Y0. Z50. B0. C0.\n";
  EXPECT_REWRITTEN(In("haas"), head + "G81 Z-8. R2. L0 F200\nX20.\n",
                   corrected + "G81 Z-8. R2. L0 F200\nX20.0417 Z-8.0000 R2.0000\n");
  EXPECT_REWRITTEN(In("fanuc"), head + "G81 X10. Z-8. R2. F200\n/X15.\nX20. Y0.\n",
                   corrected + "G81 X10.0417 Z-8. R2. F200\n/X15.0417\nX20.0417 Y0. Z-8.0000 R2.0000\n");
}

TEST(Cycles, WhereZStandsBehindACycleMustBeStated) {
  const std::string head = "G90 G17 G21 G94\nG0 X0. Y0. Z50. B0. C0.\n";
  const std::string cycle = "G81 X10. Z-8. R2. F200\nG80\n";
  EXPECT_REFUSED(In("linuxcnc"), head + cycle + "G1 X5. F100\n",
                 "the position of Z is unknown: not programmed since line 3");
  for (const char* level : {"G98\n", "G99\n"})
    EXPECT_TRUE(testing::Rewritten(head + level + cycle + "G1 X5. F100\n", In("linuxcnc")).status.ok());
}

TEST(Cycles, CalledCyclesHaveXAndYCorrectedAndSayWhatIsLeft) {
  RewriteOptions options = In("sinumerik");
  const std::string head = "G71 G90 G17 G94\nG0 X0. Y0. Z50. B0. C0.\n",
                    begin = "G71 G90 G17 G94\nG0 X0.0417 Y0. Z50. B0. C0.\n";
  EXPECT_REWRITTEN(options, head + "MCALL CYCLE81(20,0,2,-10)\nX10. Y5.\nX20.\nMCALL\nG0 X30.\n",
                   begin + "MCALL CYCLE81(20,0,2,-10)\nX10.0417 Y5.\nX20.0417\nMCALL\nG0 X30.0417\n");
  EXPECT_REWRITTEN(options, head + "G0 X10.\nCYCLE83(20,0,2,,10)\nX20.\n",
                   begin + "G0 X10.0417\nCYCLE83(20,0,2,,10)\nX20.0417\n");
  RewriteOptions klartext = In("heidenhain");
  const std::string definition =
      "CYCL DEF 200 DRILLING ~\n Q200=+2 ;CLEARANCE ~\n Q201=-10 ;DEPTH ~\n Q203=+0 ~\n Q204=+20\n";
  EXPECT_REWRITTEN(klartext, definition + "L X+10 Y+5 R0 FMAX M99\nL X+20 FMAX M99\nCYCL CALL\nL X+30 FMAX\n",
                   definition + "L X+10.0417 Y+5 R0 FMAX M99\nL X+20.0417 FMAX M99\nCYCL CALL\nL X+30.0417 FMAX\n");
  // Z leans by 100 urad, and the heights of all holes are those of the definition.
  const testing::Outcome lean =
      testing::Rewritten(head + "MCALL CYCLE81(60,0,2,-48)\nX10.\nMCALL\n", options, LeaningZ());
  ASSERT_TRUE(lean.status.ok()) << lean.status;
  EXPECT_NEAR(lean.report.max_hole_left_mm, 50 * kLeanRad, 3e-4);
  // The tilt of Y lifts Y = 100 by 10 um: no word of the hole takes it away.
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  const auto tilted =
      testing::MustCreate(machine, testing::ConstantErrors(machine, {{"EA0Y", 1e-4}}), {0, 0, -testing::kToolMm});
  const testing::Outcome high = testing::Rewritten(definition + "L X+10 Y+100 R0 FMAX M99\n", klartext, tilted);
  ASSERT_TRUE(high.status.ok()) << high.status;
  EXPECT_NEAR(high.report.max_hole_left_mm, 0.010, 2e-3);
  klartext.cycle_tolerance_mm = 0.005;
  // Z of this call shifts the heights: it is a word of the hole.
  const testing::Outcome shifted =
      testing::Rewritten(definition + "CYCL CALL POS X+10 Y+100 Z+3 F900\nL Z+50 FMAX\n", klartext, tilted);
  ASSERT_TRUE(shifted.status.ok()) << shifted.status;
  EXPECT_THAT(shifted.text, HasSubstr("CYCL CALL POS X+10 Y+99.9644 Z+2.9900 F900\nL Z+49.9900 FMAX"));
  EXPECT_LT(shifted.report.max_hole_left_mm, 1e-3);
  EXPECT_REFUSED_BY(tilted, klartext, definition + "L X+10 Y+100 R0 FMAX M99\n",
                    "um are left at the hole, the limit is 5.0 um");
}

TEST(Cycles, CallsThatAreNotFollowedAreRefused) {
  const std::string head = "G71 G90 G17 G94\nG0 X0. Y0. Z50. B0. C0.\n";
  for (const std::string block :
       {"CYCLE81(R1,0,2,-10)", "CYCLE81(20,0,2)", "CYCLE81(20,0,2,10)", "CYCLE81(1,0,2,-10)", "CYCLE81(20,0,2,-10,5)",
        "CYCLE88(20,0,2,-10)", "G70\nCYCLE81(20,0,2,-10)", "CYCLE801(20,0,2,-10)",
        "MCALL CYCLE81(20,0,2,-10)\nG1 X10. F100", "MCALL CYCLE81(20,0,2,-10)\nG91 X10.",
        "MCALL CYCLE81(20,0,2,-10)\nG18\nX10.", "MCALL CYCLE81(20,0,2,-10)\nROT Z30\nX10.",
        "MCALL HOLES1(0,0,0,5,5,3)\nX10.", "/MCALL CYCLE81(20,0,2,-10)\nX10.", "MCALL CYCLE81(20,0,2,-10)\nSUPA G0 Z0"})
    EXPECT_FALSE(testing::Rewritten(head + block + "\n", In("sinumerik")).status.ok()) << block;
  // D in front of M6: which length is in force behind it is the builder's to choose.
  EXPECT_REFUSED(In("sinumerik"), "G71 G90 G17 G94 D1\nM6\nG0 X0 Y0 Z50 B0 C0\nMCALL CYCLE81(20,0,2,-10)\nX10\n",
                 "the tool length is not known");
  const std::string definition = "CYCL DEF 200 DRILLING ~\n Q200=+2 ~\n Q201=-10 ~\n Q203=+0\n",
                    call = "L X+10 FMAX M99\n";
  EXPECT_TRUE(testing::Rewritten(definition + call, In("heidenhain")).status.ok());
  for (const std::string& text : std::vector<std::string>{
           call, "CYCL DEF 200 DRILLING ~\n Q200=+2 ~\n Q201=-10 ~\n Q203=Q5\n" + call,
           "CYCL DEF 200 DRILLING ~\n Q200=+2 ~\n Q201=-10\n" + call, definition + "Q203 = +5\n" + call,
           definition + "FN 0: Q203 = +5\n" + call, definition + "CYCL DEF 252 POCKET ~\n Q201=-10\n" + call,
           "/" + definition + call, definition + "TOOL CALL 1 Z S100\nL X+0 Y+0 Z+50 B+0 C+0 FMAX\n" + call,
           definition + "L X+10 F200 M99\n", definition + "CYCL CALL POS X+10 Y+10 FMAX\n",
           definition + "CYCL CALL POS IX+10 Y+10 Z+0 FMAX\n", definition + "CYCL CALL POS X+10 Y+10 Z+0 B+0 FMAX\n",
           definition + "CYCL CALL POS X+10 Y+10 Z+0 FMAX M99\n", definition + "CYCL CALL POS X+Q7 Y+10 Z+0 FMAX\n",
           "CYCL CALL POS X+10 Y+10 Z+0 FMAX\n", definition + "CYCL CALL PAT FMAX\n",
           definition + "CYCL DEF 221 PATTERN ~\n Q225=+10\n" + call})
    EXPECT_FALSE(testing::Rewritten(text, In("heidenhain")).status.ok()) << text;
}

TEST(Cycles, PassedHolesBeginWhereTheProgramSays) {
  RewriteOptions options = In("fanuc");
  options.on_unsupported = OnUnsupported::kPass;
  EXPECT_REWRITTEN(options,
                   "G21 G0 X1. Y0. Z50.\nG91 G81 X10. Z-8. R-40. F200\nX5.\nG80\nG90 G0 X2. Y0. Z50. B0. C0.\n",
                   "G21 G0 X1.0417 Y0. Z50.\nG00 X1.0000\nG91 G81 X10. Z-8. R-40. F200\nX5.\nG80\nG90 G0 X2.0417 Y0. "
                   "Z50. B0. C0.\n");
}

// Behind a block that states a cycle and is not followed, nobody knows which cycle drills how deep.
TEST(Cycles, APassedBlockOfACycleEndsIt) {
  RewriteOptions options = In("fanuc");
  options.on_unsupported = OnUnsupported::kPass;
  const std::string head = "G90 G17 G21 G94\nG0 X0. Y0. Z50. B0. C0.\n",
                    begin = "G90 G17 G21 G94\nG0 X0.0417 Y0. Z50. B0. C0.\n";
  for (const char* unread : {"G81 X1 Z-M8\n", "G81 X1. Z#5 R2.\n"}) {
    EXPECT_REWRITTEN(options, head + unread + "X20. Y5.\nG80\n", begin + "G00 X0.0000\n" + unread + "X20. Y5.\nG80\n");
    EXPECT_REFUSED(options, head + "G83 X10. Z-8. R2. Q1. F200\n" + unread + "X20. Y5.\nG80\n",
                   "it must begin where the program says, and cannot");
  }
}

// The words of the block are those of the other code: nothing states the cycle's heights.
TEST(Cycles, ACycleThatBeginsBesideAnotherCodeIsRefused) {
  for (const char* const beside : {"G92 X0.", "G52 X1.", "G92 S2000", "G92.1", "G50 S100"}) {
    for (const char* const dialect : {"fanuc", "haas", "linuxcnc"}) {
      RewriteOptions options = testing::kAtZero;
      options.dialect = dialect;
      for (const OnUnsupported what : {OnUnsupported::kRefuse, OnUnsupported::kPass}) {
        options.on_unsupported = what;
        RewriteReport report;
        const auto text = RewriteText(std::string(beside) + " G81\nX5.\nX6. Z-3. R2.\nG80\n", testing::LeaningHead(),
                                      options, &report);
        EXPECT_EQ(report.blocks_corrected, 0) << beside << " " << dialect;
        EXPECT_EQ(text.ok(), what == OnUnsupported::kPass) << beside << " " << dialect << text.status();
      }
    }
  }
}

}  // namespace
}  // namespace axiscal::nc
