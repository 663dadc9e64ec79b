// Arcs and corners of Klartext.
#include "core/base/units.h"
#include "core/nc/interpreter.h"
#include "core/nc/testing/rewritten.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using testing::kAtZero;
using ::testing::Not;

RewriteOptions Klartext() {
  RewriteOptions options = testing::kAtZero;
  options.dialect = "heidenhain";
  return options;
}

// The centre goes along with the arc: a CC line in front of it, once for arcs of one centre.
TEST(Klartext, ArcsAboutAPoleGetTheirCentre) {
  EXPECT_REWRITTEN(
      Klartext(),
      "1 L X+10 Y+0 F500\n2 CC X+0 Y+0\n3 C X+0 Y+10 DR+\n4 C X+10 Y+0 DR- M8\n5 C X+10 Y+0 DR+ R0\n6 L X+5\n",
      "1 L X+10.0417 Y+0 F500\n2 CC X+0 Y+0\nCC X+0.0417 Y+0.0000\n3 C X+0.0417 Y+10 DR+\n"
      "4 C X+10.0417 Y+0 DR- M8\n5 C X+10.0417 Y+0 DR+ R0\n6 L X+5.0417\n");
  // CC where the tool stands, and counted from there.
  EXPECT_REWRITTEN(Klartext(),
                   "1 L X+0 Y+0 F500\n2 CC\n3 L X+10\n4 C X-10 Y+0 DR+\n5 CC IX+20 IY+0\n6 C IX+20 IY-20 DR+\n",
                   "1 L X+0.0417 Y+0 F500\n2 CC\n3 L X+10.0417\nCC X+0.0417 Y+0.0000\n4 C X-9.9583 Y+0 DR+\n"
                   "5 CC IX+20 IY+0\nCC X+10.0417 Y+0.0000\n6 C IX+20 IY-20 DR+\n");
  // A block that may be skipped leaves either pole.
  EXPECT_REWRITTEN(Klartext(), "1 L X+10 Y+0 F500\n2 CC X+0 Y+0\n/3 C X+10 Y+0 DR+\n4 L X+10 Y+0\n5 C X+0 Y+10 DR+\n",
                   "1 L X+10.0417 Y+0 F500\n2 CC X+0 Y+0\nCC X+0.0417 Y+0.0000\n/3 C X+10.0417 Y+0 DR+\n"
                   "4 L X+10.0417 Y+0\nCC X+0.0417 Y+0.0000\n5 C X+0.0417 Y+10 DR+\n");
}

TEST(Klartext, ArcsOfARadius) {
  EXPECT_REWRITTEN(Klartext(), "1 L X+10 Y+0 F500\n2 CR X+0 Y+10 R+10 DR+\n3 CR X+10 Y+0 R-10.000 DR+ R0 F200\n",
                   "1 L X+10.0417 Y+0 F500\n2 CR X+0.0417 Y+10 R+10 DR+\n3 CR X+10.0417 Y+0 R-10.000 DR+ R0 F200\n");
}

