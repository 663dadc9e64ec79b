// Programs with rotary commands corrected: what is written, and what the chain says of it.
#include <numbers>
#include <random>
#include <sstream>

#include "core/base/units.h"
#include "core/nc/testing/rewritten.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

using base::kDegPerRad;
using base::kRadPerDeg;
using base::kUmPerMm;
using base::kUradPerRad;
using testing::From;
using ::testing::HasSubstr;
using testing::kAtZero;
using testing::Outcome;
using testing::Rewritten;

constexpr double kWordRad = 0.00005 * kRadPerDeg;  // half a word of four decimals: 0.87 urad

RewriteOptions Turning(RewriteOptions options = kAtZero) {
  options.orientation = true;
  return options;
}

struct Case {
  machine::Machine machine;
  machine::ErrorModel errors;
  Eigen::Vector3d tip_mm{0, 0, -180};

  compensate::Compensator compensator() const { return testing::MustCreate(machine, errors, tip_mm); }
};

Case Of(machine::Machine machine, const std::vector<std::pair<std::string, double>>& values) {
  Case machine_case;
  machine_case.errors = testing::ConstantErrors(machine, values);
  machine_case.machine = std::move(machine);
  return machine_case;
}

VerifyReport Verified(const Case& machine_case, const std::string& program, const std::string& text,
                      const RewriteOptions& reading) {
  VerifyOptions options;
  options.reading.unit = ProgramUnit::kMillimetre;
  options.tool_tip_mm = machine_case.tip_mm;
  options.reading = reading;
  const auto report = VerifyText(program, text, machine_case.machine, machine_case.errors, options);
  EXPECT_TRUE(report.ok()) << report.status() << '\n' << text;
  return report.ok() ? *report : VerifyReport();
}

// EB0B = 0.0057 deg: B gives it back, and the linear axes have nothing to do.
TEST(Orientation, RotaryWordsAreCorrectedAndInsertedByTheRulesOfWords) {
  const Case leaning = Of(testing::CountingOn(machine::testing::MultiTasking()), {{"EB0B", 0.0057 * kRadPerDeg}});
  const auto text = [&](const std::string& program, const RewriteOptions& options) {
    const Outcome outcome = Rewritten(program, options, leaning.compensator());
    EXPECT_TRUE(outcome.status.ok()) << outcome.status;
    return outcome.text;
  };
  // Decimals of the word or of the machine; bytes of C stay; never -0.0000.
  EXPECT_EQ(text("G1 X1. Y2. Z3. B10. C20.5\n", Turning()), "G1 X1. Y2. Z3. B9.9943 C20.5\n");
  EXPECT_EQ(text("G1 B0.00573\nB0.0057\n", Turning()), "G1 B0.00003\nB0.0000\n");
  // The block lacks B: inserted, with the sign and blanks of inserted words.
  EXPECT_EQ(text("G1 X1. (first)\nX2.\n", Turning()), "G1 X1. B-0.0057 (first)\nX2.\n");
  EXPECT_EQ(text("g1x1.y0.\n", Turning()), "g1x1.y0.b-0.0057\n");
  // Another decimal is missing of 100 urad: the linear axes keep the point where B cannot.
  const Case odd = Of(testing::CountingOn(machine::testing::MultiTasking()), {{"EB0B", 100e-6}});
  EXPECT_EQ(Rewritten("G1 X1. B10.\n", Turning(), odd.compensator()).text, "G1 X1.0001 B9.9943\n");
  // G91: differences of what was commanded.
  EXPECT_EQ(text("G91 G1 B1.\nB1.\nX1.\n", Turning()), "G91 G1 B0.9943\nB1.\nX1.\n");
  // Full turns stay turns: no jump by 360.
  EXPECT_EQ(text("G1 C720. B10.\nC-1080.\n", Turning()), "G1 C720. B9.9943\nC-1080.\n");
  // Without the option rotary words stay.
  EXPECT_EQ(text("G1 X1. Y2. Z3. B0. C20.5\n", kAtZero), "G1 X1.0179 Y2. Z3. B0. C20.5\n");
}

