// Programs whose words stand in the workpiece's frame (tool centre point control).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "core/base/units.h"
#include "core/machine/chain.h"
#include "core/nc/move_reader.h"
#include "core/nc/testing/rewritten.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using testing::Outcome;
using testing::Rewritten;

constexpr double kLengthMm = 200.0;  // of tool 1
const Eigen::Vector3d kGaugeMm(0, 0, 200.0 - testing::kToolMm);

RewriteOptions Options(const std::string& dialect = "fanuc") {
  RewriteOptions options = testing::kAtZero;
  options.dialect = dialect;
  options.tool_lengths = {{1, kLengthMm}, {2, 120.0}};
  options.work_offsets = {
      {dialect == "heidenhain" ? "PRESET" : "G54", {{"X", 100.0}, {"Y", -50.0}, {"Z", 30.0}}},
      {"G55", {{"X", 1.0}}},
      {"G56", {{"C", 0.5}}},
  };
  return options;
}

compensate::Compensator Leaning() {
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  return testing::MustCreate(machine, testing::ConstantErrors(machine, {{"EB0B", testing::kTiltRad}}), kGaugeMm);
}

// The head leans by 41.66 um at 356.3945 mm: X + 41.66 um at B = 0 and Z - 41.66 um at B = 90. With C = 90 the table
// has turned, and what the axis X does is - Y of the words.
TEST(ToolPoint, WordsAreCorrectedInTheWorkpiecesFrame) {
  const auto text = [](const std::string& program, const RewriteOptions& options) {
    const Outcome outcome = Rewritten(program, options, Leaning());
    EXPECT_TRUE(outcome.status.ok()) << outcome.status << "\n" << program;
    return outcome.text;
  };
  EXPECT_EQ(
      text("G90\nG43.4 H1 G1 X10. Y20. Z30. B0. C0. F100\nC90. X12.\nG1 X11. B90. F100\nG91 X1. B-90.\n", Options()),
      "G90\nG43.4 H1 G1 X10.0417 Y20. Z30. B0. C0. F100\nC90. X12. Y19.9583\nG1 X11. B90. Y20.0000 "
      "Z29.9583 F100\nG91 X1. B-90. Y-0.0417 Z0.0417\n");
  EXPECT_EQ(text("G90\nG234 H1 G1 X10. Y20. Z30. B0. C90. F100\n", Options("haas")),
            "G90\nG234 H1 G1 X10. Y19.9583 Z30. B0. C90. F100\n");
  // Named kinds of machining leave the transformation as it is.
  EXPECT_EQ(text("G90 G54 D1\nTRAORI\nG54 ORIAXES\nCYCLE832(0.01,_ORI_FINISH,0.1)\nG1 X10 Y20 Z30 B0 C90 F100\n",
                 Options("sinumerik")),
            "G90 G54 D1\nTRAORI\nG54 ORIAXES\nCYCLE832(0.01,_ORI_FINISH,0.1)\nG1 X10 Y19.9583 Z30 B0 C90 F100\n");
  EXPECT_EQ(
      text("G90 G54 D1\nTRAORI\nG54 ORIAXES\nG1 X10 Y20 Z30 B0 C90 F100\nTRAFOOF\nG54\nG0 X5 Y6 Z7 B0 C90\n",
           Options("sinumerik")),
      "G90 G54 D1\nTRAORI\nG54 ORIAXES\nG1 X10 Y19.9583 Z30 B0 C90 F100\nTRAFOOF\nG54\nG0 X5.0417 Y6 Z7 B0 C90\n");
  EXPECT_EQ(
      text("BEGIN PGM A MM\nTOOL CALL 1 Z S100\nL X+0 Y+0 Z+0 B+0 C+0 FMAX\nL X+10 Y+20 Z+30 C+90 F100 M128\nL X+11\n"
           "M129\nL X+10 Y+20 Z+30 C+90 FMAX\nFUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS\nL X+10 Y+20 Z+30 C+90\n"
           "FUNCTION RESET TCPM\nL X+0 Y+0 Z+0 FMAX\nEND PGM A MM\n",
           Options("heidenhain")),
      "BEGIN PGM A MM\nTOOL CALL 1 Z S100\nL X+0.0417 Y+0 Z+0 B+0 C+0 FMAX\nL X+10 Y+19.9583 Z+30 C+90 F100 M128\n"
      "L X+11\nM129\nL X+10.0417 Y+20 Z+30 C+90 FMAX\nFUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS\n"
      "L X+10 Y+19.9583 Z+30 C+90\nFUNCTION RESET TCPM\nL X+0.0417 Y+0 Z+0 FMAX\nEND PGM A MM\n");
}

