// Cutter compensation (G41, G42; RL, RR): words of the contour corrected, what the cutter's radius leaves of it, and
// what the control would make of micrometres.
#include "core/machine/machine_json.h"
#include "core/nc/cutter_contour.h"
#include "core/nc/testing/rewritten.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using testing::kAtZero;

RewriteOptions In(const std::string& dialect, double radius_mm = 5.0) {
  RewriteOptions options = kAtZero;
  options.dialect = dialect;
  options.tool_lengths = {{1, 10.0}};
  options.tool_radii = {{1, radius_mm}, {2, 3.0}};
  return options;
}

compensate::Compensator With(const std::string& symbol, double value) {
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  return testing::MustCreate(machine, testing::ConstantErrors(machine, {{symbol, value}}), {0, 0, -testing::kToolMm});
}

const char kHead[] = "G90 G17 G21 G94\nG0 X0. Y0. Z50. B0. C0.\n";

TEST(Contour, WordsAreThoseOfThePart) {
  const std::string head = "G90 G17 G21 G94\nG0 X0.0417 Y0. Z50. B0. C0.\n";
  for (const char* dialect : {"fanuc", "mazak", "haas", "linuxcnc"}) {
    EXPECT_REWRITTEN(In(dialect),
                     std::string(kHead) +
                         "G1 G41 D1 X20. Y10. F500\nY50.\nX60.\nG2 X70. Y40. I0. J-10.\nG1 Y10.\nX5.\n"
                         "G40 Y0.\nX5.\n",
                     head +
                         "G1 G41 D1 X20.0417 Y10. F500\nY50.\nX60.0417\nG2 X70.0417 Y40. I0. J-10.\nG1 Y10.\n"
                         "X5.0417\nG40 Y0.\nX5.0417\n");
  }
  RewriteOptions sinumerik = In("sinumerik");
  EXPECT_REWRITTEN(
      sinumerik, "G90 G17 G71 G94\nG0 X0 Y0 Z50 B0 C0 D1\nG1 G42 X20 Y10 F500\nX50\nY50\nG40 X0\n",
      "G90 G17 G71 G94\nG0 X0.0428 Y0 Z50 B0 C0 D1\nG1 G42 X20.0428 Y10 F500\nX50.0428\nY50\nG40 X0.0428\n");
  RewriteOptions heidenhain = In("heidenhain");
  EXPECT_REWRITTEN(heidenhain,
                   "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S100\n2 L X+0 Y+0 Z+50 B+0 C+0 R0 FMAX\n3 L X+20 Y+10 RR F500\n"
                   "4 L X+50\n5 L Y+50\n6 L X+0 R0\n7 END PGM A MM\n",
                   "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S100\n2 L X+0.0428 Y+0 Z+50 B+0 C+0 R0 FMAX\n"
                   "3 L X+20.0428 Y+10 RR F500\n4 L X+50.0428\n5 L Y+50\n6 L X+0.0428 R0\n7 END PGM A MM\n");
}

// APPR names the first point of the contour, DEP LCT where the tool leaves it to; the line or arc between is the
// control's.
TEST(Contour, ApproachesAndDeparturesOfKlartext) {
  const std::string head = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S100\n2 L X-30 Y-30 Z+50 B+0 C+0 R0 FMAX\n";
  const std::string done = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S100\n2 L X-29.9572 Y-30 Z+50 B+0 C+0 R0 FMAX\n";
  for (const char* how : {"LT", "LN", "CT", "LCT"}) {
    const std::string more = std::string(how) == "CT" ? "CCA+90 R+8" : std::string(how) == "LCT" ? "R8" : "LEN15";
    const std::string approach = absl::StrCat("3 APPR ", how, " X+5 Y+5 ", more, " RL F300\n");
    const std::string approached = absl::StrCat("3 APPR ", how, " X+5.0428 Y+5 ", more, " RL F300\n");
    EXPECT_REWRITTEN(In("heidenhain"),
                     head + approach + "4 L Y+95\n5 L X+95\n6 DEP LCT X+120 Y+120 R5 F1000\n7 L Z+100\n8 L X+0 Y+0\n",
                     done + approached +
                         "4 L Y+95\n5 L X+95.0428\n6 DEP LCT X+120.0428 Y+120 R5 F1000\n7 L Z+100\n8 L X+0.0428 Y+0\n");
  }
  // Where the others lead the control computes: X and Y are unknown behind them.
  const std::string contour = "3 APPR LT X+5 Y+5 LEN15 RL F300\n4 L Y+95\n",
                    corrected = "3 APPR LT X+5.0428 Y+5 LEN15 RL F300\n4 L Y+95\n";
  for (const char* departure : {"5 DEP LT LEN15 F500\n", "5 DEP LN LEN15\n", "5 DEP CT CCA90 R+8\n"}) {
    EXPECT_REWRITTEN(In("heidenhain"), head + contour + departure + "6 L X+0 Y+0 R0 FMAX\n",
                     done + corrected + departure + "6 L X+0.0428 Y+0 R0 FMAX\n");
    EXPECT_REFUSED(In("heidenhain"), head + contour + departure + "6 L X+0 F100\n", "the position of Y is unknown");
  }
  EXPECT_REFUSED(In("heidenhain"), head + "3 APPR LT X+5 Y+5 LEN15 F300\n", "APPR without RL or RR");
  EXPECT_REFUSED(In("heidenhain"), head + contour + "5 APPR LT X+50 Y+50 LEN15 RL\n",
                 "while cutter compensation is active");
  EXPECT_REFUSED(In("heidenhain"), head + "3 DEP LCT X+5 Y+5 R5\n", "DEP without cutter compensation");
  EXPECT_REFUSED(In("heidenhain"), head + contour + "5 DEP LT LEN15 X+5\n", "words of axes");
  EXPECT_REFUSED(In("heidenhain", 200.0), head + contour + "5 L X+4\n6 DEP LT LEN5\n", "too short for the cutter");
}

