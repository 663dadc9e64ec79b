// Corners that the control rounds or chamfers (RND=, RNDM=, CHF=, CHR=), as moves of their own; rows and circles of
// holes.
#include "core/nc/corners.h"

#include <cmath>
#include <random>

#include "core/machine/error_json.h"
#include "core/nc/corner_geometry.h"
#include "core/nc/testing/rewritten.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

using Eigen::Vector2d;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Rewritten;

RewriteOptions Sinumerik() {
  RewriteOptions options = testing::kAtZero;
  options.dialect = "sinumerik";
  options.tool_lengths = {{1, 10.0}};
  options.tool_radii = {{1, 5.0}};
  return options;
}

// X and Y stand askew: moves along them are corrected in Z, too.
compensate::Compensator Askew() {
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  return testing::MustCreate(machine,
                             testing::ConstantErrors(machine, {{"EB0X", 1e-4}, {"EA0Y", 2e-4}, {"EC0Y", 2e-4}}),
                             {0, 0, -testing::kToolMm});
}

CornerMove Line(const Vector2d& from, const Vector2d& to) { return {from, to, false, {}}; }

CornerMove ArcOf(const Vector2d& from, const Vector2d& to, double radius_mm, bool is_counterclockwise) {
  const absl::StatusOr<Arc> arc = ArcOfRadius(from, to, radius_mm, is_counterclockwise);
  EXPECT_TRUE(arc.ok()) << arc.status();
  return {from, to, true, *arc};
}

TEST(CornerGeometry, SquareCorners) {
  const CornerMove from = Line({0, 0}, {10, 0}), to = Line({10, 0}, {10, 10});
  const auto round = RoundCorner(from, to, 2.0);
  ASSERT_TRUE(round.ok()) << round.status();
  EXPECT_TRUE(round->from_mm.isApprox(Vector2d(8, 0)));
  EXPECT_TRUE(round->to_mm.isApprox(Vector2d(10, 2)));
  EXPECT_TRUE(round->centre_mm.isApprox(Vector2d(8, 2)));
  EXPECT_TRUE(round->is_counterclockwise);
  EXPECT_NEAR(round->left_of_from_mm, 8.0, 1e-12);
  // CHF says the chamfer's length, CHR how much it takes of each move.
  const auto chamfer = ChamferCorner(from, to, std::sqrt(8.0), true), legs = ChamferCorner(from, to, 2.0, false);
  for (const auto& path : {chamfer, legs}) {
    ASSERT_TRUE(path.ok()) << path.status();
    EXPECT_TRUE(path->from_mm.isApprox(Vector2d(8, 0)));
    EXPECT_TRUE(path->to_mm.isApprox(Vector2d(10, 2)));
    EXPECT_FALSE(path->is_arc);
  }
  EXPECT_TRUE(RoundCorner(from, Line({10, 0}, {20, 0}), 2.0)->is_none);
  EXPECT_THAT(RoundCorner(from, to, 11.0).status().message(),
              HasSubstr("it takes 11.0000 mm of the move in front of it, which has 10.0000 mm"));
  EXPECT_THAT(RoundCorner(from, Line({10, 0}, {10, 1}), 2.0).status().message(),
              HasSubstr("it takes 2.0000 mm of the move behind it, which has 1.0000 mm"));
  EXPECT_THAT(RoundCorner(from, Line({10, 0}, {0, 0.1}), 2.0).status().message(), HasSubstr("turns back by 179.4 deg"));
  EXPECT_THAT(ChamferCorner(from, ArcOf({10, 0}, {10, 10}, 6, true), 1.0, true).status().message(),
              HasSubstr("a chamfer beside an arc"));
}

