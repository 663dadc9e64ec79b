// Words of Sinumerik that say their distance themselves, and corners that the control rounds.
#include "core/base/units.h"
#include "core/nc/testing/rewritten.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using testing::kAtZero;

RewriteOptions Sinumerik() {
  RewriteOptions options = testing::kAtZero;
  options.dialect = "sinumerik";
  return options;
}

TEST(Sinumerik, DistancesInWordsKeepTheirBytes) {
  EXPECT_REWRITTEN(Sinumerik(), "G1 X=AC(10) F500\nX=IC( 5.0 ) Y=ic(1)\nG91 X = AC(3.5) Y1\nX1 M8\nG90 G0 B=AC(90)\n",
                   "G1 X=AC(10.0417) F500\nX=IC( 5.0 ) Y=ic(1)\nG91 X = AC(3.5417) Y1\nX1 M8\n"
                   "G90 G0 B=AC(90) X4.5000 Z-0.0417\n");
  EXPECT_REWRITTEN(Sinumerik(), "G1 X10 F500\nG3 X0 Y10 I=AC(0) J=AC(0)\nG2 X10 Y0 I=IC(0) J=IC(-10)\n",
                   "G1 X10.0417 F500\nG3 X0.0417 Y10 I=AC(0.0417) J=AC(0)\nG2 X10.0417 Y0 I=IC(0) J=IC(-10)\n");
  EXPECT_REFUSED(Sinumerik(), "G1 X=IC(R1)\n", "line 1: 'G1 X=IC(R1)': letter without a number");
  EXPECT_REFUSED(Sinumerik(), "G1 X=IC(5\n", "macro or expression");
  EXPECT_REFUSED(Sinumerik(), "G1 X=IC(5+2)\n", "macro or expression");
  EXPECT_REFUSED(Sinumerik(), "G1 X=QU(5)\n", "without a number");
  EXPECT_REFUSED(Sinumerik(), "G1 X10\nG3 X0 Y10 CR=AC(10)\n", "radius");
}

// A word of the block for other spindles is none of the axes.
TEST(Sinumerik, WordsOfOtherSpindlesStay) {
  EXPECT_REWRITTEN(Sinumerik(), "G1 X1 S2=8000 M2=3 F500\nX2 FB=200\nX3\n",
                   "G1 X1.0417 S2=8000 M2=3 F500\nX2.0417 FB=200\nX3.0417\n");
  EXPECT_REFUSED(Sinumerik(), "G1 X1 Y2=5\n", "macro or expression");
}

TEST(Sinumerik, TheWayRoundOfARotaryAxis) {
  EXPECT_REFUSED(Sinumerik(), "G1 X=DC(5)\n", "word X5: a way round is of rotary axes");
  EXPECT_REFUSED(Sinumerik(), "G1 C=DC(360)\n", "word C360: a position of an axis that counts from 0 to 360 deg");
  EXPECT_REFUSED(Sinumerik(), "G1 C=DC(-5)\n", "counts from 0 to 360 deg");
  EXPECT_REFUSED(Sinumerik(), "G1 C=DC(180)\n", "half a turn: which way the axis goes is not known");
  RewriteOptions turning = Sinumerik();
  turning.orientation = true;
  EXPECT_REFUSED(turning, "G1 C=ACP(90)\n", "a stated sense of rotation while rotary axes are corrected");
}

struct Path {
  std::string text;
  RewriteReport report;
  VerifyReport verified;
};

// On a machine whose C runs out three times a turn: the correction bends.
Path Compensated(const std::string& program, bool orientation = false) {
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  auto errors =
      testing::ConstantErrors(machine, {{"EX0C", 0.02}, {"EX0C", 0.05}, {"EA0C", 4e-5}, {"EB0B", testing::kTiltRad}});
  errors.terms[0].shape = shapes::Harmonic{machine::FindAxis(machine, "C"), 3.0};
  RewriteOptions options = testing::InMm();
  options.dialect = "sinumerik";
  options.tolerance_mm = 0.001;
  options.orientation = orientation;
  options.max_rotary_correction_rad = 1e-3;
  VerifyOptions verify;
  verify.reading.unit = ProgramUnit::kMillimetre;
  verify.tool_tip_mm = {0, 0, -testing::kToolMm};
  verify.reading = options;
  Path path;
  const auto text =
      RewriteText(program, testing::MustCreate(machine, errors, verify.tool_tip_mm), options, &path.report);
  EXPECT_TRUE(text.ok()) << text.status();
  if (!text.ok()) return path;
  path.text = *text;
  const auto verified = VerifyText(program, *text, machine, errors, verify);
  EXPECT_TRUE(verified.ok()) << verified.status() << *text;
  if (verified.ok()) path.verified = *verified;
  return path;
}

