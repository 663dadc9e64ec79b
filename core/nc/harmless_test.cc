// What programs hold that stops nothing, and what looks harmless and is not.
#include "core/nc/testing/rewritten.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

using testing::kAtZero;

RewriteOptions In(const std::string& dialect) {
  RewriteOptions options = kAtZero;
  options.dialect = dialect;
  options.tool_lengths = {{1, 10.0}, {2, 20.0}};
  return options;
}

TEST(Harmless, TextInFrontOfTheFirstPercentIsNoProgram) {
  const std::string listing = "TOOL LIST\n\nT1 = MILL D10 (steel)\n";
  const std::string program = "%\nO1\nG1 X10.\nM30\n%\n", corrected = "%\nO1\nG1 X10.0417\nM30\n%\n";
  for (const char* dialect : {"fanuc", "mazak", "haas", "linuxcnc"})
    EXPECT_REWRITTEN(In(dialect), listing + program, listing + corrected);
  const std::string text = listing + program;
  VerifyOptions verify;
  verify.tool_tip_mm = {0, 0, -testing::kToolMm};
  verify.reading = In("fanuc");
  const auto report = VerifyText(text, listing + corrected, testing::LeaningHead().machine(), {}, verify);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->moves, 1);
  // What a control reads is none: macros, codes, a program without '%'.
  EXPECT_REFUSED(In("fanuc"), "X#1\n" + program, "line 1");
  EXPECT_REFUSED(In("fanuc"), "G1 X=5\n" + program, "line 1");
  EXPECT_REFUSED(In("fanuc"), listing + "G1 X10.\nM30\n", "line 1: 'TOOL LIST'");
  EXPECT_REFUSED(In("fanuc"), listing, "line 1: 'TOOL LIST'");
}

TEST(Harmless, LathesSwitchOffsetsByTheTWord) {
  for (const char* dialect : {"fanuc", "mazak", "haas"}) {
    EXPECT_REFUSED(In(dialect), "T0101\nG1 X10.\n", "a tool offset of a lathe may be active");
    EXPECT_REFUSED(In(dialect), "T303\nG1 X10.\n", "line 2: 'G1 X10.': a tool offset of a lathe may be active");
    // A mill: M06 changes the tool, T only stages one.
    EXPECT_REWRITTEN(In(dialect), "T0101 M6\nG0 X0. Y0. Z0. B0. C0.\nT0202\nG1 X10.\n",
                     "T0101 M6\nG0 X0.0417 Y0. Z0. B0. C0.\nT0202\nG1 X10.0417\n");
    EXPECT_REWRITTEN(In(dialect), "T0101\nM6\nG0 X0. Y0. Z0. B0. C0.\n", "T0101\nM6\nG0 X0.0417 Y0. Z0. B0. C0.\n");
    EXPECT_REWRITTEN(In(dialect), "T12\nT0100\nG1 X10.\n", "T12\nT0100\nG1 X10.0417\n");
  }
}

TEST(Harmless, AnArcOfNoMoreTurns) {
  RewriteOptions options = In("sinumerik");
  EXPECT_REWRITTEN(options, "G2 X10. Y0. I=5. J=0. TURN=0 F100\n", "G2 X10.0417 Y0. I=5.0209 J=-0.0263 TURN=0 F100\n");
  EXPECT_REFUSED(options, "G2 X10. Y0. I=5. J=0. TURN=2 F100\n", "TURN (a helix of several turns)");
  EXPECT_REFUSED(options, "G2 X10. Y0. I=5. J=0. TURN=R1 F100\n", "line 1");
}

TEST(Harmless, RetractionToAPlaceOfTheMachine) {
  RewriteOptions options = In("sinumerik");
  const std::string back = "D1\nG0 X1. Y0. Z0. B0. C0.\n", corrected = "D1\nG0 X1.0428 Y0. Z0. B0. C0.\n";
  EXPECT_REWRITTEN(options, "SUPA G0 Z=$P_HOME D0\n" + back, "SUPA G0 Z=$P_HOME D0\n" + corrected);
  // The length is off until the program states it.
  EXPECT_REFUSED(options, "D1\nSUPA G0 Z=$P_HOME D0\nG1 X1. Y0. Z0. B0. C0.\n", "the tool length is not known");
}

TEST(Harmless, DefinitionsThatStateNothing) {
  RewriteOptions options = In("heidenhain");
  for (const char* cycle :
       {"CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1\n", "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT\n"}) {
    const std::string text = cycle;
    EXPECT_REWRITTEN(options, text + "L X+10 F100\n", text + "L X+10.0417 F100\n");
  }
  EXPECT_REFUSED(options, "CYCL DEF 10.1 ROT+5\nCYCL DEF 10.1 ROT\nL X+10 F100\n", "CYCL DEF 10");
}

TEST(Harmless, LinuxCncTakesTheLengthOfTheToolInTheSpindle) {
  const std::string there = "G0 X1. Y0. Z0. B0. C0.\n";
  EXPECT_REWRITTEN(In("linuxcnc"), "T1 M6\nG43\n" + there, "T1 M6\nG43\nG0 X1.0428 Y0. Z0. B0. C0.\n");
  EXPECT_REFUSED(In("linuxcnc"), "T3 M6\nG43\n" + there, "tool length 3: its value is not stated");
  for (const char* lost : {"", "T1\n/M6\n", "/T1\nM6\n", "T1 M6\nM61 Q2\n", "M6\n"})
    EXPECT_REFUSED(In("linuxcnc"), lost + ("G43\n" + there), "without a number");
}

}  // namespace
}  // namespace axiscal::nc