// Touching means: the arc's ends stand on both moves, a radius from its centre, square to the moves there.
TEST(CornerGeometry, RoundingsTouchLinesAndArcs) {
  std::mt19937 random(20);
  std::uniform_real_distribution<double> unit(-1, 1);
  int found = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector2d corner(10 * unit(random), 10 * unit(random));
    const auto away = [&] { return Vector2d(corner + Vector2d(60 * unit(random), 60 * unit(random))); };
    const Vector2d begin = away(), end = away();
    const auto move = [&](const Vector2d& a, const Vector2d& b) {
      if (i % 3 == 0 || unit(random) > 0) return Line(a, b);
      return ArcOf(a, b, 0.5 * (b - a).norm() * (1.01 + std::abs(unit(random))), unit(random) > 0);
    };
    const CornerMove from = move(begin, corner), to = move(corner, end);
    const double radius_mm = 0.2 + 4.0 * std::abs(unit(random));
    const auto path = RoundCorner(from, to, radius_mm);
    if (!path.ok() || path->is_none) continue;
    ++found;
    for (const bool is_first : {true, false}) {
      const CornerMove& side = is_first ? from : to;
      const Vector2d at = is_first ? path->from_mm : path->to_mm, spoke = at - path->centre_mm;
      EXPECT_NEAR(spoke.norm(), radius_mm, 1e-9);
      Vector2d tangent = (side.end_mm - side.start_mm).normalized();
      if (side.is_arc) {
        const Vector2d of_arc = at - side.arc.centre_mm;
        EXPECT_NEAR(of_arc.norm(), side.arc.radius_mm(), 1e-9);
        tangent = Vector2d(-of_arc.y(), of_arc.x()).normalized() * (side.arc.sweep_rad > 0 ? 1.0 : -1.0);
      } else {
        const double along = (at - side.start_mm).dot(tangent);
        EXPECT_NEAR((side.start_mm + along * tangent - at).norm(), 0.0, 1e-9);
        EXPECT_GE(along, -1e-6);
        EXPECT_LE(along, (side.end_mm - side.start_mm).norm() + 1e-6);
      }
      EXPECT_NEAR(spoke.dot(tangent), 0.0, 1e-8);
      // Gone through in the sense of the moves.
      const Vector2d around = Vector2d(-spoke.y(), spoke.x()) * (path->is_counterclockwise ? 1.0 : -1.0);
      EXPECT_GT(around.dot(tangent), 0.0);
    }
    EXPECT_EQ(path->is_counterclockwise, TurnAtCorner(from, to) > 0);
  }
  EXPECT_GT(found, 1000);
}

// The same program with its corners as moves.
void ExpectAsMoves(const std::string& program, const std::string& moves, const RewriteOptions& options) {
  const testing::Outcome rounded = Rewritten(program, options, Askew()), written = Rewritten(moves, options, Askew());
  ASSERT_TRUE(rounded.status.ok()) << rounded.status;
  ASSERT_TRUE(written.status.ok()) << written.status;
  EXPECT_EQ(rounded.text, written.text);
}

TEST(Corners, AreWrittenAsMovesWhereTheCorrectionLeavesThePlane) {
  const RewriteOptions options = Sinumerik();
  ExpectAsMoves("G1 X50 F500 RND=5 ; SIDE\nY50\n",
                "G1 X45.0000 F500 ; SIDE\nG3 X50.0000 Y5.0000 I0.0000 J5.0000\nG1 Y50\n", options);
  // A chamfer of legs, the feed of the corner, and that of the moves behind it.
  ExpectAsMoves("N1 G1 X50 F500 CHR=5 FRC=200\nN2 Y50\n",
                "N1 G1 X45.0000 F500\nG1 X50.0000 Y5.0000 F200\nN2 G1 Y50 F500\n", options);
  ExpectAsMoves("G1 X50 F500 CHR=5 FRC=200\nY50 F300\nX40\n",
                "G1 X45.0000 F500\nG1 X50.0000 Y5.0000 F200\nG1 Y50 F300\nX40\n", options);
  // Differences, and arcs whose centre counts from their start.
  ExpectAsMoves(
      "G91 G1 X50 F500 RND=5\nY50 RND=2\nG2 X30 Y30 I30\nG90 G1 X0\n",
      "G91 G1 X45.0000 F500\nG3 X5.0000 Y5.0000 I0.0000 J5.0000\nG1 Y45.0000 RND=2\nG2 X30 Y30 I30\nG90 G1 X0\n",
      options);
  // Every corner until RNDM ends, but those beside moves out of the plane.
  ExpectAsMoves("RNDM=5 FRCM=100\nG1 X50 F500\nY50\nX20 CHR=2\nY30\nG0 Z20\nRNDM=0\nX0\nG1 Y0\nX10\n",
                " FRCM=100\nG1 X45.0000 F500\nG3 X50.0000 Y5.0000 I0.0000 J5.0000 F100\n"
                "G1 Y45.0000 F500\nG3 X45.0000 Y50.0000 I-5.0000 J0.0000 F100\n"
                "G1 X22.0000 F500\nG1 X20.0000 Y48.0000 F100\nG1 Y30 F500\nG0 Z20\n\nX0\nG1 Y0\nX10\n",
                options);
}