TEST(Sinumerik, PiecesOfATurnGoTheSameWayRound) {
  const Path shortest = Compensated("G1 X100 Y20 Z0 B0 C350 F500\nC=DC(20) X110\nC=DC(300.5) X109\nC10 X110\n");
  EXPECT_EQ(shortest.verified.moves, 4);
  EXPECT_GT(shortest.report.blocks_split, 1);
  EXPECT_THAT(shortest.text, HasSubstr("C=DC(0.0000)"));
  EXPECT_THAT(shortest.text, HasSubstr("C=DC(20.0000)\n"));
  EXPECT_LT(shortest.verified.end_after.max_mm, 0.0001);
  EXPECT_LT(shortest.verified.path_after.max_mm, 0.0012);
  EXPECT_GT(shortest.verified.path_before.max_mm, 0.02);
  // 290 degrees up, 40 down through zero, none at all.
  const Path stated =
      Compensated("G1 X100 Y20 Z0 B0 C10 F500\nC=ACP(300) Y21\nC=ACP(20) Y20\nC=ACN(340) Y21\nC=ACN(340)\n");
  EXPECT_EQ(stated.verified.moves, 5);
  EXPECT_THAT(stated.text, HasSubstr("C=ACP(358.3333)"));
  EXPECT_THAT(stated.text, HasSubstr("C=ACN(0.0000)"));
  EXPECT_LT(stated.verified.end_after.max_mm, 0.0001);
  EXPECT_LT(stated.verified.path_after.max_mm, 0.0012);
  // Rotary commands corrected too: no piece leaves 0 to 360.
  const Path turned =
      Compensated("G1 X100 Y20 Z0 B20 C350 F500\nC=DC(0) X101\nC=DC(20) X102\nC=DC(0) B30 X103\n", true);
  EXPECT_EQ(turned.verified.moves, 4);
  EXPECT_THAT(turned.text, ::testing::Not(HasSubstr("(-")));
  EXPECT_THAT(turned.text, ::testing::Not(HasSubstr("(360")));
  EXPECT_LT(turned.verified.end_after.max_mm, 0.0001);
  EXPECT_LT(turned.verified.path_after.max_mm, 0.0013);
  for (const auto& axis : turned.report.rotary_axes) EXPECT_LT(axis.correction.max_rad, 1e-3);
}

TEST(Sinumerik, CornersAreRoundedByTheControlWhereTheirMovesStayWhole) {
  EXPECT_REWRITTEN(Sinumerik(), "G1 X10 RND=2 F500\nY10 CHF=1.5 FRC=200\nX0 CHR=1\nRNDM=3\nY0\nX5\nRNDM=0\nX6\n",
                   "G1 X10.0417 RND=2 F500\nY10 CHF=1.5 FRC=200\nX0.0417 CHR=1\n\nY0 RND=3\nX5.0417\n\n"
                   "X6.0417\n");
  RewriteOptions fine = Sinumerik();
  fine.tolerance_mm = 0.001;
  const std::string reason = "the control rounds or chamfers no corner beside a move that leaves the working plane";
  EXPECT_REFUSED(fine, "G1 X10 F500\nB90 X20 RND=2\n", reason);
  EXPECT_REFUSED(fine, "G1 X10 RND=2 F500\nB90 X20\n", reason);
  EXPECT_REFUSED(fine, "G1 X10 F500\nRNDM=1\nB90 X20\nY30\n", reason);
  EXPECT_TRUE(testing::Rewritten("G1 X10 RND=2 F500\nY10\nB90 X20\n", fine).status.ok());
  EXPECT_TRUE(testing::Rewritten("RNDM=1\nG1 X10 F500\nRNDM=0\nZ5\nB90 X20\n", fine).status.ok());
  EXPECT_REFUSED(Sinumerik(), "G1 X10 RND=R5\n", "without a number");
}

TEST(Sinumerik, ALengthIsOfOneTool) {
  RewriteOptions options = Sinumerik();
  options.tool_lengths = {{1, 0.0}, {2, 100.0}};
  const std::string state = "G1 X1 Y0 Z0 B0 C0\n", at_1 = "G1 X1.0417 Y0 Z0 B0 C0\n";
  const std::string reason = "D1 of another tool than before";
  EXPECT_REFUSED(options, "T1 M6\nD1\n" + state + "T2 M6\nD1\n" + state, reason);
  EXPECT_REFUSED(options, "T=\"A\" M6\nD1\n" + state + "T=\"B\"\nM6\nD1\n" + state, reason);
  EXPECT_REFUSED(options, "T1 D1\n" + state + "T2 D1\n" + state, reason);
  // The next tool is waiting in the changer.
  EXPECT_REWRITTEN(options, "T=\"A\"\nM6\nT=\"B\"\nD1\n" + state + "D0\nD1\n" + state,
                   "T=\"A\"\nM6\nT=\"B\"\nD1\n" + at_1 + "D0\nD1\n" + at_1);
  EXPECT_REWRITTEN(options, "T1 M6\nD1\n" + state + "T2 M6\nD2\n" + state + "T1 M6\nD1\n" + state,
                   "T1 M6\nD1\n" + at_1 + "T2 M6\nD2\nG1 X1.0533 Y0 Z0 B0 C0\nT1 M6\nD1\n" + at_1);
}

