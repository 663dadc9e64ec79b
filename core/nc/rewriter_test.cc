// Golden byte comparisons of single behaviours: what users of other tools complain of (see the table in README.md).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <sstream>

#include "core/base/crc32c.h"
#include "core/base/error_detail.h"
#include "core/nc/rewrite.h"
#include "core/nc/testing/rewritten.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using testing::LeaningHead;
using ::testing::Not;
using testing::PerfectMachine;
using ::testing::StartsWith;

using testing::From;
using testing::kAtZero;
using testing::MarkLine;
using testing::Outcome;
using testing::Rewritten;

TEST(Rewriter, OnlyCorrectedWordsChange) {
  EXPECT_REWRITTEN(testing::InMm(), "G01 X-390.0000 Y0.0000 Z-112.2605 B0.0000 C0.0000 F2000\n",
                   "G01 X-389.9583 Y0.0000 Z-112.2605 B0.0000 C0.0000 F2000\n");
  // 45 degrees: (+29.46, -29.46) um. The order of words, blanks and cases stay.
  EXPECT_REWRITTEN(testing::InMm(), "n10 g0 f2000 c0 b45.  z-112.2605   x-390.0 y0 (to the start) m3 s200\n",
                   "n10 g0 f2000 c0 b45.  z-112.2900   x-389.9705 y0 (to the start) m3 s200\n");
}

TEST(Rewriter, MissingWordsAreInsertedBehindTheLastAxisWord) {
  // B alone changes the corrections of X and Z; F and the comment stay behind.
  EXPECT_REWRITTEN(kAtZero, "G01 X0. Y0. Z0. B0. C0.\nB90. F500 (turn)\nX10.\n",
                   "G01 X0.0417 Y0. Z0. B0. C0.\nB90. X0.0000 Z-0.0417 F500 (turn)\nX10.\n");
  // Packed blocks stay packed, small letters small.
  EXPECT_REWRITTEN(kAtZero, "g1x0.y0.z0.b0.c0.\ng1b90.f500\n", "g1x0.0417y0.z0.b0.c0.\ng1b90.x0.0000z-0.0417f500\n");
}

TEST(Rewriter, RapidsAreCorrectedToo) { EXPECT_REWRITTEN(kAtZero, "G00 X10. Y0. Z0.\n", "G00 X10.0417 Y0. Z0.\n"); }

TEST(Rewriter, NumbersKeepTheirDecimalsOrGetTheMachines) {
  EXPECT_REWRITTEN(kAtZero, "G1 X1.234567\nX+2.5\nX.5\nX-0.04166\nX3\n",
                   "G1 X1.276225\nX+2.5417\nX0.5417\nX0.00000\nX3.0417\n");
  RewriteOptions coarse = kAtZero;
  coarse.decimals_mm = 3;
  EXPECT_REWRITTEN(coarse, "G1 X10.\n", "G1 X10.042\n");
}

TEST(Rewriter, NoNegativeZero) {
  const Outcome outcome = Rewritten("G1 X-0.0417\n", kAtZero);
  EXPECT_EQ(outcome.text, "G1 X0.0000\n");
}

TEST(Rewriter, IncrementalMovesAreDifferencesAndDoNotCollectRounding) {
  // The first one takes the correction up, the next ones only keep it: bytes stay.
  EXPECT_REWRITTEN(kAtZero, "G91 G1 X1.\nX1.\nX1. Y2.\n", "G91 G1 X1.0417\nX1.\nX1. Y2.\n");
  // 3000 steps in B: every step rounds anew, the sum does not drift.
  std::string program = "G91 G1\n";
  for (int i = 0; i < 3000; ++i) program += "B0.03\n";
  program += "G90 X0.\n";
  const Outcome outcome = Rewritten(program, kAtZero);
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  double x = 0, z = 0;
  std::istringstream lines(outcome.text);
  for (std::string line; std::getline(lines, line) && line.find("G90") == std::string::npos;) {
    if (const size_t at = line.find('X'); at != std::string::npos) x += std::stod(line.substr(at + 1));
    if (const size_t at = line.find('Z'); at != std::string::npos) z += std::stod(line.substr(at + 1));
  }
  constexpr double kHalfWordMm = 0.00005001;  // 0.0001 mm words
  EXPECT_NEAR(x, 0.0, kHalfWordMm);
  EXPECT_NEAR(z, -0.0416584, kHalfWordMm);
}

