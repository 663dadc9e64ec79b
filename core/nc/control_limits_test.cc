// What controls make of corrected blocks: the meaning of F, and the length of a block.
#include "core/nc/testing/rewritten.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using testing::kAtZero;

RewriteOptions In(const std::string& dialect) {
  RewriteOptions options = kAtZero;
  options.dialect = dialect;
  return options;
}

// LinuxCNC takes F for mm/min as soon as X, Y or Z moves, and for deg/min else.
TEST(ControlLimits, AFeedMoveOfRotaryAxesAloneKeepsTheMeaningOfF) {
  for (const char* dialect : {"linuxcnc", "haas", "sinumerik"}) {
    EXPECT_REFUSED(In(dialect), "G94 G1 B90 F360\n", "a feed move of rotary axes alone");
    EXPECT_REFUSED(In(dialect), "G94 G1 X1 F100\nG1 X1 B90 F360\n", "a feed move of rotary axes alone");
    // C needs no other word, rapids have no F, G93 states the time, and with X and Z on their way F is theirs.
    for (const char* fine : {"G94 G1 X1\nG1 C90 F360\n", "G0 B90\n", "G93 G1 B90 F2\n", "G94 G1 X10 B90 F360\n"})
      EXPECT_TRUE(testing::Rewritten(fine, In(dialect)).status.ok()) << dialect << fine;
  }
  EXPECT_REFUSED(In("heidenhain"), "L B+90 R0 F360\n", "a feed move of rotary axes alone");
  EXPECT_TRUE(testing::Rewritten("L B+90 R0 FMAX\n", In("heidenhain")).status.ok());
  // Fanuc counts degrees as mm in one speed of all axes.
  for (const char* dialect : {"fanuc", "mazak"})
    EXPECT_TRUE(testing::Rewritten("G94 G1 B90. F360\n", In(dialect)).status.ok()) << dialect;
}

TEST(ControlLimits, AFeedMoveOfRotaryAxesAloneIsPassedWhereThatMovesNothingElse) {
  RewriteOptions passing = In("linuxcnc");
  passing.on_unsupported = OnUnsupported::kPass;
  // X stands at 1 before it: no linear axis moves at the F of a rotary one, whether the block names it or not.
  EXPECT_REWRITTEN(passing, "G1 X1 F100\nB90 F360\nG0 X2\n",
                   "G1 X1.0417 F100\nG01 X1.0000\nB90 F360\nG0 X2 Z-0.0417\n");
  EXPECT_REWRITTEN(passing, "G1 X1 F100\nX1 B90 F360\nG0 X2\n",
                   "G1 X1.0417 F100\nG01 X1.0000\nX1 B90 F360\nG0 X2 Z-0.0417\n");
}

TEST(ControlLimits, BlocksAreNoLongerThanTheControlReads) {
  // LinuxCNC reads 252 characters and a line end.
  const auto block = [](size_t size) {
    std::string text = "G1 X1.5 (";
    text += std::string(size - text.size() - 1, 'c') + ")";
    return text + "\n";
  };
  // Three decimals more: X1.5417.
  const testing::Outcome fits = testing::Rewritten(block(249), In("linuxcnc"));
  ASSERT_TRUE(fits.status.ok()) << fits.status;
  EXPECT_EQ(fits.text.size(), 253u);
  EXPECT_REFUSED(In("linuxcnc"), block(250), "the block has 254 bytes with its line end, and the control reads 253");
  EXPECT_REFUSED(In("linuxcnc"), "(" + std::string(300, 'c') + ")\nG1 X1.5\n", "line 1");
  EXPECT_TRUE(testing::Rewritten(block(400), In("fanuc")).status.ok());
  const std::string comment = "; " + std::string(500, 'c');
  EXPECT_REFUSED(In("sinumerik"), "G1 X1.5 " + comment + "\n", "the control reads 512");
  EXPECT_TRUE(testing::Rewritten("G1 X1.5 ; " + std::string(480, 'c') + "\n", In("sinumerik")).status.ok());
}

}  // namespace
}  // namespace axiscal::nc