// By the sign of its word an axis at 10 deg turns by 359.99 to reach 9.99, by the difference one at 0 does to reach
// -0.01.
TEST(Orientation, NoWordTurnsAnAxisTheLongWayRound) {
  using machine::RollOver;
  const auto on = [](RollOver roll_over, std::optional<double> travel_rad = std::nullopt) {
    Case leaning = Of(testing::CountingOn(machine::testing::MultiTasking()), {{"EB0B", 0.0057 * kRadPerDeg}});
    machine::Axis& b = leaning.machine.axes[static_cast<size_t>(machine::FindAxis(leaning.machine, "B"))];
    b.roll_over = roll_over;
    if (travel_rad) b.min_position = -*travel_rad, b.max_position = *travel_rad;
    return leaning;
  };
  const auto refusal = [](const std::string& program, const Case& machine_case) {
    return std::string(Rewritten(program, Turning(), machine_case.compensator()).status.message());
  };
  EXPECT_THAT(refusal("G1 X1.\n", on(RollOver::kBySign)), HasSubstr("turns B, which the block does not name"));
  EXPECT_THAT(refusal("G1 X1.\n", on(RollOver::kByDifference)), HasSubstr("by the difference"));
  const std::string unstated = "state in machine.json how the axis counts (roll_over)";
  EXPECT_THAT(refusal("G1 X1.\n", on(RollOver::kUnstated)), HasSubstr(unstated));
  EXPECT_THAT(refusal("G1 X1. B0.\n", on(RollOver::kUnstated)), HasSubstr("turns B across 0"));
  // Differences, positions far from 0, and axes that go on counting or the shorter way are as they were.
  for (const auto& [program, machine_case] :
       std::vector<std::pair<std::string, Case>>{{"G91 G1 X1.\n", on(RollOver::kBySign)},
                                                 {"G1 X1. B10.\nG1 X2.\n", on(RollOver::kUnstated)},
                                                 {"G1 X1. B0.\nG1 X2.\n", on(RollOver::kUnstated, 2.0)},
                                                 {"G1 X1. B0.\n", on(RollOver::kNone)},
                                                 {"G1 X1. B0.\n", on(RollOver::kShortest)}})
    EXPECT_TRUE(Rewritten(program, Turning(), machine_case.compensator()).status.ok()) << program;
  // Nor does the way back in front of what is passed.
  RewriteOptions passing = Turning();
  passing.on_unsupported = OnUnsupported::kPass;
  for (const RollOver way : {RollOver::kUnstated, RollOver::kBySign, RollOver::kNone}) {
    const Outcome outcome = Rewritten("G91 G1 X1. F100\nG90\nM98 P1\n", passing, on(way).compensator());
    EXPECT_EQ(outcome.status.ok(), way == RollOver::kNone) << outcome.status << outcome.text;
  }
}

// EBX grows along X, so the correction of B does, by 4 thousandths of a degree in 100 mm: a word that says in the
// program what the one before it said becomes another one. An axis whose way is not known may go nearly a full turn
// for it.
Case Twisted(machine::RollOver roll_over, double sign = 1.0) {
  Case twisted = Of(testing::CountingOn(machine::testing::MultiTasking()), {{"EBX", sign * 0.004 * kRadPerDeg}});
  twisted.errors.terms[0].shape = shapes::Linear{machine::FindAxis(twisted.machine, "X"), 100.0};
  twisted.machine.axes[static_cast<size_t>(machine::FindAxis(twisted.machine, "B"))].roll_over = roll_over;
  return twisted;
}

TEST(Orientation, ANamedWordTurnsAnAxisOfUnknownWayOnlyAsTheProgramDoes) {
  using machine::RollOver;
  const std::string head = "G90 G1 X50. B10. F500\n";
  const std::string unstated = "state in machine.json how the axis counts (roll_over)";
  for (const double sign : {1.0, -1.0}) {
    const auto compensator = Twisted(RollOver::kUnstated, sign).compensator();
    // The source never turns B, or by less than the correction and the other way.
    for (const std::string line : {"X100. B10.", "X0. B10.", sign > 0 ? "X100. B10.001" : "X100. B9.999"}) {
      EXPECT_REFUSED_BY(compensator, Turning(), head + line + "\n", "turns B another way than the program does");
      EXPECT_REFUSED_BY(compensator, Turning(), head + line + "\n", unstated);
    }
    for (const std::string line : {"X100. B11.", "X100. B9.", "X0. B11.", "X0. B9.", "X50. B10.", "Y5. B10.", "X50."})
      EXPECT_TRUE(Rewritten(head + line + "\n", Turning(), compensator).status.ok()) << line;
    for (const RollOver way : {RollOver::kNone, RollOver::kShortest}) {
      const auto known = Twisted(way, sign).compensator();
      EXPECT_TRUE(Rewritten(head + "X100. B10.\n", Turning(), known).status.ok());
    }
  }
  // What is written where the way is known: B stands still in the program, and turns back.
  const Outcome known =
      Rewritten("G90 G1 X50. Y0. B10. F500\nX100. Y0. B10.\n", Turning(), Twisted(RollOver::kNone).compensator());
  EXPECT_THAT(known.text, HasSubstr("B9.9980 "));
  EXPECT_THAT(known.text, HasSubstr("B9.9960 "));
}