TEST(Rewriter, InchesAndMillimetresInOneProgram) {
  // 41.658 um = 0.00164 in.
  EXPECT_REWRITTEN(kAtZero, "G20 G1 X1.0\nG21 X25.4\n", "G20 G1 X1.00164\nG21 X25.4417\n");
}

TEST(Rewriter, LineEndsCommentsAndFrameStay) {
  EXPECT_REWRITTEN(
      kAtZero,
      "%\r\nO1234 (PART)\r\n\r\n(X1. Y2. IN A COMMENT)\r\nN10 G1 X1. ; WAS G2 X5\r\n;only this\r\nM30\r\n%\r\n",
      "%\r\nO1234 (PART)\r\n\r\n(X1. Y2. IN A COMMENT)\r\nN10 G1 X1.0417 ; WAS G2 X5\r\n;only this\r\nM30\r\n%\r\n");
  EXPECT_REWRITTEN(kAtZero, "G1 X1.", "G1 X1.0417");
  EXPECT_REWRITTEN(kAtZero, "\xEF\xBB\xBFG1 X1.\n\x1A", "\xEF\xBB\xBFG1 X1.0417\n\x1A");
  EXPECT_REWRITTEN(kAtZero, "G1 X  1 6.339  Y -25.409\n", "G1 X  16.3807  Y -25.409\n");
  const Outcome tail = Rewritten("%\nG1 X1.\n%\nG2 X1. (A-01674600B00\n", kAtZero);
  EXPECT_EQ(tail.text, "%\nG1 X1.0417\n%\nG2 X1. (A-01674600B00\n");
  EXPECT_THAT(TextsOf(tail.report.notes), ::testing::Contains(HasSubstr("line 4: text behind the end")));
}

// Programs may hold anything: a terminal, a log and a message of the service take what is shown of them.
TEST(Rewriter, BlocksAreShownAsPlainText) {
  RewriteReport report;
  const std::string block = "G1 X\x1B[2J\xFF\t\xC3\xA4\xE2\x82";
  EXPECT_FALSE(RewriteText(block + "\n", LeaningHead(), kAtZero, &report).ok());
  ASSERT_EQ(report.refused.size(), 1u);
  EXPECT_EQ(report.refused[0].block, "G1 X?[2J? \xC3\xA4??");
}

TEST(Rewriter, ANullCorrectionReturnsTheBytesWhateverTheyAre) {
  for (const std::string program : {"", "G1 X1.\n", "G02 X1. (nested (comment)\n#1=[2]\r\n%\n%\n%",
                                    "\x00\x01\xFF/\n/\n", "(AXISCAL COMPENSATED BY x)\nG28 Z0\n"}) {
    RewriteReport report;
    const auto text = RewriteText(program, PerfectMachine(), {}, &report);
    ASSERT_TRUE(text.ok()) << text.status();
    EXPECT_EQ(*text, program);
    EXPECT_TRUE(report.is_null_correction);
  }
  RewriteReport report;
  ASSERT_TRUE(RewriteText("G02 X1. I5.\nG28 Z0.\n", PerfectMachine(), {}, &report).ok());
  ASSERT_EQ(report.passed.size(), 2u);
  EXPECT_EQ(report.passed[1].line, 2);
  EXPECT_THAT(report.passed[1].reason, HasSubstr("G28 (reference return"));
}