// A shop's program: D1 of every tool.
TEST(Sinumerik, EachToolHasItsOwnD1) {
  RewriteOptions options = Sinumerik();
  options.tool_lengths = {{NumberOfEdge(1, 1), 0.0}, {NumberOfEdge(2, 1), 100.0}};
  const std::string state = "G1 X1 Y0 Z0 B0 C0\n", at_1 = "G1 X1.0417 Y0 Z0 B0 C0\n", at_2 = "G1 X1.0533 Y0 Z0 B0 C0\n";
  EXPECT_REWRITTEN(options, "T1 M6\nT2\nD1\n" + state + "M6\nD1\nT1\n" + state + "M6\nD1\n" + state,
                   "T1 M6\nT2\nD1\n" + at_1 + "M6\nD1\nT1\n" + at_2 + "M6\nD1\n" + at_1);
  // It is of no other tool, nor of one that nobody knows.
  EXPECT_REFUSED(options, "T3 M6\nD1\n" + state, "tool length T3D1: its value is not stated");
  EXPECT_REFUSED(options, "T2\nD1\n" + state, "tool length 1: its value is not stated");
  EXPECT_REFUSED(options, "T=\"A\" M6\nD1\n" + state, "tool length 1: its value is not stated");
  EXPECT_FALSE(testing::Rewritten("T1 M6\n/T2 M6\nD1\n" + state, options).status.ok());
  const testing::Outcome asked = testing::Rewritten("T3 M6\nD1\n" + state, options);
  EXPECT_THAT(asked.report.missing, ::testing::Contains("--tool-length T3D1=..."));
  // Beside numbers by tool one without a tool is of no tool.
  options.tool_lengths.push_back({1, 100.0});
  EXPECT_REFUSED(options, "T3 M6\nD1\n" + state, "tool length T3D1: its value is not stated");
  EXPECT_REWRITTEN(options, "T1 M6\nD1\n" + state, "T1 M6\nD1\n" + at_1);
  // Alone it is that of the tool which has it first.
  options.tool_lengths = {{1, 100.0}};
  EXPECT_REWRITTEN(options, "T3 M6\nD1\n" + state, "T3 M6\nD1\n" + at_2);
  EXPECT_REFUSED(options, "T3 M6\nD1\n" + state + "T4 M6\nD1\n" + state, "tool length T4D1: its value is not stated");
}

TEST(Sinumerik, TheCuttersRadiusIsThatOfTheToolInTheSpindle) {
  RewriteOptions options = Sinumerik();
  options.tool_lengths = {{NumberOfEdge(1, 1), 0.0}, {NumberOfEdge(2, 1), 100.0}};
  options.tool_radii = {{NumberOfEdge(2, 1), 5.0}, {1, 7.0}};
  const std::string contour = "D1\nG0 X0 Y0 Z0 B0 C0\nG1 G41 X20 Y10 F100\nX40\nG40 Y40\n";
  EXPECT_TRUE(testing::Rewritten("T2 M6\n" + contour, options).status.ok());
  EXPECT_REFUSED(options, "T1 M6\n" + contour, "--tool-radius T1D1=MM");
}

TEST(Sinumerik, DifferencesBehindANewOffsetAreRefused) {
  RewriteOptions options = Sinumerik();
  options.work_offsets = {{"G54", {{"X", 100.0}}}, {"G55", {{"X", 200.0}}}};
  const std::string reason = "G91 behind a change of the tool length or of the work offset";
  EXPECT_REFUSED(options, "G54\nG1 X1\nG55\nG91 X10\n", reason);
  EXPECT_REFUSED(options, "G54\nG1 X1\nG500 X=IC(10)\n", reason);
  EXPECT_REWRITTEN(options, "G54\nG1 X1\nG55\nX5\nG91 X10\n", "G54\nG1 X1.0417\nG55\nX5.0417\nG91 X10\n");
  EXPECT_REWRITTEN(options, "G54\nG1 X1\nG55\nG91 Y10\n", "G54\nG1 X1.0417\nG55\nG91 Y10\n");
}

TEST(Sinumerik, WhatHasNoWordOfAnAxisIsRefusedWithItsReason) {
  EXPECT_REFUSED(Sinumerik(), "G1 AP=30 RP=20\n", "AP (polar coordinates: no word of an axis could be corrected)");
  EXPECT_REFUSED(Sinumerik(), "G1 RP=20\n", "RP (polar coordinates");
  EXPECT_REFUSED(Sinumerik(), "G1 X10 ANG=30\n", "a line by its angle");
  EXPECT_REFUSED(Sinumerik(), "G3 X10 Y10 AR=90\n", "opening angle");
  EXPECT_REFUSED(Sinumerik(), "G3 X0 Y0 I5 J0 Z-5 TURN=3\n", "a helix of several turns");
}

}  // namespace
}  // namespace axiscal::nc
