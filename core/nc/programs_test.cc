// Whole programs as the controllers' users write them: which lines change, which are passed, which refuse.
#include <set>
#include <sstream>

#include "core/base/units.h"
#include "core/nc/testing/rewritten.h"

namespace axiscal::nc {
namespace {

using testing::LeaningHead;
using testing::PerfectMachine;

struct Program {
  const char* dialect;
  const char* text;
  std::set<int> changed;  // lines that are corrected and differ by it
  std::set<int> refused;  // lines that refuse it
  std::set<std::string> returns;  // lines in front of passed ones: back to where the program says
};

const std::vector<Program>& Programs() {
  static const auto* const programs = new std::vector<Program>{
      {"fanuc",
       "%\nO1234 (POCKET 12 MM)\n(T1 D=12.)\nN10 G21 G17 G40 G49 G80 G90 G94\nN20 G91 G28 Z0.\nN30 T1 M6\nN40 G90 G54 "
       "G0 X0. Y0. B0. "
       "C0. S8000 M3\nN50 G43 H1 Z50. M8\nN60 G0 Z5.\nN70 G1 Z-2. F300\nN80 X50. F1200\nN90 G3 X60. Y10. I0. "
       "J10.\nN100 G1 Y40.\n"
       "N110 G41 D1 X20.\nN120 G40 X0.\nN130 G0 Z50.\nN140 G81 X10. Y10. Z-8. R2. F200\nN150 X20.\nN160 G80\nN170 G0 "
       "X5. Y5. Z50. B0. "
       "C0.\nN180 M9\nN190 G91 G28 Z0. M5\nN200 M30\n%\n",
       {8, 11, 12, 20},
       {14},
       {"G01 X60.0000"}},
      {"mazak",
       "<1010-1>(MEASURING)\nG0 G18 G21 G40 G80 G90 G94 G97\nPOPEN\nG17\nT23 M6(INTENEW)\nG91 G0 G28 X0 Y0\nG28 "
       "Z0\nG90\nG54.1 P5\n"
       "G0 X-50. Y0. Z0. B0.0000 C0.0000\nDPRNT[Number*of*Points*40]\nG00 X-390.0000 Y0.0000 Z-452.0000\nG31 "
       "Z-472.0000 F100.\n"
       "M30\n(A-01674600B00012\n",
       {10, 12},
       {13, 15},
       {"G00 X-390.0000"}},
      {"haas",
       "%\nO00042\nG00 G17 G20 G40 G80 G90\nT2 M06\nG54 G00 X0. Y0. B0. C0.\nG43 H01 Z1.\nG187 P3\nG01 X1.5 F60.\nG02 "
       "X2. Y.5 R.5\n"
       "G01 Y2.\nG12 I.5 F10. D1\nG00 Z1.\nG53 G00 Z0.\nM97 P1000\nM30\n%\n",
       {6, 8, 9},
       {11, 14},
       {"G01 X2.00000"}},
      {"linuxcnc",
       "(five axis demo)\nG21 G90 G40 G64 P0.01\nG0 X0 Y0 Z10 B0 C0\nG93\nG1 X1 Y1 Z0 B5 C10 F30\nX2 B6 C12 F30\no100 "
       "call [1]\nM2\n",
       {3, 5, 6},
       {7},
       {"G01 X2.0000 Z0.0000 F1000."}},
      {"sinumerik",
       "%_N_PART_MPF\n;$PATH=/_N_WKS_DIR/_N_A_WPD\nN10 G0 G90 G17 G40 G500 X0 Y0 Z100 B0 C0 D0\nN20 "
       "MSG(\"ROUGH\")\nN30 SOFT FFWON\n"
       "N40 G1 X10 F=1000\nN50 G3 X20 Y10 CR=10\nN60 CYCLE800(1,\"T\",0,57,0,0,0,30,0,0,0,0,0,1)\nN70 X30\nN80 "
       "CYCLE800()\nN90 SUPA G0 Z0\n"
       "N100 R1=R2+5\nN110 M30\n",
       {3, 6, 7, 9},  // X30 is told its G03 again
       {8, 12},
       {"G01 X20.0000"}},
      {"heidenhain",
       "0 BEGIN PGM 12 MM\n1 BLK FORM 0.1 Z X+0 Y+0 Z-20\n2 BLK FORM 0.2 X+100 Y+100 Z+0\n3 L X+0 Y+0 Z+50 B+0 C+0 R0 "
       "FMAX M3\n"
       "4 L X+10 F2000\n5 L Y+20\n6 CR X+20 Y+10 R+20 DR-\n7 RND R2\n8 L X+0 Y+0 Z+50 B+0 C+0 R0 FMAX\n9 PLANE SPATIAL "
       "SPA+0 SPB+30 SPC+0 "
       "STAY\n10 L X+5\n11 L Z+0 R0 FMAX M91\n12 END PGM 12 MM\n",
       {4, 5, 7, 9},
       {11},  // no tool length is stated
       {"L X+0.0000 FMAX"}},
  };
  return *programs;
}

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

RewriteOptions Stated(const std::string& dialect) {
  RewriteOptions options = testing::kAtZero;
  options.dialect = dialect;
  options.work_offsets = {{"G54", {}}, {"G54.1 P5", {}}};
  options.tool_lengths = {{1, 0.0}};
  return options;
}

TEST(Programs, ANullCorrectionReturnsEveryProgramInEveryDialect) {
  for (const Program& program : Programs()) {
    for (const Dialect& dialect : Dialects()) {
      for (const auto mode : {OnUnsupported::kRefuse, OnUnsupported::kPass, OnUnsupported::kStop}) {
        RewriteOptions options = Stated(dialect.name);
        options.on_unsupported = mode;
        RewriteReport report;
        const auto text = RewriteText(program.text, PerfectMachine(), options, &report);
        ASSERT_TRUE(text.ok()) << text.status();
        EXPECT_EQ(*text, program.text);
      }
    }
  }
}

TEST(Programs, WhatCannotBeCorrectedRefusesWithItsLines) {
  for (const Program& program : Programs()) {
    RewriteReport report;
    EXPECT_FALSE(RewriteText(program.text, LeaningHead(), Stated(program.dialect), &report).ok()) << program.dialect;
    std::set<int> refused;
    for (const Finding& finding : report.refused) refused.insert(static_cast<int>(finding.line));
    EXPECT_EQ(refused, program.refused) << program.dialect << reports::ToJson(ReportOf(report));
  }
}

TEST(Programs, PassedOnTheOtherLinesStayByteForByte) {
  for (const Program& program : Programs()) {
    RewriteOptions options = Stated(program.dialect);
    options.on_unsupported = OnUnsupported::kPass;
    const testing::Outcome outcome = testing::Rewritten(program.text, options);
    ASSERT_TRUE(outcome.status.ok()) << outcome.status;
    const std::vector<std::string> before = Lines(program.text);
    std::vector<std::string> after = Lines(outcome.text);
    // In front of what is passed, blocks of their own lead back to where the program says.
    std::erase_if(after, [&](const std::string& line) { return program.returns.contains(line); });
    ASSERT_EQ(before.size() + program.returns.size(), Lines(outcome.text).size()) << outcome.text;
    ASSERT_EQ(before.size(), after.size()) << outcome.text;
    std::set<int> changed;
    for (size_t i = 0; i < before.size(); ++i) {
      if (before[i] != after[i]) changed.insert(static_cast<int>(i) + 1);
    }
    EXPECT_EQ(changed, program.changed) << program.dialect << "\n" << outcome.text;
  }
}

}  // namespace
}  // namespace axiscal::nc
