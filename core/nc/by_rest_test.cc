// Blocks that end modes by what stands behind their keyword, and others that move nothing which is followed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/nc/testing/rewritten.h"

namespace axiscal::nc {
namespace {

using testing::kAtZero;
using testing::Outcome;
using testing::Rewritten;

RewriteOptions In(const std::string& dialect) {
  RewriteOptions options = kAtZero;
  options.dialect = dialect;
  return options;
}

TEST(ByRest, SinumerikFramesAloneEndThemAll) {
  for (const std::string reset : {"TRANS", "ROT ; off", "SCALE", "MIRROR", "MCALL"})
    EXPECT_REWRITTEN(In("sinumerik"), reset + "\nG1 X1 F100\n", reset + "\nG1 X1.0417 F100\n");
  RewriteOptions passing = In("sinumerik");
  passing.on_unsupported = OnUnsupported::kPass;
  const std::string all = "G1 X1 Y0 Z0 B0 C0 F100\n", corrected = "G1 X1.0417 Y0 Z0 B0 C0 F100\n";
  for (const std::string on : {"ROT Z30", "TRANS X10 ROT", "ATRANS X=R1", "MIRROR Z0"})
    EXPECT_REWRITTEN(passing, on + "\nX5\nTRANS\n" + all, on + "\nX5\nTRANS\n" + corrected);
  for (const std::string stays : {"ROT Z30\nX5\nATRANS", "ROT Z30\nX5\nMCALL", "TRANS X=R1\nX5\nCYCLE800()",
                                  "CYCLE800(1,\"TC\",0,57,0,0,0,30,0,0,0,0,0,1)\nX5\nTRANS", "TRANS X10\n/TRANS"}) {
    const Outcome outcome = Rewritten(all + stays + "\n" + all, passing);
    EXPECT_EQ(outcome.text.rfind(corrected), outcome.text.find(corrected)) << outcome.text;
  }
}

// At B = 90 deg the correction is in Z, at 0 in X: a shift of B shows at once.
TEST(ByRest, FramesThatOnlyShiftAreFollowed) {
  const RewriteOptions options = In("sinumerik");
  const std::string move = "G1 X2 B0 F100\n", turned = "G1 X2 B0 Z-0.0417 F100\n", plain = "G1 X2.0417 B0 F100\n";
  for (const std::string shift :
       {"TRANS X5 B90", "TRANS B=+90.0 ; TEXT", "TRANS B20\nTRANS B90", "TRANS B20\nATRANS B70 Y1"})
    EXPECT_REWRITTEN(options, shift + "\n" + move, shift + "\n" + turned);
  for (const std::string ended : {"TRANS B90\nTRANS", "TRANS B90\nROT", "TRANS B90\nTRANS X1"})
    EXPECT_REWRITTEN(options, ended + "\n" + move, ended + "\n" + plain);
  for (const std::string blocks : {"TRANS B=R1", "TRANS X1 X2", "TRANS V5", "TRANS X5\nG54", "ATRANS",
                                   "ROT Z30\nATRANS B90", "/TRANS B90", "G70\nTRANS X1", "TRANS IC(5)"})
    EXPECT_REFUSED(options, blocks + "\n" + move, "line");
  EXPECT_REFUSED(options, "TRANS B90\nG91\nG1 B5 F100\n", "G91 behind a change");

  const RewriteOptions klartext = In("heidenhain");
  const std::string head = "CYCL DEF 7.0 DATUM SHIFT\n", line = "L X+2 B+0 F100\n";
  for (const std::string shift : {"CYCL DEF 7.1 B+90\n", "CYCL DEF 7.1 X+5\nCYCL DEF 7.2 B+90\n"})
    EXPECT_REWRITTEN(klartext, head + shift + line, head + shift + "L X+2 B+0 Z-0.0417 F100\n");
  EXPECT_REWRITTEN(klartext, head + "CYCL DEF 7.1 B+90\n" + head + "CYCL DEF 7.1 B+0\n" + line,
                   head + "CYCL DEF 7.1 B+90\n" + head + "CYCL DEF 7.1 B+0\nL X+2.0417 B+0 F100\n");
  for (const std::string blocks :
       {"CYCL DEF 7.1 #5\n", "CYCL DEF 7.1 IX+5\n", "CYCL DEF 7.1 X+Q1\n", "CYCL DEF 7.1 W+5\n"})
    EXPECT_REFUSED(klartext, head + blocks + line, "shift of coordinates");
}

TEST(ByRest, G43ActsAlongZInEveryPlaneWhereTheControlSaysSo) {
  for (const auto& [dialect, is_followed] : std::vector<std::pair<std::string, bool>>{
           {"linuxcnc", true}, {"haas", true}, {"fanuc", false}, {"mazak", false}}) {
    RewriteOptions options = In(dialect);
    options.tool_lengths = {{1, 100.0}};
    const Outcome outcome = Rewritten("G18\nG43 H1\nG1 X1. Z0. F100\n", options);
    EXPECT_EQ(outcome.status.ok(), is_followed) << dialect << outcome.status;
    if (!is_followed) continue;
    EXPECT_EQ(outcome.text, "G18\nG43 H1\nG1 X1.0533 Z0. F100\n");
  }
}

// The machine's builder may turn the axes home: they are unknown behind it.
TEST(ByRest, CYCLE800WithoutArgumentsEndsTheTiltedPlane) {
  EXPECT_REWRITTEN(In("sinumerik"), "CYCLE800()\nG0 X1 Y0 Z0 B0 C0\n", "CYCLE800()\nG0 X1.0417 Y0 Z0 B0 C0\n");
  EXPECT_REFUSED(In("sinumerik"), "CYCLE800()\nG1 X1 F100\n", "not programmed since line 1");
  RewriteOptions passing = In("sinumerik");
  passing.on_unsupported = OnUnsupported::kPass;
  const std::string tilt = "CYCLE800(1,\"TC\",0,57,0,0,0,30,0,0,0,0,0,1)\nG0 X5\nCYCLE800()\n";
  EXPECT_REWRITTEN(passing, tilt + "G0 X1 Y0 Z0 B0 C0\n", tilt + "G0 X1.0417 Y0 Z0 B0 C0\n");
}

TEST(ByRest, MachineMovesToVariablesAreNeverTouched) {
  EXPECT_REWRITTEN(In("sinumerik"), "G1 X1 F100\nSUPA G0 Z=_Z_HOME\nG0 X2 Y0 Z0 B0 C0\n",
                   "G1 X1.0417 F100\nSUPA G0 Z=_Z_HOME\nG0 X2.0417 Y0 Z0 B0 C0\n");
  // Which axes moved is not known, and what else the block does is.
  EXPECT_REFUSED(In("sinumerik"), "SUPA G0 Z=_Z_HOME X=$P_X\nG1 X2 F100\n", "not programmed since line 1");
  for (const std::string block : {"SUPA G0 Z=HOME(3)", "SUPA G0 Z=_Z D=R1", "G0 Z=_Z_HOME", "SUPA G0 Z=_Z M6"})
    EXPECT_REFUSED(In("sinumerik"), "G1 X1 F100\n" + block + "\n", "line 2");
}

TEST(ByRest, KlartextCyclesThatStateNothingEndTheirMode) {
  const RewriteOptions options = In("heidenhain");
  for (const std::string reset :
       {"CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+0\nCYCL DEF 7.2 Y+0", "CYCL DEF 8.0 MIRROR\nCYCL DEF 8.1",
        "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+0.000", "CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1"})
    EXPECT_REWRITTEN(options, reset + "\nL X+1 F100\n", reset + "\nL X+1.0417 F100\n");
  RewriteOptions passing = options;
  passing.on_unsupported = OnUnsupported::kPass;
  const std::string all = "L X+1 Y+0 Z+0 B+0 C+0 F100\n", corrected = "L X+1.0417 Y+0 Z+0 B+0 C+0 F100\n";
  const std::string shift = "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+Q1\nCYCL DEF 7.2 Y+Q2\nL X+5\n";
  // The way back stands in front of the whole definition.
  const std::string back = corrected + "L X+1.0000\n";
  EXPECT_REWRITTEN(passing, all + shift + "CYCL DEF 7.1 X+0\n" + all, back + shift + "CYCL DEF 7.1 X+0\n" + all);
  EXPECT_REWRITTEN(passing, all + shift + "CYCL DEF 7.1 X+0\nCYCL DEF 7.2 Y-0\n" + all,
                   back + shift + "CYCL DEF 7.1 X+0\nCYCL DEF 7.2 Y-0\n" + corrected);
  // A program that is called has the shift of its caller, along which axes is not known.
  const std::string called = all + shift + "CALL PGM A\nEND PGM B MM\nBEGIN PGM A MM\nCYCL DEF 7.1 X+0\n" + all;
  EXPECT_REWRITTEN(passing, called, back + called.substr(all.size()));
  for (const std::string on :
       {"CYCL DEF 7.1 X+Q1", "CYCL DEF 7.1 #5", "CYCL DEF 7.1 IX+0", "CYCL DEF 7.0 DATUM SHIFT ~", "CYCL DEF 8.1 Z",
        "CYCL DEF 10.1 ROT+30", "CYCL DEF 10.1 IROT+0", "CYCL DEF 10.1 ROT+Q1", "CYCL DEF 19.1 B+Q1",
        "CYCL DEF 10 ROTATION"})
    EXPECT_REFUSED(options, on + "\nL X+1 F100\n", "line 1");
}

TEST(ByRest, APercentSignMayHaveABlockNumber) {
  EXPECT_REWRITTEN(kAtZero, "N1 %\nO1\nG1 X1. F100\nN194 %\nG1 X5.\n", "N1 %\nO1\nG1 X1.0417 F100\nN194 %\nG1 X5.\n");
}

}  // namespace
}  // namespace axiscal::nc