TEST(Klartext, ArcsThatCannotBeFollowedSayWhy) {
  const std::string head = "1 L X+10 Y+0 F500\n";
  EXPECT_REFUSED(Klartext(), head + "C X+0 Y+10 DR+\n", "its centre is not known: no CC block states it in numbers");
  EXPECT_REFUSED(Klartext(), head + "CC X+Q1 Y+0\nC X+0 Y+10 DR+\n",
                 "line 3: 'C X+0 Y+10 DR+': circular move: its centre");
  EXPECT_REFUSED(Klartext(), head + "CC X+0\nC X+0 Y+10 DR+\n", "its centre is not known");
  EXPECT_REFUSED(Klartext(), head + "CC Z+0 X+0\nC X+0 Y+10 DR+\n", "its centre is not known");
  EXPECT_REFUSED(Klartext(), head + "CC X+0 Y+0\nC X+0 Y+10\n", "a circular move without DR");
  EXPECT_REFUSED(Klartext(), head + "CC X+0 Y+0\nC DR+\n", "without a word of X or Y");
  EXPECT_REFUSED(Klartext(), head + "CC X+0 Y+0\nC X+0 Y+10 Z-1 DR+\n", "a word of Z in it");
  EXPECT_REFUSED(Klartext(), head + "CC X+0 Y+0\nC X+0 Y+10 DR+ FMAX\n", "a rapid one");
  EXPECT_REFUSED(Klartext(), head + "CC X+0 Y+0\nC X+0 Y+11 DR+\n", "1.0000 mm off the circle about its centre");
  EXPECT_REFUSED(Klartext(), head + "CC X+0 Y+0\nC X+0 Y+10 DR+ RL\n", "cutter compensation");
  EXPECT_REFUSED(Klartext(), head + "CR X+0 Y+10 DR+\n", "it has no radius");
  EXPECT_REFUSED(Klartext(), head + "CC X+0 Y+0\nC X+0 Y+10 DR+\nX+5\n", "axis words without L or C behind an arc");
  EXPECT_REFUSED(Klartext(), head + "L X+0 DR+\n", "the sense of an arc without one");
  EXPECT_REFUSED(Klartext(), head + "CT X+0 Y+10\n", "its centre follows from the block before");
  EXPECT_REFUSED(Klartext(), head + "CC X+0 Y+0\nLP PR+5 PA+0\n", "no word of an axis could be corrected");
}

TEST(Klartext, CornersAreRoundedByTheControlWhereTheirMovesStayWhole) {
  EXPECT_REWRITTEN(Klartext(), "1 L X+10 Y+0 F500\n2 RND R2 F100\n3 L Y+10\n4 CHF 1.5\n5 L X+0\n",
                   "1 L X+10.0417 Y+0 F500\n2 RND R2 F100\n3 L Y+10\n4 CHF 1.5\n5 L X+0.0417\n");
  RewriteOptions fine = Klartext();
  fine.tolerance_mm = 0.001;
  const std::string head = "1 L X+10 Y+0 Z+0 B+0 C+0 F500\n";
  EXPECT_REFUSED(fine, head + "2 L B+90 X+20\n3 RND R2\n4 L Y+5\n",
                 "line 3: '3 RND R2': the move in front of the corner had to be split");
  EXPECT_REFUSED(fine, head + "2 L X+20\n3 RND R2\n4 L B+90 Y+5\n", "line 4");
  EXPECT_TRUE(testing::Rewritten(head + "2 L X+20\n3 RND R2\n4 L Y+5\n5 L B+90 X+21\n", fine).status.ok());
}

TEST(Klartext, RetractionsToTheTravelLimitAreNeverTouched) {
  EXPECT_REWRITTEN(Klartext(),
                   "1 L X+10 F500\n2 M140 MB MAX\n3 L X+1 Y+1 R0 FMAX\n4 L Z+5 B+0 C+0 R0 FMAX\n5 L X+2 F500\n",
                   "1 L X+10.0417 F500\n2 M140 MB MAX\n3 L X+1 Y+1 R0 FMAX\n"
                   "4 L Z+5 B+0 C+0 X+1.0417 R0 FMAX\n5 L X+2.0417 F500\n");
  EXPECT_REFUSED(Klartext(), "1 L X+10 F500\n2 M140 MB+50 F100\n3 L X+1 Y+1 F500\n", "the position of Z is unknown");
  EXPECT_REFUSED(Klartext(), "1 L X+10 M140 MB+50\n",
                 "M140 (retraction along the tool) and words of axes in one block");
  EXPECT_REFUSED(Klartext(), "1 FL X+10 AN+30\n", "free contour: no word of an axis could be corrected");
}

struct Path {
  std::string text;
  VerifyReport verified;
};

