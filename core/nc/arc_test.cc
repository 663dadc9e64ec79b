#include "core/nc/arc.h"

#include <numbers>

#include "core/nc/move_reader.h"
#include "core/nc/testing/rewritten.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using testing::kAtZero;
using testing::Outcome;
using testing::Rewritten;

constexpr double kPi = std::numbers::pi;

TEST(Arc, QuartersFullTurnsAndRadii) {
  const auto quarter = ArcAboutCentre({10, 0}, {0, 10}, {0, 0}, true);
  ASSERT_TRUE(quarter.ok());
  EXPECT_NEAR(quarter->sweep_rad, kPi / 2, 1e-15);
  EXPECT_NEAR((quarter->At(0.5) - Eigen::Vector2d(10, 10) / std::sqrt(2)).norm(), 0, 1e-14);
  EXPECT_NEAR(ArcAboutCentre({10, 0}, {0, 10}, {0, 0}, false)->sweep_rad, -1.5 * kPi, 1e-14);
  EXPECT_NEAR(ArcAboutCentre({10, 0}, {10, 0}, {0, 0}, false)->sweep_rad, -2 * kPi, 1e-14);
  EXPECT_FALSE(ArcAboutCentre({10, 0}, {0, 11}, {0, 0}, false).ok());
  EXPECT_FALSE(ArcAboutCentre({10, 0}, {10, 0}, {10, 0}, false).ok());
  EXPECT_NEAR((ArcOfRadius({10, 0}, {0, 10}, 10, true)->centre_mm).norm(), 0, 1e-13);
  EXPECT_NEAR((ArcOfRadius({10, 0}, {0, 10}, -10, true)->centre_mm - Eigen::Vector2d(10, 10)).norm(), 0, 1e-13);
  EXPECT_NEAR(ArcOfRadius({10, 0}, {0, 10}, -10, true)->sweep_rad, 1.5 * kPi, 1e-13);
  EXPECT_FALSE(ArcOfRadius({10, 0}, {10, 0}, 5, true).ok());
  EXPECT_FALSE(ArcOfRadius({10, 0}, {-10, 0}, 9, true).ok());
}

TEST(Arc, TheFittedCentreIsThatOfTheCircle) {
  Eigen::Matrix2Xd points(2, 5);
  for (int i = 0; i < 5; ++i) points.col(i) = Eigen::Vector2d(3, 4) + 7.0 * Eigen::Vector2d(std::cos(i), std::sin(i));
  const Eigen::Vector2d start(10, 4), end(3, 11);
  EXPECT_NEAR((FitCentre(start, end, false, points) - Eigen::Vector2d(3, 4)).norm(), 0, 1e-13);
  EXPECT_NEAR((FitCentre(start, start, true, points) - Eigen::Vector2d(3, 4)).norm(), 0, 1e-13);
}

// A shift of 41.66 um in X: arcs keep their shape, so centres relative to the start keep their words.
TEST(ArcRewriter, AShiftedArcStaysAnArc) {
  EXPECT_REWRITTEN(kAtZero, "G1 X10. Y0.\nG3 X0. Y10. I-10. J0.\nG2 X10. Y0. R10. F500\nG2 I-10.\n",
                   "G1 X10.0417 Y0.\nG3 X0.0417 Y10. I-10. J0.\nG2 X10.0417 Y0. R10. F500\nG2 I-10.\n");
  // Absolute centres move; G91 keeps everything; other planes and helices.
  EXPECT_REWRITTEN(kAtZero, "G90.1 G1 X10. Y0.\nG3 X0. Y10. I0. J0.\n",
                   "G90.1 G1 X10.0417 Y0.\nG3 X0.0417 Y10. I0.0417 J0.\n");
  EXPECT_REWRITTEN(kAtZero, "G1 X10.\nG91 G3 X-10. Y10. I-10.\n", "G1 X10.0417\nG91 G3 X-10. Y10. I-10.\n");
  EXPECT_REWRITTEN(kAtZero, "G1 X10.\nG18 G2 X0. Z10. I-10. Y3.\n", "G1 X10.0417\nG18 G2 X0.0417 Z10. I-10. Y3.\n");
  EXPECT_REWRITTEN(kAtZero, "G1 Y10.\nG19 G2 Y0. Z-10. J-10.\nG17\n", "G1 Y10. X0.0417\nG19 G2 Y0. Z-10. J-10.\nG17\n");
}

TEST(ArcRewriter, WhatIsNoArcIsRefused) {
  EXPECT_REFUSED(kAtZero, "G2 X10.\n", "it has no centre and no radius");
  EXPECT_REFUSED(kAtZero, "G2 X10. I3.\n", "off the circle");
  EXPECT_REFUSED(kAtZero, "G2 X10. R4.\n", "more than twice its radius");
  EXPECT_REFUSED(kAtZero, "G2 X10. I5. R5.\n", "a centre and a radius");
  EXPECT_REFUSED(kAtZero, "G2 X10. K5.\n", "word K is not of its plane");
  EXPECT_REFUSED(kAtZero, "G2 X10. I5. P2\n", "word P in a circular move");
  EXPECT_REFUSED(testing::InMm(), "G2 X10. I5.\n", "starts at an unknown position of X");
}