// Where the block names Z alone, X and Y stand where they stood: known where their words are the same in both frames.
TEST(ToolPoint, PositionsGoAlongWhereTheControlBeginsAndEnds) {
  const Outcome along =
      Rewritten("G90 G54 G0 X10. Y20. B0. C0.\nG43.4 H1 Z30.\nG1 Y21. F100\nG49\n", Options(), Leaning());
  ASSERT_TRUE(along.status.ok()) << along.status;
  // The head's lean needs 18.28 um of the axis X without the tool, 41.66 um with it.
  EXPECT_EQ(along.text, "G90 G54 G0 X10.0183 Y20. B0. C0.\nG43.4 H1 Z30. X10.0417\nG1 Y21. F100\nG49\n");
  // With the table turned, a word of Y would be what the stated work offset makes of it: 0.98 mm beside it where the
  // offset was measured anew by 1 mm since. Nothing is inserted.
  const Outcome table = Rewritten("G90 G54 G0 X10. Y20. B0. C90.\nG43.4 H1 Z30.\nG1 X11. F100\n", Options(), Leaning());
  EXPECT_THAT(std::string(table.status.message()),
              HasSubstr("the position of Y is unknown: not programmed since line 2"));
  const Outcome back = Rewritten(
      "BEGIN PGM A MM\nTOOL CALL 1 Z S100\nM128\nL X+0 Y+0 Z+0 B+45 C+0 FMAX\nM129\n"
      "L Z+200 FMAX\nEND PGM A MM\n",
      Options("heidenhain"), Leaning());
  ASSERT_TRUE(back.status.ok()) << back.status;
  EXPECT_THAT(back.text, HasSubstr("\nL Z+200 FMAX\n"));  // a retract stays along Z
  // Turned, the length moves the tool along X too.
  const Outcome turned =
      Rewritten("G90 G54 G0 X10. Y20. B30. C90.\nG43.4 H1 Z30.\nG1 X11. F100\n", Options(), Leaning());
  EXPECT_THAT(std::string(turned.status.message()),
              HasSubstr("the position of Y is unknown: not programmed since line 2"));
  // At the end of G43.4 the length goes too: rapid moves stay, feed moves are refused.
  const std::string end = "G90 G43.4 H1 G0 X10. Y20. Z30. B0. C0.\nG49\n";
  EXPECT_THAT(std::string(Rewritten(end + "G1 Z5. F100\n", Options(), Leaning()).status.message()),
              HasSubstr("the position of Y is unknown"));
  const Outcome rapid = Rewritten(end + "G0 Z5.\nX0. Y0. Z0.\n", Options(), Leaning());
  EXPECT_EQ(rapid.text, "G90 G43.4 H1 G0 X10.0417 Y20. Z30. B0. C0.\nG49\nG0 Z5.\nX0.0183 Y0. Z0.\n");
}