Path Compensated(const std::string& program, const std::vector<std::pair<std::string, double>>& values) {
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  const auto errors = testing::ConstantErrors(machine, values);
  RewriteOptions options = testing::InMm();
  options.dialect = "heidenhain";
  options.tolerance_mm = 0.001;
  VerifyOptions verify;
  verify.reading.unit = ProgramUnit::kMillimetre;
  verify.tool_tip_mm = {0, 0, -testing::kToolMm};
  verify.reading = options;
  Path path;
  RewriteReport report;
  const auto text = RewriteText(program, testing::MustCreate(machine, errors, verify.tool_tip_mm), options, &report);
  EXPECT_TRUE(text.ok()) << text.status();
  if (!text.ok()) return path;
  path.text = *text;
  const auto verified = VerifyText(program, *text, machine, errors, verify);
  EXPECT_TRUE(verified.ok()) << verified.status() << *text;
  if (verified.ok()) path.verified = *verified;
  return path;
}

constexpr char kArcs[] =
    "0 BEGIN PGM A MM\n1 L X+80 Y+10 Z-20 B+30 C+0 R0 FMAX\n2 CC X+50 Y+10\n3 C X+50 Y+40 DR+ F1000\n4 C X+50 Y+40 "
    "DR-\n"
    "5 CC IX-30 IY+5\n6 C IX-30.4138 IY+35.4138 DR-\n7 CR X+10 Y+10 R+45 DR+\n8 CR X+20 Y+10 R-7.5 DR-\n9 L X+0\n";

// Squareness of X and Y shears circles: they become several arcs, each with its centre.
TEST(Klartext, ArcsStayWithinToleranceAsArcs) {
  const Path path = Compensated(kArcs, {{"EC0Y", 2e-4}, {"EX0C", 0.03}, {"EB0B", testing::kTiltRad}});
  EXPECT_EQ(path.verified.moves, 7);
  EXPECT_GT(path.verified.pieces, 7);
  EXPECT_LT(path.verified.pieces, 60);
  EXPECT_THAT(path.text, HasSubstr("\nC X+"));
  EXPECT_THAT(path.text, HasSubstr(" DR-\n"));
  EXPECT_THAT(path.text, Not(HasSubstr("I-")));
  EXPECT_LT(path.verified.end_after.max_mm, 0.0002);
  EXPECT_LT(path.verified.path_after.max_mm, 0.0012) << path.text;
  EXPECT_GT(path.verified.path_before.max_mm, 0.02);
}

TEST(Klartext, ToolCallsThatMakeAnotherLengthAreRefused) {
  RewriteOptions options = Klartext();
  options.tool_lengths = {{5, 100.0}};
  const std::string move = "\nL X+1 Y+0 Z+0 B+0 C+0 R0 FMAX\n", moved = "\nL X+1.0533 Y+0 Z+0 B+0 C+0 R0 FMAX\n";
  for (const std::string call : {"TOOL CALL 5.1 Z S3000", "TOOL CALL 5 X S3000", "TOOL CALL 5 Z S3000 DL+Q1"})
    EXPECT_REFUSED(options, call + move, "TOOL CALL with an index, a tool axis other than Z or a difference DL");
  for (const std::string call : {"TOOL CALL 5 Z S3000 F500 DL+0 DR-0.1", "TOOL CALL 5 Z ; X DL+Q3"})
    EXPECT_REWRITTEN(options, call + move, call + moved);
  // Z stands higher by the difference, until the next tool is called.
  const compensate::Compensator compensator = testing::LeaningHead();
  auto interpreter = Interpreter::Create(compensator.machine(), options);
  ASSERT_TRUE(interpreter.ok());
  Block block;
  Step step;
  const auto z_behind = [&](const std::string& call) {
    for (const std::string& line : {call, std::string("L X+1 Y+0 Z+2 B+0 C+0 R0 FMAX")})
      interpreter->Read(line.data(), line.size(), &block, &step);
    EXPECT_EQ(step.kind, StepKind::kMove) << step.reason;
    return static_cast<double>(interpreter->positions().ticks[machine::FindAxis(compensator.machine(), "Z")]) /
           static_cast<double>(kTicksPerMm);
  };
  EXPECT_DOUBLE_EQ(z_behind("TOOL CALL 5 Z S3000 DL+0.5 DR-0.1"), 102.5);
  EXPECT_DOUBLE_EQ(z_behind("TOOL CALL DL-0.02"), 101.98);
  EXPECT_DOUBLE_EQ(z_behind("TOOL CALL S100"), 101.98);
  EXPECT_DOUBLE_EQ(z_behind("TOOL CALL 5 Z"), 102.0);
  // M129 ends tool centre point control, not the length.
  RewriteOptions passing = options;
  passing.on_unsupported = OnUnsupported::kPass;
  RewriteReport report;
  EXPECT_TRUE(RewriteText("TOOL CALL 6 Z S3000\nM129" + move, testing::LeaningHead(), passing, &report).ok());
  EXPECT_EQ(report.blocks_corrected, 0);
}