TEST(Rewriter, WhatMovesAxesOtherwiseIsRefusedWithItsLine) {
  const struct {
    const char* block;
    const char* reason;
  } kCases[] = {
      {"G02 X10. I5.", "circular move"},
      {"G81 X1. Z-5. R2. F100", "canned cycle"},
      {"G31 Z-50. F100", "skip (probing)"},
      {"G38.2 Z-50. F100", "probing"},
      {"G41 D1 X5.", "cutter compensation"},
      {"G42.1 D1", "cutter compensation"},
      {"G43 H1", "tool length"},
      {"G43.4 H1", "tool length 1"},
      {"G43.6 H1", "tool centre point control"},
      {"G68.3 X0 Y0 Z0 R0", "tilted plane"},
      {"G68 R30.", "rotation"},
      {"G51.1 Z0", "mirror"},
      {"G16", "polar"},
      {"G54", "not stated"},
      {"G54.1 P5", "not stated"},
      {"G10 L2 P1 X0", "data input"},
      {"G65 P9010 A1.", "macro call"},
      {"M98 P1000", "subprogram"},
      {"M99 P100", "return"},
      {"#1=#2", "macro or expression"},
      {"#5221=5", "macro or expression"},  // a work offset
      {"#1=5 X2.", "macro or expression"},
      {"G1 X#1", "macro or expression"},
      {"X[-#102] Y[#101+#104/2]", "macro or expression"},
      {"IF[#120NE#0] GOTO 10", "macro"},
      {"WHILE [#1 LT 5] DO1", "macro"},
      {"GOTO 10", "macro"},
      {"o100 sub", "without a number"},
      {"G1 X P F15.04", "without a number"},
      {"G187.3 X5.", "unknown code"},
      {"G1 U5.", "no such axis"},
      {"G1 X5. R2.", "word R in a linear move"},
      {"G1 X5.,A30.", "macro or expression"},
      {"G1 X5. X6.", "two words X"},
      {"G0 G1 X5.", "two motion codes"},
      {"G90 X5. G91 Y1.", "two different distance"},
      {"G20 G21 X5.", "two different unit"},
      {"G94 G93 X5. F1.", "two different feed mode"},
      {"G80 X5.", "no motion code"},
      {"(rough (pass) 1)", "nested comment at column 8"},
      {"G1 X5. (open", "comment without end"},
      {"N5 /G1 X5.", "'/' inside"},
      {"G1 X1234567890123456789.", "18 digits"},
      {"G1 Z-0028000", "five digits"},
      {"G1 X5.0000000001", "nine decimals"},
      {"G1 X1e5", "word E in a linear move"},
      {"%%", "behind the closing"},
  };
  for (const auto& known : kCases) {
    const std::string block = known.block;
    const std::string head = block == "%%" ? "%\nG1 X1.\n%\n" : "G1 X1.\nY1.\n(so far good)\n";
    const Outcome outcome = Rewritten(head + block + "\nM5\n", kAtZero);
    EXPECT_EQ(outcome.status.code(), absl::StatusCode::kFailedPrecondition) << block << " -> " << outcome.text;
    const std::string message(outcome.status.message());
    EXPECT_THAT(message, HasSubstr(known.reason)) << block;
    EXPECT_THAT(message, HasSubstr("line 4: '" + block + "'"));
    EXPECT_EQ(outcome.report.refused.size(), 1u) << block;
  }
}

TEST(Rewriter, EveryRefusedBlockIsListed) {
  const Outcome outcome =
      Rewritten("G2 X1. I1.\nG1 X0. Y0. Z0. B0. C0.\nG28 X0\nX5.\nG1 X0. Y0. Z0. B0. C0.\nG41 D1\nX5.\nG40\n", kAtZero);
  ASSERT_EQ(outcome.report.refused.size(), 2u);
  EXPECT_EQ(outcome.report.refused[0].line, 1);
  EXPECT_EQ(outcome.report.refused[1].line, 6);
  EXPECT_EQ(outcome.report.blocks_refused, 3);  // with line 7, which follows from line 6
  ASSERT_EQ(outcome.report.passed.size(), 1u);
  EXPECT_EQ(outcome.report.passed[0].line, 3);
}

TEST(Rewriter, NothingReachesTheSinkBehindARefusal) {
  std::string program = "G1 X0. Y0. Z0. B0. C0.\n";
  for (int i = 0; i < 20000; ++i) program += "X1. Y1.\nX2. Y2.\n";
  size_t written = 0;
  RewriteReport report;
  const auto sink = [&written](const char*, size_t size) {
    written += size;
    return absl::OkStatus();
  };
  const auto source = [&program](const ByteSink& take) {
    RETURN_IF_ERROR(take("G2 X1. R5.\n", 11));
    return take(program.data(), program.size());
  };
  EXPECT_FALSE(RewriteProgram(source, sink, LeaningHead(), testing::InMm(), &report).ok());
  EXPECT_EQ(written, 0u);
}