// A move along Z alone would turn the cutter round with a word of X of some micrometres: what is left is said instead.
TEST(Contour, MovesAlongZGetNoWordsOfXAndY) {
  const auto leaning = With("EB0Z", 1e-4);
  const std::string program =
      std::string(kHead) + "G41 D1\nG1 Z-30. F100\nX20. Y10.\nZ-50.\nY50.\nX5. Z-50.\nG40\nG0 Z50.\nX0. Y0.\nZ40.\n";
  const testing::Outcome outcome = testing::Rewritten(program, In("fanuc"), leaning);
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  for (const char* block : {"\nG41 D1\nG1 Z-30. F100\nX", "\nZ-49.9980\nY50. X20.04", "\nG40\nG0 Z50.0005\nX"})
    EXPECT_THAT(outcome.text, HasSubstr(block));
  EXPECT_THAT(outcome.text, HasSubstr("\nZ40. X"));  // no contour waits for anything any more
  EXPECT_EQ(outcome.report.contour_moves, 5);
  EXPECT_NEAR(outcome.report.max_contour_left_mm, 100e-4, 1e-4);  // of the way up, a rapid
  RewriteOptions options = In("fanuc");
  options.cutter_tolerance_mm = 0.005;
  EXPECT_REFUSED_BY(leaning, options, program, "the limit is 5.0 um: the move has no part in X and Y");
  options.cutter_tolerance_mm = 0;
  EXPECT_FALSE(Validate(options).ok());
}

// Y is not square to X by 1 mrad: X is off by 1 um for each mm of Y.
TEST(Contour, WhatTheRadiusLeavesIsSaid) {
  const auto mill = machine::MachineFromJson(R"({"id": "mill", "structure": "wX'bYZt", "axes": {
      "X": {"kind": "linear", "direction": [-1, 0, 0]}, "Y": {"kind": "linear", "direction": [0, 1, 0]},
      "Z": {"kind": "linear", "direction": [0, 0, 1]}},
      "tool_branch": ["Y", "Z"], "work_branch": ["X"], "tool_direction": [0, 0, -1]})");
  ASSERT_TRUE(mill.ok()) << mill.status();
  const auto askew = testing::MustCreate(*mill, testing::ConstantErrors(*mill, {{"EC0Y", 1e-3}}), {0, 0, -300});
  const std::string program = "G90 G17 G21 G94\nG0 X0. Y0. Z50.\nG1 G41 D1 X20. Y10. F500\nX80. Y70.\nX100.\nG40 Y0.\n";
  RewriteOptions options = In("fanuc");
  options.initial_position.clear();
  const testing::Outcome outcome = testing::Rewritten(program, options, askew);
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  // At 45 deg: the centre stands 5 mm aside, 3.54 mm of it along Y, where X is off by 3.54 um; 2.5 um of it across.
  EXPECT_NEAR(outcome.report.max_contour_left_mm, 2.5e-3, 0.2e-3);
  EXPECT_EQ(outcome.report.contour_moves, 2);
  EXPECT_EQ(outcome.report.contour_left.front().line, 4);
  options.cutter_tolerance_mm = 0.002;
  EXPECT_REFUSED_BY(askew, options, program, "um are left along the contour, the limit is 2.0 um");
  EXPECT_REFUSED_BY(askew, options, program, "--cutter-tolerance-um");
  options.tool_radii = {{1, 1.0}};
  EXPECT_TRUE(testing::Rewritten(program, options, askew).status.ok());
  options.tool_radii = {{1, 5.0}};
  VerifyOptions verify;
  verify.tool_tip_mm = {0, 0, -300};
  verify.reading = options;
  const auto report = VerifyText(program, outcome.text, *mill, askew.carried(), verify);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_GT(report->end_before.max_mm, 2e-2);
  EXPECT_LT(report->end_after.max_mm, 2e-4);  // of the contour
}