TEST(ToolPoint, WhatIsNotKnownIsRefusedByName) {
  struct Case {
    const char *dialect, *program, *reason;
  };
  const Case cases[] = {
      {"fanuc", "G43.4 H7 X1. Y1. Z1.\n", "tool length 7: its value is not stated"},
      {"fanuc", "G43.4 X1. Y1. Z1.\n", "tool length offset without a number"},
      {"fanuc", "G56\nG43.4 H1 X1. Y1. Z1.\n", "the work offset of C is not zero"},
      {"fanuc", "G52 X5.\nG43.4 H1 X1. Y1. Z1.\n", "G92, G52"},
      {"fanuc", "G43.4 H1 X1. Y1. Z1.\nG2 X5. Y5. R9. F9\n", "a circular move under tool centre point control"},
      {"fanuc", "G43.4 H1 X1. Y1. Z1.\nG1 B10. F100\n", "program the move in G93"},
      {"fanuc", "G43.4 H1 X1. Y1. Z1.\nG91 G1 X1. F9\nH2\nX1.\n", "G91 from an unknown position of X"},
      {"fanuc", "G43.4 H1 X1. Y1. Z1.\nM98 P100\nG90 G21 G94 G54 G1 X1. Y1. Z1. B0. C0. F9\n", "M98 (subprogram call)"},
      {"sinumerik", "TRAORI\nG1 X1 Y1 Z1 F9\n", "no tool length is in force"},
      {"sinumerik", "D1\nTRAORI\nG54 ORIAXES\nCYCLE832(0.01,112103)\nG1 X1 Y1 Z1 F9\n", "line 4 may have ended it"},
      {"sinumerik", "D1\nTRAORI(2)\nG1 X1 Y1 Z1 F9\n", "with '(2)'"},
      {"sinumerik", "D1\nTRAORI\nG54 ORIWKS\nG1 X1 Y1 Z1 B5 C30 F9\n", "state ORIAXES"},
      {"sinumerik", "D1\nTRAORI\nG54\nG1 X1 Y1 Z1 B5 C30 F9\n", "state ORIAXES"},
      // 20 deg about C at B30 are no great circle; near B0 a little of it is much of C; the way of half a turn is open.
      {"sinumerik", "D1\nTRAORI\nG54 ORIVECT\nG0 X1 Y1 Z1 B30 C0\nG1 C20 F9\n", "state ORIAXES"},
      {"sinumerik", "D1\nTRAORI\nG54 ORIVECT\nG0 X1 Y1 Z1 B0.05 C0\nG1 X2 C5 F9\n", "state ORIAXES"},
      {"sinumerik", "D1\nTRAORI\nG54 ORIVECT\nG0 X1 Y1 Z1 B0 C0\nG1 X2 C5 F9\n", "state ORIAXES"},
      {"sinumerik", "D1\nTRAORI\nORIAXES\nG1 X1 Y1 Z1 F9\n", "the work offset"},
      {"sinumerik", "G54 D1\nTRAORI\nG54 ORIAXES\nG0 X1 Y1 Z1\nTRAFOOF\nG1 X1 Y1 Z1 F9\n", "the work offset"},
      {"fanuc", "G43.4 H1 P3\nG1 X1. Y1. Z1. F9\n", "with a word P"},
      {"fanuc", "G43.4 H1 X1. Y1. Z1. B0. C0.\nM60\nG1 X1. Y1. Z1. F9\n", "tool centre point control"},
      {"sinumerik", "D1\nTRAORI\nG1 X1 Y1 Z1 F9\nG1 X1 TRAFOOF\n", "which comes first is not known"},
      {"heidenhain", "TOOL CALL 1 Z DL+0.1\nL X+1 Y+1 Z+1 F9 M128\n", "a difference of the tool length (DL)"},
      {"heidenhain", "TOOL CALL 1 Z\nFUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS\nL X+1 Y+1 Z+1 F9\n", "AXIS SPAT"},
      {"heidenhain", "TOOL CALL 1 Z\nL X+1 Y+1 Z+1 B+0 C+0 F9 M128\nL X+2 M129\n", "which comes first is not known"},
  };
  for (const Case& known : cases) {
    const Outcome outcome = Rewritten(known.program, Options(known.dialect), Leaning());
    EXPECT_FALSE(outcome.status.ok()) << known.program << outcome.text;
    std::string reasons;
    for (const Finding& finding : outcome.report.refused) reasons += finding.reason + "\n";
    EXPECT_THAT(reasons, HasSubstr(known.reason)) << known.program;
  }
}