// Arcs smaller than words can resolve become lines; the program's modal code is restored where it is relied on.
TEST(ArcRewriter, TinyArcsBecomeLinesNeverFullCircles) {
  EXPECT_REWRITTEN(kAtZero,
                   "G1 X1. Y0.\nG2 X1.0002 Y0.0002 I0.0002\nX1.5 Y0.5002 I0.5\nX1.5001 Y0.5003 R0.0001\nG1 X3.\n",
                   "G1 X1.0417 Y0.\nG1 X1.0419 Y0.0002\nG02 X1.5417 Y0.5002 I0.5\nG01 X1.5418 Y0.5003\nG1 X3.0417\n");
}

// The angle by which the arcs of a program turn, all together.
double SweptRad(const std::string& program, const RewriteOptions& options) {
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  auto interpreter = Interpreter::Create(machine, options);
  EXPECT_TRUE(interpreter.ok());
  const ByteReader reader = TextReader(program);
  MoveReader moves(reader, *std::move(interpreter));
  double swept_rad = 0;
  for (Event event; *moves.Next(&event);) {
    EXPECT_EQ(event.step.kind, StepKind::kMove) << event.step.reason << program;
    if (event.step.is_arc) swept_rad += event.step.arc.sweep_rad;
  }
  return swept_rad;
}

// The start of a full circle may have more decimals than the words of its block, which must name it as its end.
TEST(ArcRewriter, AFullCircleWhoseWordsCannotSayItsStartIsSplit) {
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  RewriteOptions options = kAtZero;
  options.dialect = "linuxcnc";
  options.decimals_mm = 4;
  for (const double error_mm : {0.00007, -0.00007, 0.00003}) {
    const auto compensator = testing::MustCreate(
        machine, testing::ConstantErrors(machine, {{"EX0C", 0.02}, {"EY0C", error_mm}}), {0, 0, -testing::kToolMm});
    for (const std::string circle :
         {"G3 X10. Y0. I-5.", "G3 Y0. I-5.", "G3 I-5.", "G3 X10. I-5. Z1.", "G91 G3 X0 Y0 I-5."}) {
      const std::string program = "G1 X10. Y0.00000 F500\n" + circle + "\n";
      const Outcome outcome = Rewritten(program, options, compensator);
      ASSERT_TRUE(outcome.status.ok()) << outcome.status << program;
      EXPECT_NEAR(SweptRad(outcome.text, options), 2 * kPi, 1e-4) << outcome.text;
      // Without a word of Y nothing else is said of it than that it stays.
      EXPECT_EQ(outcome.report.blocks_split, circle.find('Y') != std::string::npos && circle[1] == '3') << outcome.text;
    }
  }
}

struct Structure {
  machine::Machine machine;
  const char* head;  // brings every axis to its place
};

std::vector<Structure> Structures() {
  return {{testing::CountingOn(machine::testing::MultiTasking()), "G90 G21 G17\nG0 X0. Y0. Z0. B0. C0.\n"},
          {testing::CountingOn(machine::testing::TiltingTable()), "G90 G21 G17\nG0 X0. Y0. Z0. A0. C0.\n"},
          {testing::CountingOn(machine::testing::SwivelHead()), "G90 G21 G17\nG0 X0. Y0. Z0. B0. C0.\n"}};
}

machine::ErrorModel AllErrors(const machine::Machine& machine, double angle_rad) {
  machine::ErrorModel errors = machine::DeclaredModel(machine);
  int sign = 1;
  for (auto& term : errors.terms) {
    term.amplitude[0] = sign * (machine::IsAngle(term.component) ? angle_rad : 0.03);
    sign = -sign;
  }
  machine::ErrorTerm bow = machine::ConstantTerm(machine, *machine::ParseErrorSymbol("EY0X"), 0.02);
  bow.shape = shapes::Quadratic{machine::FindAxis(machine, "X"), 250.0};
  errors.terms.push_back(bow);
  return errors;
}

const char* const kArcs =
    "G1 X100. Y0. F1000\nG3 X0. Y100. I-100. J0.\nG3 X-100. Y0. R100.\nG2 X100. Y0. Z10. I100. J0.\n"
    "G2 I-100.\nG3 I-50. Z-20.\nG18 G2 X0. Z30. R150.\nG19 G3 Y150. Z20. R200.\nG17 G2 X-250. Y-100. R250.\n"
    "G3 X-250.0005 Y-100. I250. J10.\nG1 X0. Y0. C360.\nX40.\nG2 X0. Y40. I-40. C0.\nX40. Y0. J-40. C90.\n";