TEST(Corners, StayWhereTheControlMakesThemBetweenCorrectedMoves) {
  const std::string program = "G1 X50 F500 RND=5\nY50 CHF=1.5 FRC=200\nX0\n";
  EXPECT_REWRITTEN(Sinumerik(), program, "G1 X50.0417 F500 RND=5\nY50 CHF=1.5 FRC=200\nX0.0417\n");
  // RNDM is said by each corner, as others are written as moves.
  EXPECT_REWRITTEN(Sinumerik(), "RNDM=3\nG1 X50 F500\nY50\nX0\n", "\nG1 X50.0417 RND=3 F500\nY50 RND=3\nX0.0417\n");
}

// Whether a word out of the plane is due is a matter of rounding beside what is commanded: 4.50 um at X50, 4.48 at the
// corner need none, 4.43 at the end behind it does.
TEST(Corners, ThatStayNeedNoWordOutOfThePlane) {
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  const auto errors =
      machine::ReadErrors(R"({"terms": [{"symbol": "EZX", "shape": "linear", "amplitude": 90}]})", machine);
  ASSERT_TRUE(errors.ok()) << errors.status();
  const auto outcome = Rewritten("G1 X50 Y0 F500\nX49.743 Y10 RND=0.5\nX49.208 Y20\n", Sinumerik(),
                                 testing::MustCreate(machine, *errors, {0, 0, -testing::kToolMm}));
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_THAT(outcome.text, Not(HasSubstr("RND=")));
}

// What is passed stays as the program has it: resolved it would be other blocks.
TEST(Corners, StayWhereNothingIsCorrected) {
  RewriteOptions unknown = Sinumerik(), turning = Sinumerik();
  unknown.initial_position = {};
  turning.orientation = true;
  const std::pair<RewriteOptions, std::string> cases[] = {
      {unknown, "G1 X0 Y0 F500\nX10 RND=2\nY10\n"},
      {turning, "F500\nMCALL CYCLE81(50,0,2,-20)\nHOLES2(0,0,20,0,60,6)\nMCALL\n"}};
  for (auto [options, program] : cases) {
    options.on_unsupported = OnUnsupported::kPass;
    RewriteReport report;
    const auto text = RewriteText(program, Askew(), options, &report);
    ASSERT_TRUE(text.ok()) << text.status();
    EXPECT_EQ(*text, program);
    EXPECT_EQ(report.blocks_corrected, 0);
  }
}

TEST(Corners, ARefusedCornerIsListedOnceOfItsBlock) {
  const auto outcome = Rewritten("G1 X10 RND=20 F500\nY10\n", Sinumerik(), Askew());
  EXPECT_FALSE(outcome.status.ok());
  ASSERT_EQ(outcome.report.refused.size(), 2u);
  EXPECT_EQ(outcome.report.refused[0].line + 1, outcome.report.refused[1].line);
}

TEST(Corners, OfContoursThatTheCutterIsLedAlong) {
  const std::string head = "G90 G17 G71 G94\nG0 X0 Y0 Z50 B0 C0 D1\n";
  ExpectAsMoves(
      head + "G1 G42 X20 Y10 F500\nX60 RND=8\nY50\nX20 RND=6\nY20 CHR=3\nX35\nG40 X0 Y0\n",
      head +
          "G1 G42 X20 Y10 F500\nX52.0000\nG3 X60.0000 Y18.0000 I0.0000 J8.0000\nG1 Y50\n"
          "X26.0000\nG3 X20.0000 Y44.0000 I0.0000 J-6.0000\nG1 Y23.0000\nG1 X23.0000 Y20.0000\nG1 X35\nG40 X0 Y0\n",
      Sinumerik());
  // The cutter of radius 5 does not fit into an inner rounding of 4.
  EXPECT_REFUSED(Sinumerik(), head + "G1 G41 X20 Y10 F500\nX60 RND=4\nY50\nG40 X0\n",
                 "an inner arc of radius 4.0000 mm leaves the cutter of radius 5.0000 mm no room");
  EXPECT_REFUSED(Sinumerik(), head + "G1 G42 X20 Y10 F500 RND=2\nX60\nG40 Y0\n",
                 "RND=2: the move in front of it leads to the contour");
  EXPECT_REFUSED(Sinumerik(), head + "G1 G42 X20 Y10 F500\nX60 RND=2\nG40 Y0\n",
                 "RND=2: cutter compensation begins or ends there");
}