TEST(Orientation, WhatIsPassedTurnsAnAxisOfUnknownWayOnlyAsTheProgramDoes) {
  RewriteOptions passing = Turning();
  passing.on_unsupported = OnUnsupported::kPass;
  const auto compensator = Twisted(machine::RollOver::kUnstated).compensator();
  // B stands at 10 in front of the block that is passed.
  const Outcome fine = Rewritten("G90 G1 X0. B10. F500\nX100. B10.\nX100. B20.\n", passing, compensator);
  ASSERT_TRUE(fine.status.ok()) << fine.status;
  EXPECT_THAT(fine.text, HasSubstr("\nX100. B10.\n"));
  EXPECT_THAT(fine.text, HasSubstr("B19.9960"));
  EXPECT_EQ(fine.report.blocks_corrected, 2);
  // It stands at 9.998, and 10 is where the program says that it stands.
  EXPECT_REFUSED_BY(compensator, passing, "G90 G1 X50. B10. F500\nX100. B10.\n",
                    "would turn it another way than the program does");
}

// C turns once, and the correction of B rises and falls on the way: at both ends it is none.
TEST(Orientation, ASplitMoveThatMayTurnAnAxisTheLongWayIsPassed) {
  Case waving = Of(testing::CountingOn(machine::testing::MultiTasking()), {{"EB0C", 0.0}, {"EX0C", 0.01}});
  waving.errors.terms[0].shape = shapes::Harmonic{machine::FindAxis(waving.machine, "C"), 1.0};
  waving.errors.terms[0].amplitude = {0.0, 100e-6};
  waving.machine.axes[static_cast<size_t>(machine::FindAxis(waving.machine, "B"))].roll_over =
      machine::RollOver::kUnstated;
  RewriteOptions options = Turning();
  options.tolerance_mm = 0.002;
  const std::string head = "G90 G1 X10. Y0. Z0. B0. C0. F500\n", turn = "C360.\n", tail = "X20.\n";
  const auto compensator = waving.compensator();
  EXPECT_REFUSED_BY(compensator, options, head + turn + tail, "line 2: 'C360.': the correction turns B, which");
  options.on_unsupported = OnUnsupported::kPass;
  const Outcome passed = Rewritten(head + turn + tail, options, compensator);
  ASSERT_TRUE(passed.status.ok()) << passed.status;
  EXPECT_THAT(passed.text, HasSubstr("\nC360.\n"));
  EXPECT_EQ(passed.report.blocks_corrected, 2);
  EXPECT_EQ(passed.report.blocks_split, 0);
}

// M126 of the block that is passed acts in that block, not in the one that is written in front of it.
TEST(Orientation, TheWayBackIsThatOfTheStateInFrontOfTheBlock) {
  Case leaning = Of(testing::CountingOn(machine::testing::MultiTasking()), {{"EB0B", 0.0057 * kRadPerDeg}});
  leaning.machine.axes[static_cast<size_t>(machine::FindAxis(leaning.machine, "B"))].roll_over =
      machine::RollOver::kBySign;
  RewriteOptions passing = Turning();
  passing.dialect = "heidenhain";
  passing.on_unsupported = OnUnsupported::kPass;
  const auto compensator = leaning.compensator();
  const std::string shorter = "L M126\nL X+1 R0 F500\n", rest = " X+Q1 R0 F500\n";
  const std::string not_known = "which way the axis would turn back is not known";
  EXPECT_REFUSED_BY(compensator, passing, shorter + "L M127\nL M126" + rest, not_known);
  const Outcome back = Rewritten(shorter + "L M127" + rest, passing, compensator);
  ASSERT_TRUE(back.status.ok()) << back.status;
  EXPECT_THAT(back.text, HasSubstr(" B+0.0000\nL M127"));
  // A word that was written for the shorter way says none itself.
  const std::string named = "L M126\nL X+1 B+10 R0 F500\n";
  EXPECT_TRUE(Rewritten(named + "L" + rest, passing, compensator).status.ok());
  EXPECT_REFUSED_BY(compensator, passing, named + "L M127\nL" + rest, not_known);
}

