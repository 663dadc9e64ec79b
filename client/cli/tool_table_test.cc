#include "client/cli/tool_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace axiscal::cli {
namespace {

using ::testing::HasSubstr;

std::string Shown(const std::string& text) {
  const auto tools = ParseToolTable(text, "tools");
  if (!tools.ok()) return std::string(tools.status().message());
  std::string shown;
  for (const nc::ToolLength& length : tools->lengths)
    absl::StrAppend(&shown, length.number, "=", length.length_mm, " ");
  return shown;
}

TEST(ToolTable, FormsOfTheControls) {
  EXPECT_EQ(Shown("; LinuxCNC\nT1 P1 D6.0 Z+120.5 ;drill Z5\nT2 P2 Z0.0\nT17 P3 D0.5 Z-1.25\n"), "1=120.5 17=-1.25 ");
  EXPECT_EQ(Shown("%\nG10 L10 P1 R120.5 (A)\nG90 G10 L11 P1 R-.5\nG10L10P12R30.\nG10 L12 P1 R6.\n%\n"), "1=120 12=30 ");
  EXPECT_EQ(Shown("G20\nG10 L10 P1 R1.\n"), "1=25.4 ");
  EXPECT_EQ(Shown("$TC_TP2[1]=\"MILL\"\n$TC_DP1[1,1]=120\n$TC_DP3[1,1]=80.25\n$TC_DP12[1,1]=0.05\n$TC_DP3[2,2]=10\n"),
            "1=80.3 2=10 10001=80.3 20002=10 ");
  // D1 of each tool; where they are the same the tool need not be known.
  EXPECT_EQ(Shown("$TC_DP3[1,1]=5\n$TC_DP3[2,1]=6\n$TC_DP3[3,2]=7\n$TC_DP3[4,2]=7\n"),
            "2=7 10001=5 20001=6 30002=7 40002=7 ");
  EXPECT_EQ(Shown("BEGIN TOOL .T MM\nT     NAME        L        R      DL\n0     ZERO        +0       +0     +0\n"
                  "1     MILL 6      +101.25  +3     -0.25\n7     L           +50\n[END]\n9 X 1 2 3\n"),
            "1=101 7=50 ");
}

TEST(ToolTable, BadTablesAreRefusedWithTheLine) {
  EXPECT_THAT(Shown("G1 X5\n"), HasSubstr("holds no tool"));
  EXPECT_THAT(Shown("T1 P1 Z5\nT1 P2 Z6\n"), HasSubstr("line 2: number 1 stands there twice"));
  EXPECT_THAT(Shown("T1.5 P1 Z5\n"), HasSubstr("line 1: number 1.5"));
  EXPECT_THAT(Shown("G10 L10 P1\n"), HasSubstr("expected G10 L10 P5 R120.5"));
  EXPECT_THAT(Shown("G91 G10 L10 P1 R5\n"), HasSubstr("in G90"));
  EXPECT_THAT(Shown("$TC_DP3[1,1]=R5\n"), HasSubstr("expected plain numbers"));
  EXPECT_THAT(Shown("$TC_DP3[1,1]=5\n$TC_DP3[1,1]=6\n"), HasSubstr("line 2: number 1 stands there twice"));
  EXPECT_THAT(Shown("$TC_DP3[1.5,1]=5\n"), HasSubstr("line 1: tool 1.5"));
  EXPECT_THAT(Shown("BEGIN TOOL .T MM\nNAME R\n"), HasSubstr("line 2: expected the names of the columns"));
  EXPECT_THAT(Shown("BEGIN TOOL .T MM\nT  L\n1  ABC\n"), HasSubstr("L = 'ABC'"));
}

std::string ShownRadii(const std::string& text) {
  const auto tools = ParseToolTable(text, "tools");
  if (!tools.ok()) return std::string(tools.status().message());
  std::string shown;
  for (const nc::ToolRadius& radius : tools->radii) absl::StrAppend(&shown, radius.number, "=", radius.radius_mm, " ");
  return shown;
}

TEST(ToolTable, RadiiStandBesideLengths) {
  EXPECT_EQ(ShownRadii("T1 P1 D6.0 Z+120.5\nT2 P2 Z0.0\n"), "1=3 ");
  EXPECT_EQ(ShownRadii("G10 L10 P1 R120.5\nG10 L12 P1 R6.\nG10 L13 P1 R-.5\n"), "1=5.5 ");
  EXPECT_EQ(ShownRadii("$TC_DP3[1,1]=80.25\n$TC_DP6[1,1]=4\n$TC_DP15[1,1]=0.25\n"), "1=4.25 10001=4.25 ");
  EXPECT_EQ(ShownRadii("BEGIN TOOL .T INCH\nT  L   R     DR\n1  +2  +0.5  -0.1\n2  +3\n"), "1=10.16 ");
  EXPECT_EQ(ShownRadii("$TC_DP6[1,1]=5\n$TC_DP6[2,1]=6\n"), "10001=5 20001=6 ");
  // A drill has no radius: D1 alone does not say that it is the mill's.
  EXPECT_EQ(ShownRadii("$TC_DP3[1,1]=80\n$TC_DP3[2,1]=80\n$TC_DP6[2,1]=6\n"), "20001=6 ");
}

}  // namespace
}  // namespace axiscal::cli