TEST(Corners, ThatNobodyKnowsAreRefusedByName) {
  const auto is_refused = [](const std::string& program, const std::string& reason) {
    EXPECT_REFUSED_BY(Askew(), Sinumerik(), program, reason);
  };
  is_refused(
      "G1 X50 RND=5 F500\nY4\n",
      "line 1: 'G1 X50 RND=5 F500': RND=5: it takes 5.0000 mm of the move behind it, which has 4.0000 mm: the control "
      "would make it smaller");
  is_refused("G1 X50 CHR=60 F500\nY40\n",
             "CHR=60: it takes 60.0000 mm of the move in front of it, which has 50.0000 mm");
  is_refused("G1 X50 RND=5 F500\nG0 Y40\n", "RND=5: a rapid move beside it");
  is_refused("G1 X50 RND=5 F500\nX60 Y40 Z5\n", "RND=5: a move beside it leaves the working plane");
  is_refused("G1 X50 RND=5 F500\nM8\nY40\n", "RND=5: the block behind it is no move");
  is_refused("G1 X50 RND=5 F500\nG18\nX70 Z40\n", "RND=5");
  is_refused("G1 X50 RND=5 F500\n", "RND=5: no move stands behind it");
  is_refused("G1 X50 RND=5 F=R1\nY50\n", "R1");
  is_refused("G1 X50 CHF=5 F500\nG3 X50 Y50 CR=30\n", "CHF=5: a chamfer beside an arc");
  is_refused("G1 X50 RND=5 FRC=100\nY50\n", "the feed to which the control returns behind it is not known");
  is_refused("G93 G1 X50 F5 RND=5\nY50 F5\n", "RND=5: in G93");
  is_refused("RNDM=5\nG1 X50 F500\nRNDM=0 Y50\n", "RNDM=5: another RNDM or FRCM stands behind it");
  is_refused("G1 X50 RND=-5 F500\nY40\n", "RND");
}

TEST(Corners, ACircleIsNoneWhereNothingIsLeftOfAnArc) {
  // Two roundings of 5 mm take all of a straight side of 10 mm.
  const testing::Outcome slot = Rewritten("G1 X50 F500 RND=5\nY10 RND=5\nX0\n", Sinumerik(), Askew());
  ASSERT_TRUE(slot.status.ok()) << slot.status;
  EXPECT_EQ(slot.report.blocks_inserted, 2);
}

// Corners between lines and arcs on a machine with errors of all kinds, by the reader that resolves the source itself.
TEST(Corners, GoWhereTheProgramGoes) {
  const machine::Machine machine = testing::CountingOn(machine::testing::TiltingTable());
  machine::ErrorModel errors = machine::DeclaredModel(machine);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (auto& term : errors.terms) term.amplitude[0] = unit(random) * (machine::IsAngle(term.component) ? 5e-5 : 0.05);
  const Eigen::Vector3d tip_mm(0, 0, -150);
  RewriteOptions options = testing::InMm();
  options.dialect = "sinumerik";
  options.tolerance_mm = 0.001;
  std::string program = "G90 G17 G0";
  for (const machine::Axis& axis : machine.axes) absl::StrAppend(&program, " ", axis.name, "0");
  program +=
      "\nG1 F500\nX200 RND=25\nY150 CHF=10 FRC=200\nX100 Y180 RND=3.5\n"
      "G3 X0 Y100 CR=160 RND=12\nG1 X-60 Y120 RND=40\nG91 X-100 Y-100 RND=7\nG2 X60 Y-60 I60 J0 RND=3\n"
      "G1 X50 Y-50 CHR=4\nX30\nG90 G18 RNDM=4\nX0 Z50\nX40 Z60\nZ100\nG3 X80 Z140 CR=60\nG1 X100\nG0 Y5\nRNDM=0\n"
      "G17 G0 Z200\n";
  RewriteReport report;
  const auto text = RewriteText(program, testing::MustCreate(machine, errors, tip_mm), options, &report);
  ASSERT_TRUE(text.ok()) << text.status();
  for (const char* word : {"RND", "CHF", "CHR", "FRC="}) EXPECT_THAT(*text, Not(HasSubstr(word)));
  VerifyOptions verify;
  verify.reading = options;
  verify.tool_tip_mm = tip_mm;
  const auto verified = VerifyText(program, *text, machine, errors, verify);
  ASSERT_TRUE(verified.ok()) << verified.status() << "\n" << *text;
  constexpr double kRoundingMm = 0.00015;
  EXPECT_LT(verified->end_after.max_mm, kRoundingMm) << *text;
  EXPECT_LT(verified->path_after.max_mm, 0.001 + kRoundingMm) << "line " << verified->worst_line << "\n" << *text;
  EXPECT_GT(verified->path_before.max_mm, 0.02);
}