// Short moves of CAM turn the tool alike, by a vector or axis by axis: which of both is in force is not asked.
TEST(ToolPoint, MovesThatTurnTheToolAlikeNeedNoKindOfTurning) {
  const std::string moves = "G0 X1 Y1 Z1 B30 C0\nG1 X2 B40 F900\nX3 B40.5 C0.8\nX4 B40.2 C1.5\n";
  const Outcome by_axes = Rewritten("D1\nTRAORI\nG54 ORIAXES\n" + moves, Options("sinumerik"), Leaning());
  ASSERT_TRUE(by_axes.status.ok()) << by_axes.status;
  const std::string text = by_axes.text.substr(by_axes.text.find("G0 "));
  for (const char* kind : {"ORIVECT", "ORIWKS", "ORIMKS", ""}) {
    const Outcome outcome =
        Rewritten(absl::StrCat("D1\nTRAORI\nG54 ", kind, "\n", moves), Options("sinumerik"), Leaning());
    ASSERT_TRUE(outcome.status.ok()) << kind << outcome.status;
    EXPECT_EQ(outcome.text.substr(outcome.text.find("G0 ")), text) << kind;
    EXPECT_THAT(TextsOf(outcome.report.notes), ::testing::Contains(HasSubstr("makes less than 50 urad"))) << kind;
  }
}

TEST(ToolPoint, MachinesWhoseControlWouldCountOtherwiseAreRefused) {
  using machine::testing::kX, machine::testing::kY, machine::testing::kZ, machine::testing::Linear;
  const machine::Machine mill =
      machine::testing::Make("mill", {Linear("X", kX), Linear("Y", kY), Linear("Z", kZ)}, {}, {});
  const auto compensator = testing::MustCreate(mill, testing::ConstantErrors(mill, {{"EC0Y", 1e-4}}), kGaugeMm);
  RewriteOptions options = testing::InMm();
  options.tool_lengths = {{1, kLengthMm}};
  const Outcome outcome = Rewritten("G90 G43.4 H1 X1. Y1. Z1.\n", options, compensator);
  EXPECT_THAT(std::string(outcome.status.message()), HasSubstr("machine 'mill' has no rotary axis"));
  machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  machine.axes[0].name = "V";
  ToolPointFrame frame(machine, kGaugeMm);
  EXPECT_THAT(frame.problem(), HasSubstr("lacks one of the linear axes X, Y and Z"));
  machine.axes[0].name = "Z";
  machine.tool_direction = Eigen::Vector3d(1, 0, 0);
  EXPECT_THAT(ToolPointFrame(machine, kGaugeMm).problem(), HasSubstr("does not stand along Z at home"));
}

// Axes (mm, rad) at which the nominal tool point is where `words` say, by the chain alone.
compensate::AxisValues Posted(const machine::Machine& machine, const Eigen::Vector3d& words_mm,
                              compensate::AxisValues at, double length_mm) {
  const Eigen::Vector3d tip_mm = kGaugeMm + length_mm * machine.tool_direction;
  const auto tip = [&](const compensate::AxisValues& axes) -> Eigen::Vector3d {
    return machine::TipInTable(machine::EvaluateChain<double>(machine, axes.data(), {}), tip_mm) - kGaugeMm;
  };
  Eigen::Matrix3d columns;
  int axes[3];
  for (int k = 0; k < 3; ++k) {
    axes[k] = machine::FindAxis(machine, std::string(1, static_cast<char>('X' + k)));
    at[axes[k]] = 0;
  }
  const Eigen::Vector3d zero_mm = tip(at);
  for (int k = 0; k < 3; ++k) {
    at[axes[k]] = 1.0;
    columns.col(k) = tip(at) - zero_mm;
    at[axes[k]] = 0.0;
  }
  const Eigen::Vector3d mm = columns.inverse() * (words_mm - zero_mm);
  for (int k = 0; k < 3; ++k) at[axes[k]] = mm[k];
  return at;
}