TEST(Rewriter, UnknownPositionsAreRefusedUntilTheyAreProgrammed) {
  EXPECT_REFUSED(testing::InMm(), "G1 X1. Y1. Z1. B0.\n", "the position of C is unknown: never programmed");
  EXPECT_REFUSED(testing::InMm(), "G91 G1 X1.\n", "G91 from an unknown position of X");
  EXPECT_REFUSED(kAtZero, "G1 X1.\nT2 M6\nX2. Y1.\n", "not programmed since line 2");
  EXPECT_REWRITTEN(kAtZero, "G1 X1.\nT2 M6\nX2. Y1. Z1. B0. C0.\n", "G1 X1.0417\nT2 M6\nX2.0417 Y1. Z1. B0. C0.\n");
  // Behind M30 another program begins.
  EXPECT_REFUSED(kAtZero, "G1 X1.\nM30\nO2\nG1 X1.\n", "line 4");
}

TEST(Rewriter, PassedBlocksLeavePositionsUnknown) {
  RewriteOptions options = kAtZero;
  options.on_unsupported = OnUnsupported::kPass;
  EXPECT_REWRITTEN(options, "G1 X1.\nG28 Z0.\nX2.\nG1 X3. Y0. Z0. B0. C0.\nG53 G0 X0\n",
                   "G1 X1.0417\nG28 Z0.\nX2.\nG1 X3.0417 Y0. Z0. B0. C0.\nG53 G0 X0\n");
  const Outcome outcome = Rewritten("G1 X1.\nG28 Z0.\nX2.\n", options);
  ASSERT_EQ(outcome.report.passed.size(), 1u);
  EXPECT_EQ(outcome.report.blocks_passed, 2);
  EXPECT_EQ(outcome.report.blocks_corrected, 1);
}

// A move that nobody programmed must be told: where it stands, as it was written, and how far it goes.
TEST(Rewriter, TheWayBackToAPassedBlockIsNamed) {
  RewriteOptions options = kAtZero;
  options.on_unsupported = OnUnsupported::kPass;
  const Outcome outcome = Rewritten("G1 X1. F100\r\nG1 X2.\r\nG41 D1\r\nX3.\r\n", options);
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_EQ(outcome.text, "G1 X1.0417 F100\r\nG1 X2.0417\r\nG01 X2.0000\r\nG41 D1\r\nX3.\r\n");
  EXPECT_EQ(outcome.report.blocks_inserted, 1);
  EXPECT_EQ(outcome.report.blocks_going_back, 1);
  ASSERT_EQ(outcome.report.ways_back.size(), 1u);
  EXPECT_EQ(outcome.report.ways_back[0].line, 3);
  EXPECT_EQ(outcome.report.ways_back[0].block, "G01 X2.0000");
  EXPECT_NEAR(outcome.report.ways_back[0].way_mm, 0.0417, 1e-9);
  const reports::Rewrite said = ReportOf(outcome.report);
  EXPECT_EQ(said.blocks.going_back, 1);
  EXPECT_NEAR(said.ways_back.at(0).way_um, 41.7, 1e-6);
  EXPECT_EQ(Rewritten("G1 X1. F100\nG1 X2.\n", options).report.blocks_going_back, 0);
}

TEST(Rewriter, BlocksThatMayBeSkippedLeaveBothCasesSafe) {
  // Skipped or not, X of line 3 is written in full, and Y of line 2 is unknown until programmed.
  EXPECT_REWRITTEN(kAtZero, "G1 X0. Y0. Z0.\n/B90.\nB90. Y0.\n",
                   "G1 X0.0417 Y0. Z0.\n/B90. X0.0000 Z-0.0417\nB90. Y0. X0.0000 Z-0.0417\n");
  EXPECT_REFUSED(kAtZero, "/X5.\nY5.\n", "the position of X is unknown: not programmed since line 1");
  EXPECT_REFUSED(kAtZero, "/G91\nX5.\n", "modal code in a block that may be skipped");
  RewriteOptions options = kAtZero;
  options.block_delete = BlockDelete::kExecuted;
  EXPECT_REWRITTEN(options, "/2 N5 X5.\nY5.\n", "/2 N5 X5.0417\nY5.\n");
  options.block_delete = BlockDelete::kSkipped;
  EXPECT_REWRITTEN(options, "/X5.\nX6.\n/\n", "/X5.\nX6.0417\n/\n");
}

TEST(Rewriter, DwellsAndHarmlessCodesStay) {
  EXPECT_REWRITTEN(kAtZero,
                   "G21 G17 G40 G49 G80 G94 G64 P0.01\nG04 X1.5\nG4 P200\nM8\nG05.1 Q1\nT1 M6\nS100 M3\nG1 X1. Y0 Z0 "
                   "B0 C0 F100 M9\n",
                   "G21 G17 G40 G49 G80 G94 G64 P0.01\nG04 X1.5\nG4 P200\nM8\nG05.1 Q1\nT1 M6\nS100 M3\nG1 X1.0417 Y0 "
                   "Z0 B0 C0 F100 M9\n");
}