TEST(Corners, InSubprogramsStandInTheirPlace) {
  RewriteOptions options = Sinumerik();
  options.subprograms = {{"L10.SPF", "G1 X50 RND=5\n; SIDE\nY50 RND=3\nX40\nM17\n"}};
  const std::string program = "G1 X0 Y0 Z0 F500\nL10\nG1 X0 Y0 RND=2\nM30\n";
  const testing::Outcome outcome = Rewritten(program, options, Askew());
  EXPECT_THAT(std::string(outcome.status.message()), HasSubstr("RND=2: the block behind it is no move"));
  const testing::Outcome whole = Rewritten("G1 X0 Y0 Z0 F500\nL10\nG1 X0 Y0\nM30\n", options, Askew());
  ASSERT_TRUE(whole.status.ok()) << whole.status;
  ASSERT_EQ(whole.report.subprograms.size(), 1u);
  const std::string& text = whole.report.subprograms[0].text;
  options.subprograms[0].text =
      "G1 X45.0000\nG3 X50.0000 Y5.0000 I0.0000 J5.0000\n; SIDE\nG1 Y47.0000\nG3 X47.0000 Y50.0000 I-3.0000 "
      "J0.0000\nG1 "
      "X40\nM17\n";
  const testing::Outcome moves = Rewritten("G1 X0 Y0 Z0 F500\nL10\nG1 X0 Y0\nM30\n", options, Askew());
  ASSERT_TRUE(moves.status.ok()) << moves.status;
  // But for the mark, which names the source.
  const auto words = [](const std::string& all) { return all.substr(all.find("G1 X")); };
  EXPECT_EQ(words(text), words(moves.report.subprograms[0].text));
}

TEST(HolePatterns, AreWrittenAsTheirPositions) {
  const std::string head = "G90 G17 G71\nG0 X0 Y0 Z50 B0 C0\nMCALL CYCLE81(20,0,2,-10)\n", tail = "MCALL\nG0 X0 Y0\n";
  ExpectAsMoves(head + "N50 HOLES1(10,20,90,5,10,3) ; ROW\n" + tail,
                head + "N50 X10.0000 Y25.0000 ; ROW\nX10.0000 Y35.0000\nX10.0000 Y45.0000\n" + tail, Sinumerik());
  // From its nearer end on.
  ExpectAsMoves(head + "HOLES1(100,0,180,0,40,3)\n" + tail,
                head + "X20.0000 Y0.0000\nX60.0000 Y0.0000\nX100.0000 Y0.0000\n" + tail, Sinumerik());
  ExpectAsMoves(head + "HOLES2(0,0,10,0,0,4)\n" + tail,
                head + "X10.0000 Y0.0000\nX0.0000 Y10.0000\nX-10.0000 Y0.0000\nX0.0000 Y-10.0000\n" + tail,
                Sinumerik());
  ExpectAsMoves(head + "G1\nHOLES2(0,0,10,90,-90,2)\nMCALL\nX50 Y50 F500\n",
                head + "G1\nG0 X0.0000 Y10.0000\nX10.0000 Y0.0000\nG1\nMCALL\nX50 Y50 F500\n", Sinumerik());
  const auto is_refused = [&](const std::string& block, const std::string& reason) {
    EXPECT_REFUSED_BY(Askew(), Sinumerik(), head + block + "\n" + tail, reason);
  };
  is_refused("HOLES1(0,0,0,5,10,2.5)", "HOLES1: NUM = 2.5: expected a whole number from 1 to 10000");
  is_refused("HOLES1(0,0,0,5,R5,2)", "HOLES1: argument 5 'R5' is no plain number");
  is_refused("HOLES1(0,0,0,5,10)", "HOLES1: expected 6 arguments, found 5");
  is_refused("HOLES1(0,0,0,-5,10,2)", "HOLES1: FDIS and DBH have no sign");
  is_refused("G91\nHOLES2(0,0,20,0,60,6)", "HOLES2: in G91");
  RewriteOptions unknown = Sinumerik();
  unknown.initial_position = {{"Z", 50}, {"B", 0}, {"C", 0}};
  EXPECT_REFUSED_BY(Askew(), unknown, "G90 G17 G71 G0\nMCALL CYCLE81(20,0,2,-10)\nHOLES1(0,0,0,5,10,2)\n",
                    "HOLES1: from which of its ends on is not known");
  is_refused("MCALL\nHOLES2(0,0,20,0,60,6)", "HOLES2: no MCALL of a cycle that is followed stands in front of it");
}

}  // namespace
}  // namespace axiscal::nc