machine::Machine ForkHead() {
  using machine::testing::kX, machine::testing::kY, machine::testing::kZ;
  return machine::testing::Make(
      "hh",
      {machine::testing::Linear("X", kX), machine::testing::Linear("Y", kY), machine::testing::Linear("Z", kZ),
       machine::testing::Rotary("C", kZ, machine::testing::kOrigin), machine::testing::Rotary("B", kY, {0, 0, 20})},
      {}, {"EX0C", "EY0C", "EA0C", "EB0C", "EA0B", "EC0B", "EX0B", "EC0Y", "EB0Z"});
}

// The tool's path of a program, by the chain: its tip in the table at the ends of the moves, on the machine with
// errors.
std::vector<Eigen::Vector3d> Path(const std::string& program, const machine::Machine& machine,
                                  const machine::ErrorModel& errors, RewriteOptions options, double length_mm) {
  options.tool_tip_mm = kGaugeMm;
  auto interpreter = Interpreter::Create(machine, options);
  EXPECT_TRUE(interpreter.ok()) << interpreter.status();
  const ByteReader reader = TextReader(program);
  MoveReader moves(reader, *std::move(interpreter));
  std::vector<Eigen::Vector3d> path;
  for (Event event;;) {
    const auto has_event = moves.Next(&event);
    EXPECT_TRUE(has_event.ok());
    if (!has_event.ok() || !*has_event) break;
    if (event.step.kind != StepKind::kMove) continue;
    compensate::AxisValues at{};
    for (int i = 0; i < machine.axis_count(); ++i) {
      const bool is_rotary = machine.axes[i].kind == machine::AxisKind::kRotary;
      at[i] = static_cast<double>(event.step.end.ticks[i]) / kTicksPerUnit * (is_rotary ? base::kRadPerDeg : 1.0);
    }
    if (event.step.is_tool_point) {
      Eigen::Vector3d words_mm;
      for (int k = 0; k < 3; ++k)
        words_mm[k] = at[machine::FindAxis(machine, std::string(1, static_cast<char>('X' + k)))];
      at = Posted(machine, words_mm, at, length_mm);
    }
    std::array<shapes::AxisState, machine::kMaxAxes> states;
    for (int i = 0; i < machine.axis_count(); ++i) states[i].position = at[i];
    shapes::State state;
    state.axes = {states.data(), static_cast<size_t>(machine.axis_count())};
    const auto pose = machine::EvaluateChain<double>(machine, at.data(), machine::ErrorsAt(machine, errors, state));
    path.push_back(machine::TipInTable(pose, kGaugeMm + length_mm * machine.tool_direction));
  }
  return path;
}