TEST(Klartext, FunctionsThatAreNotFollowedAreRefused) {
  for (const std::string function : {"FUNCTION MODE TURN", "FUNCTION PARAXCOMP MOVE X", "FUNCTION PARAXMODE X Y W",
                                     "FUNCTION PROG PATH IS CONTOUR", "FUNCTION CORRDATA TCS #1", "M114"})
    EXPECT_REFUSED(Klartext(), function + "\nL X+1 F500\n", function.substr(0, function.find(' ')));
  EXPECT_REWRITTEN(Klartext(), "FUNCTION DCM OFF\nFUNCTION FEED DWELL D-TIME0.5 F-TIME5\nL X+1 F500\n",
                   "FUNCTION DCM OFF\nFUNCTION FEED DWELL D-TIME0.5 F-TIME5\nL X+1.0417 F500\n");
}

// A lean of micrometres that adds up over the pieces of an arc is of the same kind.
TEST(Klartext, NoArcHoldsAWordOfZ) {
  const Path path = Compensated(kArcs, {{"EA0C", 3e-6}, {"EC0Y", 1e-4}, {"EX0C", 0.03}});
  EXPECT_EQ(path.verified.moves, 7);
  EXPECT_THAT(path.text, Not(::testing::ContainsRegex("C[^\n]*Z[^\n]*DR")));
  EXPECT_LT(path.verified.end_after.max_mm, 0.0002);
  EXPECT_LT(path.verified.path_after.max_mm, 0.0012);
}

// Where Z must follow, no word of an arc could say so: chords in L blocks.
TEST(Klartext, ArcsThatNeedAnotherAxisBecomeChords) {
  const Path path = Compensated(kArcs, {{"EA0C", 2e-4}, {"EB0C", -1e-4}});
  EXPECT_EQ(path.verified.moves, 7);
  EXPECT_GT(path.verified.pieces, 100);
  EXPECT_THAT(path.text, HasSubstr("\n3 L X+"));
  EXPECT_THAT(path.text, Not(HasSubstr("DR")));
  EXPECT_LT(path.verified.end_after.max_mm, 0.0002);
  EXPECT_LT(path.verified.path_after.max_mm, 0.0012);
}

// The tilting axes turn home, and a tool change may take any axis along: where they stand then is not known.
TEST(Klartext, WhatTakesAxesAwayLeavesThemUnknown) {
  RewriteOptions options = kAtZero;
  options.dialect = "heidenhain";
  const std::string head = "L X+5 Y+0 Z+0 B+20 C+30 R0 FMAX\n";
  for (const char* away :
       {"PLANE RESET TURN FMAX\n", "PLANE RESET MOVE DIST50 F500\n", "L M6\n", "L X+7 R0 FMAX M6\n"}) {
    EXPECT_REFUSED(options, head + away + "L X+10 F500\n", "is unknown: not programmed since line 2");
    EXPECT_TRUE(testing::Rewritten(head + away + "L X+10 Y+0 Z+0 B+0 C+0 F500\n", options).status.ok()) << away;
  }
  EXPECT_TRUE(testing::Rewritten(head + "PLANE RESET STAY\nL X+10 F500\n", options).status.ok());
}

}  // namespace
}  // namespace axiscal::nc