TEST(Rewriter, StatedWorkOffsetsShiftPositionsNotWords) {
  // G55 shifts B by 90 degrees: programmed B0 stands at B = 90, where the correction is in Z.
  RewriteOptions options = kAtZero;
  options.work_offsets = {{"G54", {}}, {"G55", {{"X", 100.0}, {"B", 90 * base::kRadPerDeg}}}};
  EXPECT_REWRITTEN(options, "G54 G1 X1. Y0. Z0. B0. C0.\nG55 X1. Y0. Z0. B0. C0.\n",
                   "G54 G1 X1.0417 Y0. Z0. B0. C0.\nG55 X1. Y0. Z-0.0417 B0. C0.\n");
  EXPECT_REFUSED(options, "G56\nG1 X1.\n", "G56");
}

TEST(Rewriter, IntegerWordsByStatement) {
  RewriteOptions options = kAtZero;
  options.integer_words = IntegerWords::kLeastIncrement;
  options.decimals_mm = 3;
  EXPECT_REWRITTEN(options, "G1 X10000 Y-0028000\nX10.5\n", "G1 X10042 Y-0028000\nX10.542\n");
  // 90 deg is 90000 in inch, too.
  EXPECT_REWRITTEN(options, "G20 G1 X0 B90000\n", "G20 G1 X0 B90000 Z-0.00164\n");
}

TEST(Rewriter, ALargeCorrectionStopsTheJob) {
  RewriteOptions options = kAtZero;
  options.max_correction_mm = 0.040;
  options.on_unsupported = OnUnsupported::kPass;
  EXPECT_REFUSED(options, "G1 X1.\n", "correction of X = 41.7 um, the limit is 40.0 um");
}

// What a program that shows the refusal goes by, whatever its words are.
TEST(Rewriter, ARefusalNamesItsCause) {
  RewriteOptions options = kAtZero;
  const auto cause_of = [&](const std::string& program) {
    return base::ErrorReason(testing::Rewritten(program, options).status);
  };
  EXPECT_EQ(cause_of("G1 X1.\nG41 D1 X2.\n"), "PROGRAM_REFUSED");
  options.max_correction_mm = 0.040;
  EXPECT_EQ(cause_of("G1 X1.\n"), "CORRECTION_TOO_LARGE");
  options.unit = ProgramUnit::kUnstated;
  EXPECT_EQ(cause_of("G1 X1.\n"), "UNIT_NOT_STATED");
}

TEST(Rewriter, TravelLimitsHoldForCorrectedPositions) {
  machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  machine.axes[static_cast<size_t>(machine::FindAxis(machine, "X"))].min_position = -400.0;
  machine.axes[static_cast<size_t>(machine::FindAxis(machine, "X"))].max_position = 10.0;
  const auto compensator = testing::MustCreate(machine, testing::ConstantErrors(machine, {{"EB0B", testing::kTiltRad}}),
                                               {0, 0, -testing::kToolMm});
  EXPECT_TRUE(Rewritten("G1 X9.9\n", kAtZero, compensator).status.ok());
  const Outcome outcome = Rewritten("G1 X9.9\nX9.99\n", kAtZero, compensator);
  EXPECT_THAT(std::string(outcome.status.message()),
              HasSubstr("line 2: 'X9.99': X = 10.0317 mm with its correction, beyond the travel limit of 10.0000 mm"));
}