TEST(Orientation, IncrementalRotaryWordsDoNotCollectRounding) {
  const Case leaning = Of(testing::CountingOn(machine::testing::MultiTasking()), {{"EB0B", 100e-6}, {"EC0B", 20e-6}});
  std::string program = "G91 G1\n";
  for (int i = 0; i < 3000; ++i) program += "B0.03 C0.1\n";
  const Outcome outcome = Rewritten(program, Turning(), leaning.compensator());
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  double b = 0, c = 0;
  std::istringstream lines(outcome.text);
  for (std::string line; std::getline(lines, line);) {
    if (const size_t at = line.find('B'); at != std::string::npos) b += std::stod(line.substr(at + 1));
    if (const size_t at = line.find('C'); at != std::string::npos) c += std::stod(line.substr(at + 1));
  }
  EXPECT_NEAR(b, 90.0 - 100e-6 * kDegPerRad, 0.00006);
  EXPECT_NEAR(std::abs(c - 300.0), 20e-6 * kDegPerRad, 0.00006);  // at B = 90 C turns the tilt away one to one
}

// A five-axis program with full turns of C and B through +-90 on each of the three structures: the chain finds point
// and direction within the rounding of words, where without the option the direction is off by the machine's errors.
TEST(Orientation, TheChainFindsPointAndDirectionOnAllThreeStructures) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const machine::Machine& machine :
       {testing::CountingOn(machine::testing::MultiTasking()), testing::CountingOn(machine::testing::TiltingTable()),
        testing::CountingOn(machine::testing::SwivelHead())}) {
    Case machine_case;
    machine_case.errors = machine::DeclaredModel(machine);
    for (auto& term : machine_case.errors.terms)
      term.amplitude[0] = unit(random) * (machine::IsAngle(term.component) ? 50e-6 : 0.03);
    const std::string tilt = machine::FindAxis(machine, "A") >= 0 ? "A" : "B";
    machine_case.machine = machine;
    std::string program = "G90 G94 G0 X0. Y0. Z0. " + tilt + "25. C0.\nG1 F1000\n";
    for (int i = 0; i <= 120; ++i) {
      const double tilt_deg = 25.0 + 70.0 * std::abs(std::sin(0.05 * i));
      program += absl::StrFormat("X%.4f Y%.4f Z%.4f %s%.4f C%.4f\n", 100 * std::cos(0.1 * i), 80 * std::sin(0.1 * i),
                                 -50 + 0.5 * i, tilt, tilt_deg, 9.0 * i);
    }
    program += "X100. Y20.\nG3 X60. Y60. I-40. J0.\nG2 X100. Y20. R40. C1100.\n";
    RewriteOptions options = Turning(testing::InMm());
    options.max_correction_mm = 2.0;
    options.max_rotary_correction_rad = 0.2 * kRadPerDeg;
    options.initial_position = {{"X", 0}, {"Y", 0}, {"Z", 0}, {tilt, 0}, {"C", 0}};
    const Outcome outcome = Rewritten(program, options, machine_case.compensator());
    ASSERT_TRUE(outcome.status.ok()) << machine.id << outcome.status;
    const VerifyReport report = Verified(machine_case, program, outcome.text, options);
    EXPECT_EQ(report.moves, 125);
    EXPECT_GT(report.end_tilt_before.max_rad * kUradPerRad, 30.0) << machine.id;
    EXPECT_LT(report.end_tilt_after.max_rad, 1.5 * kWordRad) << machine.id;  // two words
    EXPECT_GT(report.end_before.max_mm * kUmPerMm, 20.0);
    EXPECT_LT(report.end_after.max_mm * kUmPerMm, 0.09) << machine.id;  // three words of 0.1 um
    EXPECT_LT(report.path_after.max_mm, options.tolerance_mm + 0.0002) << machine.id;
    EXPECT_LT(report.path_tilt_after.max_rad, options.tolerance_rad + 1.5 * kWordRad) << machine.id;
    EXPECT_NEAR(outcome.report.tilt_before.max_rad, report.end_tilt_before.max_rad, 1e-6) << machine.id;
    EXPECT_EQ(outcome.report.blocks_tilted, 0);
  }
}