// A program under tool centre point control and the same one posted in axis positions bring the tool to the same
// places, uncorrected and corrected, on machines with two rotary axes in the table, one, and none.
TEST(ToolPoint, TheProgramAndItsPostedOneGiveTheSameToolPath) {
  for (const machine::Machine& stated : {machine::testing::MultiTasking(), machine::testing::TiltingTable(),
                                         machine::testing::SwivelHead(), ForkHead()}) {
    const machine::Machine machine = testing::CountingOn(stated);
    SCOPED_TRACE(machine.id);
    machine::ErrorModel errors = machine::DeclaredModel(machine);
    double sign = 1.0;
    for (auto& term : errors.terms) {
      term.amplitude[0] = sign * (machine::IsAngle(term.component) ? 8e-5 : 0.04);
      sign = -sign;
    }
    const int x = machine::FindAxis(machine, "X"), c = machine::FindAxis(machine, "C");
    const auto add = [&](const std::string& symbol, double amplitude, const shapes::Shape& shape) {
      machine::ErrorTerm term = machine::ConstantTerm(machine, *machine::ParseErrorSymbol(symbol), amplitude);
      term.shape = shape;
      errors.terms.push_back(term);
    };
    add("EX0X", 0.03, shapes::Linear{x, shapes::Linear::kReferenceMm});
    add("EZ0C", 0.003, shapes::Harmonic{c, 3.0});
    const auto compensator = testing::MustCreate(machine, errors, kGaugeMm);
    const std::string tilt = machine::FindAxis(machine, "B") >= 0 ? "B" : "A";
    std::mt19937 random(20261122);
    std::uniform_real_distribution<double> mm(-120.0, 120.0), deg(-80.0, 80.0);
    std::string under_control = "G90 G21 G43.4 H1\nG0 ", posted = "G90 G21\nG0 ";
    for (int block = 0; block < 40; ++block) {
      const Eigen::Vector3d words_mm(mm(random), mm(random), mm(random));
      compensate::AxisValues at{};
      const double tilt_deg = std::round(deg(random) * 1e4) / 1e4, c_deg = std::round(deg(random) * 2e4) / 1e4;
      at[machine::FindAxis(machine, tilt)] = tilt_deg * base::kRadPerDeg;
      at[c] = c_deg * base::kRadPerDeg;
      const std::string rotary = absl::StrFormat(" %s%.4f C%.4f\n", tilt, tilt_deg, c_deg);
      under_control += absl::StrFormat("X%.6f Y%.6f Z%.6f", words_mm.x(), words_mm.y(), words_mm.z()) + rotary;
      at = Posted(machine, words_mm, at, kLengthMm);
      posted += absl::StrFormat("X%.6f Y%.6f Z%.6f", at[x], at[machine::FindAxis(machine, "Y")],
                                at[machine::FindAxis(machine, "Z")]) +
                rotary;
    }
    RewriteOptions options = testing::InMm();
    options.tool_lengths = {{1, kLengthMm}};
    options.decimals_mm = 6;
    RewriteReport first_report, second_report;
    const auto first = RewriteText(under_control, compensator, options, &first_report);
    // The posted program has the length in its numbers.
    const auto longer = testing::MustCreate(machine, errors, kGaugeMm + kLengthMm * machine.tool_direction);
    const auto second = RewriteText(posted, longer, options, &second_report);
    ASSERT_TRUE(first.ok()) << first.status();
    ASSERT_TRUE(second.ok()) << second.status();
    const machine::ErrorModel none;
    const auto wanted = Path(under_control, machine, none, options, kLengthMm);
    const auto as_posted = Path(posted, machine, none, options, kLengthMm);
    const auto found = Path(*first, machine, errors, options, kLengthMm);
    const auto found_posted = Path(*second, machine, errors, options, kLengthMm);
    const auto before = Path(under_control, machine, errors, options, kLengthMm);
    ASSERT_EQ(wanted.size(), 40u);
    ASSERT_EQ(found.size(), 40u);
    ASSERT_EQ(found_posted.size(), 40u);
    constexpr double kMostMm = 1e-5;  // six decimals on a lever, and 0.01 um of the inverse
    double largest_before_mm = 0;
    for (size_t i = 0; i < wanted.size(); ++i) {
      EXPECT_LE((as_posted[i] - wanted[i]).norm(), kMostMm) << i;
      EXPECT_LE((found[i] - wanted[i]).norm(), kMostMm) << i;
      EXPECT_LE((found[i] - found_posted[i]).norm(), 2 * kMostMm) << i;
      largest_before_mm = std::max(largest_before_mm, (before[i] - wanted[i]).norm());
    }
    EXPECT_GT(largest_before_mm, 0.03);
  }
}