// However long the program is: in order, without a gap, and no peak of a correction is lost.
TEST(Rewriter, ThePathIsToldInBoundedStretches) {
  constexpr int kMoves = 2500;
  std::string program = "G1 X0. Y0. Z0. B0. C0.\n";
  for (int i = 1; i < kMoves; ++i) absl::StrAppend(&program, "X", i, ". B", i == 1234 ? 90 : 0, "\n");
  const Outcome outcome = Rewritten(program, kAtZero);
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  const std::vector<Stretch>& path = outcome.report.path.stretches();
  ASSERT_GT(path.size(), Path::kMostStretches / 2);
  ASSERT_LE(path.size(), Path::kMostStretches);
  int64_t line = 0, pieces = 0;
  double way_mm = 0.0, largest_mm = 0.0, error_mm = 0.0;
  for (const Stretch& stretch : path) {
    EXPECT_EQ(stretch.first_line, line + 1);
    EXPECT_EQ(stretch.last_line - stretch.first_line + 1, stretch.pieces);
    line = stretch.last_line;
    pieces += stretch.pieces;
    EXPECT_GE(stretch.way_mm, way_mm);
    way_mm = stretch.way_mm;
    for (const double correction_mm : stretch.greatest_mm) largest_mm = std::max(largest_mm, correction_mm);
    error_mm = std::max(error_mm, stretch.before_max_mm);
  }
  EXPECT_EQ(pieces, kMoves);
  EXPECT_DOUBLE_EQ(way_mm, kMoves - 1.0);
  EXPECT_NEAR(largest_mm, 0.041658, 1e-6);
  EXPECT_EQ(error_mm, outcome.report.error_before.max_mm);
  // The block where B stands otherwise is the only one whose correction of X is another one.
  size_t x = 0;
  while (outcome.report.axes[x].axis != "X") ++x;
  int others = 0;
  for (const Stretch& stretch : path) others += stretch.least_mm[x] < 0.02;
  EXPECT_EQ(others, 1);
}

TEST(Rewriter, TheReportCountsAndPredicts) {
  const Outcome outcome = Rewritten("G1 X0. Y0. Z0. B0. C0.\nB90.\n", kAtZero);
  ASSERT_TRUE(outcome.status.ok());
  const RewriteReport& report = outcome.report;
  EXPECT_EQ(report.blocks_read, 2);
  ASSERT_EQ(report.axes.size(), 3u);
  for (const AxisSpread& axis : report.axes) {
    const double expected_mm = axis.axis == "Y" ? 0.0 : 0.041658;
    EXPECT_NEAR(axis.correction.max_mm, expected_mm, 1e-6) << axis.axis;
  }
  EXPECT_NEAR(report.error_before.max_mm, 0.041658, 1e-6);
  EXPECT_GT(report.error_after.max_mm, 0.0);
  EXPECT_LT(report.error_after.max_mm, 0.0001);  // rounding of two words to 0.0001 mm
  EXPECT_NEAR(report.max_tilt_left_rad, testing::kTiltRad, 1e-9);
  EXPECT_THAT(reports::ToJson(ReportOf(report)), HasSubstr("\"tool_point_error\""));
}

// The correction of X goes with cos B: over 90 degrees it departs from its chord by 41.66 (1 - cos 45) um = 12.2 um.
TEST(Rewriter, MovesAreSplitWhereTheCorrectionBends) {
  RewriteOptions options = kAtZero;
  options.tolerance_mm = 0.005;
  // Every byte of the block stays in the first piece; the others carry all moved axes and no N.
  EXPECT_REWRITTEN(options, "N1 G1 X0. Y0. Z0. B0. C0.\nN2 B90. C-90.0 F500 (turn)\n",
                   "N1 G1 X0.0417 Y0. Z0. B0. C0.\nN2 B45.0000 C-45.0000 X0.0295 Z-0.0295 F500 (turn)\n"
                   "X0.0000 Z-0.0417 B90.0000 C-90.0000\n");
  // G91: the pieces are differences. G93: each lasts its share of the time.
  EXPECT_REWRITTEN(options, "G91 G93 G1 B90. F2.5\r\n",
                   "G91 G93 G1 B45.0000 X0.0295 Z-0.0295 F5.0000\r\nX-0.0295 Z-0.0122 B45.0000 F5.0000\r\n");
  // Pieces of a block that may be skipped are skipped with it; rapids are not split, their path is not stated by
  // controllers.
  EXPECT_REWRITTEN(options, "X0.\n/3B90. X1.\n", "X0.0417\n/3B45.0000 X0.5295 Z-0.0295\n/3X1.0000 Z-0.0417 B90.0000\n");
  EXPECT_REWRITTEN(options, "G0 B90.", "G0 B90. Z-0.0417");
  EXPECT_REWRITTEN(options, "G1 B90.", "G1 B45.0000 X0.0295 Z-0.0295\nX0.0000 Z-0.0417 B90.0000\n");
  EXPECT_REFUSED(options, "G1 B90. M0\n",
                 "departs from linear by 12.20 um and the move cannot be split: its block has a code");
  EXPECT_REFUSED(options, "G93 G1 B90.\n", "G93 without an F word");
  const Outcome outcome = Rewritten("G1 B90.\n", options);
  EXPECT_EQ(outcome.report.blocks_split, 1);
  EXPECT_EQ(outcome.report.blocks_inserted, 1);
  EXPECT_LE(outcome.report.max_departure_mm, options.tolerance_mm);
}