// Ends to the words' rounding, paths to the tolerance, on the three structures; nearly all arcs stay arcs.
TEST(ArcRewriter, ArcsStayWithinTheToleranceOnAllStructures) {
  for (const Structure& structure : Structures()) {
    for (const double tolerance_mm : {0.001, 0.004}) {
      const machine::ErrorModel errors = AllErrors(structure.machine, 1e-4);
      const Eigen::Vector3d tip_mm(0, 0, -150);
      const std::string program = std::string(structure.head) + kArcs;
      RewriteOptions options = testing::InMm();
      options.tolerance_mm = tolerance_mm;
      RewriteReport report;
      const auto text = RewriteText(program, testing::MustCreate(structure.machine, errors, tip_mm), options, &report);
      ASSERT_TRUE(text.ok()) << text.status();
      VerifyOptions verify;
      verify.reading.unit = ProgramUnit::kMillimetre;
      verify.tool_tip_mm = tip_mm;
      const auto verified = VerifyText(program, *text, structure.machine, errors, verify);
      ASSERT_TRUE(verified.ok()) << verified.status() << "\n" << *text;
      EXPECT_EQ(verified->moves, 15);
      constexpr double kRoundingMm = 0.00015;  // three words of 0.1 um
      EXPECT_LT(verified->end_after.max_mm, kRoundingMm) << structure.machine.id;
      EXPECT_LT(verified->path_after.max_mm, tolerance_mm + kRoundingMm) << structure.machine.id << "\n" << *text;
      EXPECT_LE(verified->path_after.max_mm, report.path_after_max_mm + kRoundingMm);
      EXPECT_GT(verified->path_before.max_mm, 0.03);
      EXPECT_LT(report.blocks_inserted, 400) << *text;
    }
  }
}

// The pitch of a ball screw waves several times within a long arc: eight points of it do not show how far it departs.
TEST(ArcRewriter, ErrorsThatWaveWithinAnArcAreSeen) {
  const machine::Machine machine = machine::testing::MultiTasking();
  machine::ErrorModel errors = testing::ConstantErrors(machine, {{"EX0C", 0.03}});
  machine::ErrorTerm pitch = machine::ConstantTerm(machine, *machine::ParseErrorSymbol("EY0X"), 0.008);
  pitch.shape = shapes::Harmonic{machine::FindAxis(machine, "X"), 2.0 * kPi / 20.0};
  pitch.amplitude = {0.0, 0.008};
  errors.terms.push_back(pitch);
  const Eigen::Vector3d tip_mm(0, 0, -150);
  // Of some of the radii all of the eight points stand where the wave is small.
  std::string program = "G0 X0. Y0. Z0. B0. C0. F500\n";
  for (int radius = 60; radius <= 85; ++radius) absl::StrAppend(&program, "G1 X", radius, ".\nG3 I-", radius, ".\n");
  RewriteOptions options = testing::InMm();
  options.tolerance_mm = 0.0065;
  RewriteReport report;
  const auto text = RewriteText(program, testing::MustCreate(machine, errors, tip_mm), options, &report);
  ASSERT_TRUE(text.ok()) << text.status();
  VerifyOptions verify;
  verify.reading.unit = ProgramUnit::kMillimetre;
  verify.tool_tip_mm = tip_mm;
  const auto verified = VerifyText(program, *text, machine, errors, verify);
  ASSERT_TRUE(verified.ok()) << verified.status() << *text;
  EXPECT_LT(verified->path_after.max_mm, options.tolerance_mm + 0.00015);
}

// Lost motion: an arc turns back in each axis at its quadrants. Chords take it up where it turns.
TEST(ArcRewriter, LostMotionIsTakenUpWhereAnAxisTurnsBack) {
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  machine::ErrorModel errors = testing::ConstantErrors(machine, {{"EX0C", 0.02}});
  for (const std::string axis : {"X", "Y"}) {
    machine::ErrorTerm term = machine::ConstantTerm(machine, *machine::ParseErrorSymbol("E" + axis + "0" + axis), 0.01);
    term.shape = shapes::Backlash{machine::FindAxis(machine, axis)};
    errors.terms.push_back(term);
  }
  const Eigen::Vector3d tip_mm(0, 0, -150);
  const std::string program =
      "G0 X0. Y0. Z0. B0. C0.\nG1 X-1. Y-1. F500\nX50. Y0.\nX20.\nX60.\nG3 X0. Y60. I-60. J0. F300\nG3 J-60.\nG1 X-5. "
      "Y50.\n"
      "G91 X3.\nX-3.\nG90 X0. Y0.\n";
  RewriteReport report;
  const auto text = RewriteText(program, testing::MustCreate(machine, errors, tip_mm), testing::InMm(), &report);
  ASSERT_TRUE(text.ok()) << text.status();
  VerifyOptions verify;
  verify.reading.unit = ProgramUnit::kMillimetre;
  verify.tool_tip_mm = tip_mm;
  const auto verified = VerifyText(program, *text, machine, errors, verify);
  ASSERT_TRUE(verified.ok()) << verified.status() << *text;
  EXPECT_LT(verified->end_after.max_mm, 0.0001);
  EXPECT_LT(verified->path_after.max_mm, 0.0012) << *text;
}

}  // namespace
}  // namespace axiscal::nc
