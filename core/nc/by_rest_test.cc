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
  for (const std::string on : {"ROT Z30", "TRANS X10", "ATRANS X10", "MIRROR X0"})
    EXPECT_REWRITTEN(passing, on + "\nX5\nTRANS\n" + all, on + "\nX5\nTRANS\n" + corrected);
  for (const std::string stays : {"ROT Z30\nX5\nATRANS", "ROT Z30\nX5\nMCALL", "TRANS X10\nX5\nCYCLE800()",
                                  "CYCLE800(1,\"TC\",0,57,0,0,0,30,0,0,0,0,0,1)\nX5\nTRANS", "TRANS X10\n/TRANS"}) {
    const Outcome outcome = Rewritten(all + stays + "\n" + all, passing);
    EXPECT_EQ(outcome.text.rfind(corrected), outcome.text.find(corrected)) << outcome.text;
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
  const std::string shift = "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+10\nCYCL DEF 7.2 Y+5\nL X+5\n";
  // The way back stands in front of the whole definition.
  const std::string back = corrected + "L X+1.0000\n";
  EXPECT_REWRITTEN(passing, all + shift + "CYCL DEF 7.1 X+0\n" + all, back + shift + "CYCL DEF 7.1 X+0\n" + all);
  EXPECT_REWRITTEN(passing, all + shift + "CYCL DEF 7.1 X+0\nCYCL DEF 7.2 Y-0\n" + all,
                   back + shift + "CYCL DEF 7.1 X+0\nCYCL DEF 7.2 Y-0\n" + corrected);
  // A program that is called has the shift of its caller, along which axes is not known.
  const std::string called = all + shift + "CALL PGM A\nEND PGM B MM\nBEGIN PGM A MM\nCYCL DEF 7.1 X+0\n" + all;
  EXPECT_REWRITTEN(passing, called, back + called.substr(all.size()));
  for (const std::string on :
       {"CYCL DEF 7.1 X+Q1", "CYCL DEF 7.1 #5", "CYCL DEF 7.1 IX+0", "CYCL DEF 7.0 DATUM SHIFT ~", "CYCL DEF 8.1 X",
        "CYCL DEF 10.1 ROT+30", "CYCL DEF 10.1 IROT+0", "CYCL DEF 10.1 ROT+Q1", "CYCL DEF 19.1 B+0",
        "CYCL DEF 10 ROTATION"})
    EXPECT_REFUSED(options, on + "\nL X+1 F100\n", "line 1");
}

TEST(ByRest, APercentSignMayHaveABlockNumber) {
  EXPECT_REWRITTEN(kAtZero, "N1 %\nO1\nG1 X1. F100\nN194 %\nG1 X5.\n", "N1 %\nO1\nG1 X1.0417 F100\nN194 %\nG1 X5.\n");
}

}  // namespace
}  // namespace axiscal::nc