TEST(Orientation, WhatIsNotReachedIsListedWithItsSizeAndLine) {
  const Case leaning = Of(testing::CountingOn(machine::testing::MultiTasking()), {{"EA0B", 100e-6}});
  const Outcome outcome = Rewritten("G1 X1. B0.\nB1.\nB30.\n", Turning(), leaning.compensator());
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_EQ(outcome.report.blocks_tilted, 2);
  ASSERT_EQ(outcome.report.tilted.size(), 2u);
  EXPECT_EQ(outcome.report.tilted[0].line, 1);
  EXPECT_THAT(outcome.report.tilted[0].reason, HasSubstr("100 urad off: no rotary axis turns the tool that way"));
  EXPECT_EQ(outcome.report.tilted[1].line, 2);
  EXPECT_THAT(outcome.report.tilted[1].reason, HasSubstr("nearly singular"));
  EXPECT_THAT(outcome.report.tilted[1].reason, HasSubstr("the bound is 0.05 deg"));
  EXPECT_THAT(reports::ToJson(ReportOf(outcome.report)), HasSubstr("\"blocks_not_reached\": 2"));
  // The bound is the user's.
  RewriteOptions wide = Turning();
  wide.max_rotary_correction_rad = 0.02;
  wide.max_correction_mm = 10;
  EXPECT_EQ(Rewritten("G1 X1. B1.\n", wide, leaning.compensator()).report.blocks_tilted, 0);
}

TEST(Orientation, MovesAreSplitWhereTheDirectionBends) {
  const Case leaning = Of(testing::CountingOn(machine::testing::MultiTasking()), {{"EA0B", 100e-6}});
  const std::string program = "G0 X0. B20.\nG1 X100. Z-50. B40. C0. F500\nB80. C90.\n";
  RewriteOptions options = Turning();
  options.tolerance_mm = 0.001;
  options.tolerance_rad = 2e-6;
  const Outcome fine = Rewritten(program, options, leaning.compensator());
  ASSERT_TRUE(fine.status.ok()) << fine.status;
  EXPECT_GE(fine.report.blocks_split, 1);
  const VerifyReport report = Verified(leaning, program, fine.text, options);
  EXPECT_LT(report.path_after.max_mm, 0.0012);
  EXPECT_LT(report.path_tilt_after.max_rad, options.tolerance_rad + 1.5 * kWordRad);
  options.tolerance_rad = 1e-4;
  const Outcome coarse = Rewritten(program, options, leaning.compensator());
  EXPECT_LT(coarse.report.blocks_inserted, fine.report.blocks_inserted);
}

TEST(Orientation, TravelLimitsHoldForRotaryCorrections) {
  Case leaning = Of(testing::CountingOn(machine::testing::MultiTasking()), {{"EB0B", 100e-6}});
  leaning.machine.axes[static_cast<size_t>(machine::FindAxis(leaning.machine, "B"))].min_position = 0.0;
  const Outcome outcome = Rewritten("G1 X1. B0.\n", Turning(), leaning.compensator());
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_THAT(outcome.text, ::testing::StartsWith("G1 X1.01"));  // the point is right, the direction is not
  ASSERT_EQ(outcome.report.tilted.size(), 1u);
  EXPECT_THAT(outcome.report.tilted[0].reason, HasSubstr("100 urad off: a rotary axis would leave its travel"));
}

// Controls may take C the shorter way round: at half a turn a correction decides which.
TEST(Orientation, HalfTurnsAreNoted) {
  const Case leaning = Of(machine::testing::MultiTasking(), {{"EA0B", 20e-6}});
  const Outcome outcome = Rewritten("G0 B30.\nC170.\nC-10.\nC170.\n", Turning(), leaning.compensator());
  EXPECT_THAT(TextsOf(outcome.report.notes), ::testing::ElementsAre(HasSubstr("line 3: a move of C by half a turn")));
}

TEST(Orientation, AMachineWithoutARotaryAxisRefusesTheOption) {
  using namespace machine::testing;  // NOLINT
  const machine::Machine machine = Make("three", {Linear("X", kX), Linear("Y", kY), Linear("Z", kZ)}, {}, {});
  const Outcome outcome = Rewritten("G1 X1.\n", Turning(testing::InMm()), testing::MustCreate(machine, {}, {0, 0, 0}));
  EXPECT_EQ(outcome.status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(outcome.status.message()), HasSubstr("machine 'three' has no rotary axis"));
}

TEST(Orientation, OptionsAreChecked) {
  RewriteOptions options = testing::InMm();
  options.max_rotary_correction_rad = 0.2;
  EXPECT_THAT(std::string(Validate(options).message()), HasSubstr("max_rotary_correction_rad = 0.2, must be > 0"));
  options = {};
  options.tolerance_rad = 0;
  EXPECT_THAT(std::string(Validate(options).message()), HasSubstr("tolerance_rad = 0, must be > 0"));
}

}  // namespace
}  // namespace axiscal::nc
