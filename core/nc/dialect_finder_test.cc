// For which control a program may be, from its words.
#include "core/nc/dialect_finder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace axiscal::nc {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(FindDialects, AFamilysOwnWordsTell) {
  const struct {
    const char *program, *dialect, *evidence;
  } cases[] = {
      {"0 BEGIN PGM A MM\n1 L X+1 Y+2 R0 FMAX\n", "heidenhain", "line 1: '0 BEGIN PGM A MM'"},
      {"L X+10 R0 F500\n", "heidenhain", "line 1"},
      {"N10 G90 G54\nN20 G1 X=AC(5) F100\n", "sinumerik", "line 2: 'N20 G1 X=AC(5) F100'"},
      {"G0 X1\nMCALL CYCLE81(10,0,2,-20)\n", "sinumerik", "line 2"},
      {"%_N_PART_MPF\nG0 X1\n", "sinumerik", "line 1"},
      {"G21 G90\no100 sub\nG1 X1 F100\no100 endsub\n", "linuxcnc", "line 2: 'o100 sub'"},
      {"G90\n#<depth>=5\n", "linuxcnc", "line 2"},
      {"G90\no<step> sub\nG1 Z#1 F200\no<step> endsub\no<step> call [-1]\n", "linuxcnc", "line 2: 'o<step> sub'"},
      {"%\nO1 (PART)\nG90 G21\nG187 P3\n", "haas", "line 4: 'G187 P3'"},
      {"%\nO1 (PART)\nG90 G21\nG154 P3\n", "haas", "line 4"},
  };
  for (const auto& each : cases) {
    const FittingDialects found = FindDialects(each.program);
    EXPECT_THAT(found.names, ElementsAre(each.dialect)) << each.program;
    EXPECT_THAT(found.evidence, HasSubstr(each.evidence)) << each.program;
  }
}

TEST(FindDialects, WordsThatManyKnowLeaveThemAll) {
  EXPECT_THAT(FindDialects("%\nO1 (PART)\nG90 G21 G54\nG1 X1. F100\nM30\n%\n").names,
              ElementsAre("fanuc", "haas", "linuxcnc"));
  // Nothing here is of one family, comments neither.
  EXPECT_THAT(FindDialects("G90\nG1 X1. F100\n").names, ElementsAre("fanuc", "haas", "linuxcnc", "sinumerik"));
  EXPECT_THAT(FindDialects("").names, ElementsAre("fanuc", "haas", "linuxcnc", "sinumerik"));
  // A block that nobody reads tells nothing.
  EXPECT_THAT(FindDialects("G90 G21 (A)\nWHO KNOWS\n").names, ElementsAre("fanuc", "haas", "linuxcnc"));
}

TEST(FindDialects, CommentsAndListingsInFrontTellNothing) {
  EXPECT_THAT(FindDialects("%\nO1 (DRILL #<5 DIA)\nG90 G21 G54\nG1 X1. F100\nM30\n%\n").names,
              ElementsAre("fanuc", "haas", "linuxcnc"));
  EXPECT_THAT(FindDialects("; DRILL #5\nG90\nG1 X1. F100\n").names, Contains("sinumerik"));
  EXPECT_THAT(FindDialects("TOOL CALL 5 is the drill\n%\nO1 (PART)\nG90 G21\nG187 P3\n").names, ElementsAre("haas"));
}

// G154 is of Haas, o100 sub of LinuxCNC: neither reads the other's.
TEST(FindDialects, WhoReadsWhatTheOtherDoesNotIsNotLeftOut) {
  EXPECT_THAT(FindDialects("G90 (A)\nG154 P2\no100 sub\no100 endsub\n").names, ElementsAre("haas", "linuxcnc"));
}

}  // namespace
}  // namespace axiscal::nc