TEST(Rewriter, CornersOfFanucStayWhereTheirMovesStayWhole) {
  EXPECT_REWRITTEN(kAtZero, "G1 X10.,R2. F500\nY10. ,C1.5\nX0.\nX5.,r3. Y0.\n",
                   "G1 X10.0417,R2. F500\nY10. ,C1.5\nX0.0417\nX5.0417,r3. Y0.\n");
  RewriteOptions fine = kAtZero;
  fine.tolerance_mm = 0.001;
  const std::string reason = "cannot be split: the control rounds or chamfers the corner at one of its ends";
  EXPECT_REFUSED(fine, "G1 X10. F500\nB90. X20.,R2.\n", reason);
  EXPECT_REFUSED(fine, "G1 X10.,C2. F500\nB90. X20.\n", reason);
  EXPECT_TRUE(Rewritten("G1 X10.,R2. F500\nY10.\nB90. X20.\n", fine).status.ok());
  EXPECT_REFUSED(kAtZero, "G1 X10.,R#1\n", "macro or expression");
  EXPECT_REFUSED(kAtZero, "G1 X10.,R\n", "letter without a number");
  RewriteOptions linuxcnc = kAtZero;
  linuxcnc.dialect = "linuxcnc";
  EXPECT_REFUSED(linuxcnc, "G1 X10.,R2.\n", "macro or expression");
}

TEST(Rewriter, PiecesOfAnySizeGiveTheSameOutput) {
  std::string program = "%\r\nO1\r\nG1 X0. Y0. Z0. B0. C0.\r\n";
  for (int i = 0; i < 50; ++i) program += absl::StrFormat("N%d X%d.5 B%d. (c)\r\n", i, i, i);
  RewriteReport report;
  const auto whole = RewriteText(program, LeaningHead(), testing::InMm(), &report);
  ASSERT_TRUE(whole.ok()) << whole.status();
  for (const size_t piece : {1u, 2u, 7u, 64u}) {
    std::string text;
    const auto source = [&](const ByteSink& take) {
      for (size_t at = 0; at < program.size(); at += piece) {
        RETURN_IF_ERROR(take(program.data() + at, std::min(piece, program.size() - at)));
      }
      return absl::OkStatus();
    };
    const auto sink = [&text](const char* bytes, size_t size) {
      text.append(bytes, size);
      return absl::OkStatus();
    };
    ASSERT_TRUE(RewriteProgram(source, sink, LeaningHead(), testing::InMm(), &report).ok());
    EXPECT_EQ(text, *whole) << piece;
  }
}

TEST(Rewriter, AnOverlongBlockIsRefusedAndPassedByANullCorrection) {
  const std::string program = "G1 X1.\n(" + std::string(200000, 'x') + ")\nX2.\n";
  const Outcome outcome = Rewritten(program, kAtZero);
  EXPECT_THAT(std::string(outcome.status.message()), HasSubstr("too long"));
  EXPECT_LT(std::string(outcome.status.message()).size(), 400u);
  RewriteReport report;
  EXPECT_EQ(*RewriteText(program, PerfectMachine(), {}, &report), program);
}

TEST(Rewriter, OptionsAreChecked) {
  RewriteOptions options = testing::InMm();
  options.decimals_mm = 9;
  EXPECT_THAT(std::string(Validate(options).message()), HasSubstr("decimals_mm = 9, must be 0 to 6"));
  options = {};
  options.calibration = "a) G28 (";
  EXPECT_THAT(std::string(Validate(options).message()), HasSubstr("stands in a comment"));
  options = {};
  options.dialect = "basic";
  EXPECT_THAT(std::string(Validate(options).message()), HasSubstr("must be one of: fanuc"));
  EXPECT_THAT(std::string(Rewritten("G1 X1.\n", From({{"Q", 0}})).status.message()), HasSubstr("has no axis 'Q'"));
}

}  // namespace
}  // namespace axiscal::nc