// X is off by 1 um for each mm of Y: on a ramp of 45 deg along X the centre, 5 mm beside it in Y, stands 5 um along its
// path from where the words lead, and sqrt(1/2) of that beside it. On a level path nobody sees it.
TEST(Contour, OnARampWhatStandsAlongThePathIsNotAllOfIt) {
  const auto mill = machine::MachineFromJson(R"({"id": "mill", "structure": "wX'bYZt", "axes": {
      "X": {"kind": "linear", "direction": [-1, 0, 0]}, "Y": {"kind": "linear", "direction": [0, 1, 0]},
      "Z": {"kind": "linear", "direction": [0, 0, 1]}},
      "tool_branch": ["Y", "Z"], "work_branch": ["X"], "tool_direction": [0, 0, -1]})");
  ASSERT_TRUE(mill.ok()) << mill.status();
  const auto askew = testing::MustCreate(*mill, testing::ConstantErrors(*mill, {{"EC0Y", 1e-3}}), {0, 0, -300});
  RewriteOptions options = In("fanuc");
  options.initial_position.clear();
  const auto left_mm = [&](const std::string& move) {
    const testing::Outcome outcome = testing::Rewritten(
        "G90 G17 G21 G94\nG0 X0. Y-20. Z50.\nG1 G41 D1 X20. Y0. F500\n" + move + "G40 Y-20.\n", options, askew);
    EXPECT_TRUE(outcome.status.ok()) << outcome.status;
    return outcome.report.max_contour_left_mm;
  };
  EXPECT_LT(left_mm("X80.\n"), 0.2e-3);
  EXPECT_NEAR(left_mm("X80. Z110.\n"), 5e-3 * std::sqrt(0.5), 0.2e-3);
  EXPECT_NEAR(left_mm("X80. Z-10.\n"), 5e-3 * std::sqrt(0.5), 0.2e-3);
}

TEST(Contour, WhatIsNotKnownIsRefused) {
  const std::string on = "G1 G41 D1 X20. Y10. F500\n", off = "G40 X0.\n";
  const std::vector<std::pair<std::string, std::string>> programs = {
      {"G1 G41 D7 X20. Y10. F500\n", "the cutter's radius D7 is not stated: add --tool-radius D7=MM"},
      {"G1 G41 X20. Y10. F500\n", "no D word says which radius"},
      {"G18 G1 G41 D1 X20. Y10. F500\n", "in another plane than XY"},
      {"G2 G41 D1 X20. Y10. I10. J5. F500\n", "cutter compensation begins with an arc"},
      {on + "Y50.\nG40 G2 X30. Y50. I5. J0.\n", "cutter compensation ends with an arc"},
      {on + "Y50.\nY20.\n", "the contour turns back by 180.0 deg"},
      {on + "Y50.\nX16.\nY60.\n", "too short for the cutter of radius 5.0000 mm"},
      {on + "Y50.\nG3 X12. Y50. I-4. J0.\n", "an inner arc of radius 4.0000 mm leaves the cutter of radius 5.0000 mm"},
      {on + "Y50. C90.\n", "a move of C while cutter compensation is active"},
      {"B30.\n" + on, "the tool does not stand along Z"},
      {on + "Y50.\nG42 X60.\n", "its side or its radius changes"},
      {on + "Y50.\nD2 X60.\n", "its side or its radius changes"},
      {on + "Y50.\nG43 H1 Z5.\n", "the tool length changes while cutter compensation is active"},
      {on + "Y50.\nG53 Z0.\n", "while cutter compensation is active: end that in front of it"},
      {on + "Y50.\nG81 X60. Z-5. R2.\n", "another move is stated while cutter compensation is active"},
      {on + "Y50. ,R2.\nX60.\n", "a rounded or chamfered corner while cutter compensation is active"},
      {on + "/Y50.\nX60.\n", "that may be skipped"},
      {on + "Y50.\nM6 T2\n", "the tool is changed while cutter compensation is active"},
      {on + "Y50.\nG40\nG41 D1\nX60.\n", "it begins again in front of the move in X or Y that ends it"},
      {"G51 X0. Y0. Z0. P2.\n" + on, "in scaled coordinates"},
      {"G51.1 X0.\n" + on, "in mirrored coordinates"},
  };
  for (const auto& [program, reason] : programs) EXPECT_REFUSED(In("fanuc"), kHead + program, reason);
  RewriteOptions turning = In("fanuc");
  turning.orientation = true;
  EXPECT_REFUSED(turning, kHead + on + off, "with --orientation");
  EXPECT_REFUSED(In("linuxcnc"), std::string(kHead) + "G1 G41 X20. Y10. F500\n", "no T word and M6 in front of it");
  EXPECT_REFUSED(In("sinumerik"), "G90 G17 G71 G94\nG0 X0 Y0 Z50 B0 C0\nG1 G41 X20 Y10 F500\n", "no D word says");
  EXPECT_REFUSED(In("heidenhain"), "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+50 B+0 C+0 R0 FMAX\n2 L X+9 RL F9\n",
                 "no TOOL CALL in front of it");
  EXPECT_REFUSED(In("heidenhain"),
                 "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1 DR+Q1\n2 L X+0 Y+0 Z+50 B+0 C+0 R0 FMAX\n3 L X+9 RL F9\n",
                 "DR of TOOL CALL is no plain number");
}