// Along moves too, as verify sees it: their words are interpolated in the workpiece's frame. With --orientation the
// tool's direction as well.
TEST(ToolPoint, VerifyJudgesTheWholePath) {
  for (const bool turns : {false, true}) {
    for (const machine::Machine& stated :
         {machine::testing::MultiTasking(), machine::testing::TiltingTable(), ForkHead()}) {
      machine::Machine machine = testing::CountingOn(stated);
      SCOPED_TRACE(machine.id + (turns ? " orientation" : ""));
      machine::ErrorModel errors = machine::DeclaredModel(machine);
      for (auto& term : errors.terms) term.amplitude[0] = machine::IsAngle(term.component) ? 8e-5 : 0.04;
      const auto compensator = testing::MustCreate(machine, errors, kGaugeMm);
      const std::string tilt = machine::FindAxis(machine, "B") >= 0 ? "B" : "A";
      std::string program =
          "G90 G21 G43.4 H1\nG0 X-50. Y-40. Z20. $20. C10.\nG1 X50. Y40. $60. C100. F2000\nX-50. C-150. $30.\nZ-80. "
          "$35.\nG93 G1 $70. C60. F2.\nX0. Y0. Z0. $45.5 C0. F1.\nG94 X30. F500\nG49\n";
      for (size_t at; (at = program.find('$')) != std::string::npos;) program.replace(at, 1, tilt);
      VerifyOptions verify;
      verify.tool_tip_mm = kGaugeMm;
      verify.reading = testing::InMm();
      verify.reading.tool_lengths = {{1, kLengthMm}};
      verify.reading.orientation = turns;
      RewriteReport report;
      const auto text = RewriteText(program, compensator, verify.reading, &report);
      ASSERT_TRUE(text.ok()) << text.status();
      EXPECT_GE(report.blocks_split, 2);
      const auto verified = VerifyText(program, *text, machine, errors, verify);
      ASSERT_TRUE(verified.ok()) << verified.status() << "\n" << *text;
      EXPECT_EQ(verified->moves, 7);
      EXPECT_EQ(verified->moves_unknown + verified->blocks_unsupported, 0);
      constexpr double kRoundingMm = 0.9e-4;  // three words of four decimals
      EXPECT_LE(verified->end_after.max_mm, 1e-4 + kRoundingMm);
      EXPECT_LE(verified->path_after.max_mm, 1e-3 + kRoundingMm) << "line " << verified->worst_line << "\n" << *text;
      EXPECT_GT(verified->path_before.max_mm, 0.03);
      if (turns && report.blocks_tilted == 0) {
        EXPECT_LE(verified->end_tilt_after.max_rad, 3e-6);
      }
    }
  }
}

TEST(ToolPoint, ANullCorrectionAndPassedBlocksKeepEveryByte) {
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  const auto null = testing::MustCreate(machine, {}, kGaugeMm);
  const std::string program = "G90 G43.4 H1 G0 X1. Y1. Z1. B1.\nG1 X2. F100\nG2 X3. R5.\nG49\n";
  RewriteReport report;
  const auto text = RewriteText(program, null, Options(), &report);
  ASSERT_TRUE(text.ok());
  EXPECT_EQ(*text, program);
  // What is passed begins where the program says, in the frame in which its words stand.
  RewriteOptions options = Options();
  options.on_unsupported = OnUnsupported::kPass;
  const Outcome passed =
      Rewritten("G90 G43.4 H1 G0 X1. Y1. Z1. C90.\nG1 X2. F100\nG2 X3. Y1. R5.\n", options, Leaning());
  ASSERT_TRUE(passed.status.ok()) << passed.status;
  EXPECT_EQ(passed.text, "G90 G43.4 H1 G0 X1. Y0.9583 Z1. C90.\nG1 X2. F100\nG01 Y1.0000\nG2 X3. Y1. R5.\n");
}

}  // namespace
}  // namespace axiscal::nc