// What is passed leaves the control beside the programmed place: no block can bring it back there while it offsets.
TEST(Contour, NothingIsPassedBesideCorrectedMoves) {
  RewriteOptions options = In("fanuc");
  options.on_unsupported = OnUnsupported::kPass;
  EXPECT_REFUSED(options, std::string(kHead) + "G1 G41 D1 X20. Y10. F500\nY50.\nG31 X60.\n",
                 "what is not corrected there cannot stand beside corrected moves");
  // A compensation that is not followed is passed as a whole.
  const testing::Outcome outcome =
      testing::Rewritten(std::string(kHead) + "G1 G41 D9 X20. Y10. F500\nY50.\nG40 X0.\nG0 X7. Y8. Z50.\n", options);
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_THAT(outcome.text, HasSubstr("\nG1 G41 D9 X20. Y10. F500\nY50.\n"));
}

ContourPiece Line(double x, double y, double to_x, double to_y) { return {{x, y}, {to_x, to_y}, false, {}}; }

ContourPiece Circle(double x, double y, double to_x, double to_y, double centre_x, double centre_y, bool is_left) {
  ContourPiece piece{{x, y}, {to_x, to_y}, true, {}};
  piece.arc = *ArcAboutCentre(piece.start_mm, piece.end_mm, {centre_x, centre_y}, is_left);
  return piece;
}

TEST(CutterContour, InnerCornersTakeWhatTheirOffsetsCut) {
  CutterContour contour;
  const auto add = [&](const ContourPiece& piece) { return contour.Add(piece, piece); };
  // A square corner takes 5 mm of both lines: 10.1 mm between two of them are enough, 9.9 mm not.
  for (const double length : {9.9, 10.1}) {
    contour.Begin(1, 5.0);
    EXPECT_EQ(add(Line(0, 0, 20, 0)), "");
    EXPECT_EQ(add(Line(20, 0, 20, length)), "");
    EXPECT_EQ(add(Line(20, length, 0, length)).empty(), length > 10.0) << length;
    contour.Begin(-1, 5.0);  // outside there is room
    EXPECT_EQ(add(Line(0, 0, 20, 0)), "");
    EXPECT_EQ(add(Line(20, 0, 20, length)), "");
    EXPECT_EQ(add(Line(20, length, 0, length)), "");
  }
  // A line into a circle of 20 mm about (20, 20) at its bottom, from straight above: the offsets, x = 15 and 15 mm
  // about the centre, cut at (15, 20 - 14.1421), 5.8579 mm above the corner.
  for (const double length : {5.8, 5.9}) {
    contour.Begin(-1, 5.0);
    EXPECT_EQ(add(Line(20, length, 20, 0)).empty(), true);
    EXPECT_EQ(add(Circle(20, 0, 0, 20, 20, 20, false)).empty(), length > 5.8579 + 0.005) << length;
  }
  contour.Begin(1, 5.0);
  EXPECT_THAT(add(Circle(0, 0, 0, 8, 0, 4, true)), HasSubstr("an inner arc"));
  contour.Begin(1, 5.0);
  EXPECT_THAT(contour.Add(Line(0, 0, 0.1, 0), Line(0, 0, 0.1, 0.002)),
              HasSubstr("the move is so short (0.1000 mm) that the correction"));
  contour.Begin(1, 5.0);
  EXPECT_EQ(contour.Add(Line(0, 0, 1, 0), Line(0, 0, 1, 0.002)), "");
  contour.Begin(-1, 5.0);
  EXPECT_EQ(add(Circle(0, 0, 0, 8, 0, 4, true)), "");
}

}  // namespace
}  // namespace axiscal::nc
