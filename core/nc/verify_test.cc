#include "core/nc/verify.h"

#include <absl/strings/numbers.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <numbers>
#include <random>
#include <sstream>

#include "core/base/testing/source_path.h"
#include "core/base/units.h"
#include "core/nc/rewrite.h"
#include "core/nc/testing/yao.h"

namespace axiscal::nc {
namespace {

using base::kUmPerMm;
using ::testing::HasSubstr;

std::string ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file.good()) << path;
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

// The real program of Yao 2022, Fig 4.30: tool point on a circle, B in steps of 0.2778 degrees, tool length 356.3945
// mm.
class RealProgram : public ::testing::Test {
 protected:
  const std::string original_ = ReadFile(base::SourcePath("/tests/data/yao/fig-4.30-original.nc"));
  const machine::Machine machine_ = testing::CountingOn(machine::testing::MultiTasking());
  // Table 4.5: bXB = -24.11 arcsec; spindle-side angles there have the opposite sign of the model, so EB0B = +24.11.
  const machine::ErrorModel errors_ = testing::ConstantErrors(machine_, {{"EB0B", testing::kTiltRad}});
};

// Each block by hand: X + b R cos B, Z - b R sin B, rounded to four decimals; second order below 1e-6 mm.
TEST_F(RealProgram, EveryBlockIsTheHandComputedOne) {
  RewriteReport report;
  const auto text = RewriteText(original_, testing::LeaningHead(), testing::InMm(), &report);
  ASSERT_TRUE(text.ok()) << text.status();
  std::istringstream lines(original_), rewritten(*text);
  std::string line, found;
  ASSERT_TRUE(std::getline(rewritten, found));
  EXPECT_THAT(found, ::testing::StartsWith("(AXISCAL COMPENSATED BY "));
  int blocks = 0;
  while (std::getline(lines, line)) {
    double x, y, z, b, c;
    ASSERT_EQ(std::sscanf(line.c_str(), "G01 X%lf Y%lf Z%lf B%lf C%lf F2000", &x, &y, &z, &b, &c), 5) << line;
    const double b_rad = b * base::kRadPerDeg;
    const double lean_mm = testing::kTiltRad * testing::kToolMm;
    const std::string expected = absl::StrFormat("G01 X%.4f Y0.0000 Z%.4f B%.4f C0.0000 F2000",
                                                 x + lean_mm * std::cos(b_rad), z - lean_mm * std::sin(b_rad), b);
    ASSERT_TRUE(std::getline(rewritten, found));
    EXPECT_EQ(found.substr(0, expected.size()), expected);
    ++blocks;
  }
  EXPECT_FALSE(std::getline(rewritten, found));
  EXPECT_GE(blocks, 10);
  EXPECT_EQ(report.blocks_corrected, blocks);
  EXPECT_NEAR(report.error_before.rms_mm() * kUmPerMm, 41.66, 0.005);
  EXPECT_LT(report.error_after.max_mm * kUmPerMm, 0.08);  // two words rounded to 0.1 um: 0.05 sqrt 2
}

TEST_F(RealProgram, VerificationAgreesWithTheRewritersPrediction) {
  RewriteReport report;
  const auto text = RewriteText(original_, testing::LeaningHead(), testing::InMm(), &report);
  ASSERT_TRUE(text.ok());
  VerifyOptions options;
  options.reading.unit = ProgramUnit::kMillimetre;
  options.tool_tip_mm = {0, 0, -testing::kToolMm};
  const auto verified = VerifyText(original_, *text, machine_, errors_, options);
  ASSERT_TRUE(verified.ok()) << verified.status();
  EXPECT_EQ(verified->moves, report.blocks_corrected);
  EXPECT_NEAR(verified->end_before.max_mm, report.error_before.max_mm, 1e-9);
  EXPECT_NEAR(verified->end_after.max_mm, report.error_after.max_mm, 1e-7);
  EXPECT_LT(verified->path_after.max_mm * kUmPerMm, 0.15);
  EXPECT_GT(verified->path_before.max_mm * kUmPerMm, 20.0);
}

// The published rule (X - b Z, Z + b X about the machine origin) leaves a constant error of (-54.78, +45.59) um: 71 um.
TEST_F(RealProgram, ThePublishedRuleIsFoundOut) {
  std::istringstream lines(original_);
  std::string line, published;
  while (std::getline(lines, line)) {
    double x, y, z, b, c;
    ASSERT_EQ(std::sscanf(line.c_str(), "G01 X%lf Y%lf Z%lf B%lf C%lf", &x, &y, &z, &b, &c), 5);
    const double tilt = -testing::kTiltRad;  // as the paper signs it
    published += absl::StrFormat("G01 X%.4f Y%.4f Z%.4f B%.4f C%.4f F2000\n", x - tilt * z, y, z + tilt * x, b, c);
  }
  VerifyOptions options;
  options.reading.unit = ProgramUnit::kMillimetre;
  options.tool_tip_mm = {0, 0, -testing::kToolMm};
  const auto verified = VerifyText(original_, published, machine_, errors_, options);
  ASSERT_TRUE(verified.ok()) << verified.status();
  EXPECT_GT(verified->end_after.rms_mm() * kUmPerMm, 40.0);
}

// Random five-axis programs on the three structures with all errors at once: ends to the words' rounding, paths to the
// tolerance.
TEST(Verify, AllThreeStructuresStayWithinToleranceAlongTheWholePath) {
  constexpr double kToleranceMm = 0.001;
  constexpr double kRoundingMm = 0.0002;  // words of 0.1 um at both ends of a piece
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const machine::Machine& machine :
       {testing::CountingOn(machine::testing::MultiTasking()), testing::CountingOn(machine::testing::TiltingTable()),
        testing::CountingOn(machine::testing::SwivelHead())}) {
    machine::ErrorModel errors = machine::DeclaredModel(machine);
    for (auto& term : errors.terms) term.amplitude[0] = unit(random) * 5e-5;  // 50 urad or 0.05 um ...
    for (auto& term : errors.terms) {
      if (!machine::IsAngle(term.component)) term.amplitude[0] *= 1e3;  // ... 50 um
    }
    std::string program = "G90 G21\n";
    for (int i = 0; i < 40; ++i) {
      program += absl::StrFormat("N%d G01", 10 * i);
      for (const machine::Axis& axis : machine.axes) {
        const bool is_linear = axis.kind == machine::AxisKind::kLinear;
        absl::StrAppendFormat(&program, " %s%.4f", axis.name,
                              unit(random) * (is_linear          ? 250
                                              : axis.name == "C" ? 180
                                                                 : 90));
      }
      program += i % 3 == 0 ? " F500 (move)\n" : "\n";
    }
    const Eigen::Vector3d tip_mm(0, 0, -150);
    RewriteOptions options = testing::InMm();
    options.tolerance_mm = kToleranceMm;
    RewriteReport report;
    const auto text = RewriteText(program, testing::MustCreate(machine, errors, tip_mm), options, &report);
    ASSERT_TRUE(text.ok()) << text.status();
    VerifyOptions verify;
    verify.reading.unit = ProgramUnit::kMillimetre;
    verify.tool_tip_mm = tip_mm;
    const auto verified = VerifyText(program, *text, machine, errors, verify);
    ASSERT_TRUE(verified.ok()) << verified.status();
    EXPECT_EQ(verified->moves, 40);
    EXPECT_EQ(verified->pieces, 40 + report.blocks_inserted);
    EXPECT_GT(report.blocks_split, 10);
    EXPECT_LT(verified->end_after.max_mm, 0.0001);
    EXPECT_NEAR(verified->end_after.max_mm, report.error_after.max_mm, 0.0001);
    EXPECT_LT(verified->path_after.max_mm, kToleranceMm + kRoundingMm) << machine.id;
    EXPECT_GT(verified->path_before.max_mm, 0.02);

    // Without splitting the ends are as good and the paths are not: what splitting is for.
    options.tolerance_mm = std::numeric_limits<double>::infinity();
    const auto chords = RewriteText(program, testing::MustCreate(machine, errors, tip_mm), options, &report);
    ASSERT_TRUE(chords.ok());
    EXPECT_GT(VerifyText(program, *chords, machine, errors, verify)->path_after.max_mm, 5 * kToleranceMm);
  }
}

// Full turns of C, the tilting axis through +-90, moves of 500 mm, with errors of every shape that a program can
// follow.
TEST(Verify, FullTurnsAndLongMovesWithErrorsOfEveryShape) {
  constexpr double kToleranceMm = 0.002;
  for (const machine::Machine& machine :
       {testing::CountingOn(machine::testing::MultiTasking()), testing::CountingOn(machine::testing::TiltingTable()),
        testing::CountingOn(machine::testing::SwivelHead())}) {
    machine::ErrorModel errors = machine::DeclaredModel(machine);
    for (auto& term : errors.terms) term.amplitude[0] = machine::IsAngle(term.component) ? 8e-5 : -0.04;
    const auto add = [&](const std::string& symbol, double amplitude, const shapes::Shape& shape) {
      machine::ErrorTerm term = machine::ConstantTerm(machine, *machine::ParseErrorSymbol(symbol), amplitude);
      term.shape = shape;
      errors.terms.push_back(term);
    };
    const int x = machine::FindAxis(machine, "X"), y = machine::FindAxis(machine, "Y"),
              z = machine::FindAxis(machine, "Z");
    const int c = machine::FindAxis(machine, "C");
    const std::string tilt = machine::FindAxis(machine, "B") >= 0 ? "B" : "A";
    add("EX0X", 0.03, shapes::Linear{x, shapes::Linear::kReferenceMm});
    add("EY0X", 0.01, shapes::Quadratic{x, shapes::Quadratic::kReferenceMm});
    add("EZ0Y", 0.004, shapes::Bump{y, 120.0, 15.0});
    add("EC0C", 2e-5, shapes::Harmonic{c, 2.0});
    add("EZ0C", 0.003, shapes::Harmonic{c, 9.0});
    add("EZ0Z", 0.005, shapes::Backlash{z});
    const std::string program = absl::StrFormat(
        "G90 G0 X-250. Y-250. Z0. %1$s0. C0.\nG1 X250. F2000\nY250.\nZ200.\nZ150. C360.\nC-360.\n%1$s90.\n%1$s-90.\n"
        "X-250. Y-250. %1$s90. C180.\nZ-100.\nZ100. %1$s0.\nG91 C-720. X100.\nG93 X50. Y50. Z-50. %1$s45. F0.5\n",
        tilt);
    const Eigen::Vector3d tip_mm(0, 0, -150);
    RewriteOptions options = testing::InMm();
    options.tolerance_mm = kToleranceMm;
    RewriteReport report;
    const auto text = RewriteText(program, testing::MustCreate(machine, errors, tip_mm), options, &report);
    ASSERT_TRUE(text.ok()) << text.status();
    VerifyOptions verify;
    verify.reading.unit = ProgramUnit::kMillimetre;
    verify.tool_tip_mm = tip_mm;
    const auto verified = VerifyText(program, *text, machine, errors, verify);
    ASSERT_TRUE(verified.ok()) << verified.status();
    constexpr double kRoundingMm = 0.00015;  // three words of 0.1 um
    EXPECT_EQ(verified->moves, 13);
    EXPECT_LT(verified->end_after.max_mm, kRoundingMm) << machine.id;
    EXPECT_LT(verified->path_after.max_mm, kToleranceMm + kRoundingMm)
        << machine.id << " line " << verified->worst_line;
    EXPECT_LE(verified->path_after.max_mm, report.path_after_max_mm + kRoundingMm);
    EXPECT_GT(verified->path_before.max_mm, 0.05);
    EXPECT_LT(report.blocks_inserted, 1500);
  }
}

TEST(Verify, AnUncompensatedProgramShowsItsError) {
  VerifyOptions options;
  options.reading.unit = ProgramUnit::kMillimetre;
  options.tool_tip_mm = {0, 0, -testing::kToolMm};
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  const auto errors = testing::ConstantErrors(machine, {{"EB0B", testing::kTiltRad}});
  const std::string program = "G1 X0 Y0 Z0 B0 C0\nX10.\n";
  const auto verified = VerifyText(program, program, machine, errors, options);
  ASSERT_TRUE(verified.ok()) << verified.status();
  EXPECT_NEAR(verified->end_after.max_mm * kUmPerMm, 41.66, 0.01);
  EXPECT_EQ(verified->end_after.max_mm, verified->end_before.max_mm);
}

// Chords are shorter than a correction may be: only the last one ends the move.
TEST(Verify, PiecesShorterThanTheLargestCorrectionPairToo) {
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  VerifyOptions options;
  options.reading.unit = ProgramUnit::kMillimetre;
  options.reading.initial_position = {{"X", 0}, {"Y", 0}, {"Z", 0}, {"B", 0}, {"C", 0}};
  std::string chords = "G1 F100\n";
  constexpr int kCount = 100;
  for (int k = 1; k <= kCount; ++k) {
    const double angle = 0.5 * std::numbers::pi * k / kCount;
    absl::StrAppendFormat(&chords, "X%.6f Y%.6f\n", 10.0 * std::sin(angle), 10.0 - 10.0 * std::cos(angle));
  }
  const auto verified =
      VerifyText("G3 X10. Y10. R10. F100\nG1 X10.2\nX10.3\n", chords + "X10.2\nX10.3\n", machine, {}, options);
  ASSERT_TRUE(verified.ok()) << verified.status();
  EXPECT_EQ(verified->moves, 3);
  EXPECT_EQ(verified->pieces, kCount + 2);
  EXPECT_LT(verified->end_after.max_mm, 1e-6);
  EXPECT_LT(verified->path_after.max_mm, 0.001);
}

// The ends of 300 deg are as near as the largest correction; the first chord is not the last one for that.
TEST(Verify, ChordsOfAnArcWhoseEndsAreNearPairToo) {
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  VerifyOptions options;
  options.reading.unit = ProgramUnit::kMillimetre;
  options.reading.max_correction_mm = 5.0;
  options.reading.initial_position = {{"X", 0}, {"Y", 0}, {"Z", 0}, {"B", 0}, {"C", 0}};
  for (const int count : {2, 3, 4, 60}) {
    std::string chords = "G1 F100\n";
    for (int k = 1; k <= count; ++k) {  // about (1.5, 2.598), from X0 Y0 with the clock to X3 Y0
      const double angle = (-120.0 - 300.0 * k / count) * std::numbers::pi / 180.0;
      absl::StrAppendFormat(&chords, "X%.6f Y%.6f\n", 1.5 + 3.0 * std::cos(angle), 2.598076 + 3.0 * std::sin(angle));
    }
    const auto verified = VerifyText("G2 X3. Y0 R-3. F100\nG1 X3.2\n", chords + "X3.2\n", machine, {}, options);
    ASSERT_TRUE(verified.ok()) << verified.status() << count;
    EXPECT_EQ(verified->moves, 2);
    EXPECT_EQ(verified->pieces, count + 1);
    EXPECT_LT(verified->end_after.max_mm, 1e-5) << count;
  }
}

// Between two reversals an arc stays an arc: a straight piece takes up the lost motion, also right before its begin.
TEST(Verify, ArcsWithLostMotionStayArcs) {
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  machine::ErrorModel errors = testing::ConstantErrors(machine, {{"EB0B", testing::kTiltRad}});
  for (const char* symbol : {"EX0X", "EY0Y"}) {
    machine::ErrorTerm backlash = machine::ConstantTerm(machine, *machine::ParseErrorSymbol(symbol), 0.005);
    backlash.shape = shapes::Backlash{machine::FindAxis(machine, std::string(1, symbol[3]))};
    errors.terms.push_back(backlash);
  }
  VerifyOptions options;
  options.reading.unit = ProgramUnit::kMillimetre;
  options.tool_tip_mm = {0, 0, -testing::kToolMm};
  options.reading.initial_position = {{"X", 0}, {"Y", 0}, {"Z", 0}, {"B", 0}, {"C", 0}};
  const auto compensator = compensate::Compensator::Create(machine, errors, {options.tool_tip_mm, {}, {}});
  ASSERT_TRUE(compensator.ok());
  for (const std::string program :
       {"G1 X10. F100\nX20.\nG2 X30. Y10. R10.\nG3 X20. Y20. I-10. J0\nX5. Y5. J-15.\nG2 X25. I10.\nI-10.\nG1 X0\n",
        "G1 X10. F100\nG2 I10.\nG1 X0\n",  // the circle begins where X turns back
        "G91 G2 X20. I10. F100\nX-20. I-10.\nX5.Y5.I5.\nG90 G1 X0\n",
        "G93 G2 X20. I10. F4.\nX0 I-10. F2.\nX20. I10. F2.\nG94 G1 X0 F100\n"}) {
    RewriteReport report;
    const auto text = RewriteText(program, *compensator, options.reading, &report);
    ASSERT_TRUE(text.ok()) << text.status();
    EXPECT_LT(report.blocks_inserted, 25) << *text;
    EXPECT_THAT(*text, HasSubstr("G02"));
    const auto verified = VerifyText(program, *text, machine, errors, options);
    ASSERT_TRUE(verified.ok()) << verified.status() << *text;
    EXPECT_LT(verified->end_after.max_mm, 0.0001);
    EXPECT_LT(verified->path_after.max_mm, options.reading.tolerance_mm) << *text;
  }
}

TEST(Verify, ProgramsThatDoNotPairAreErrors) {
  VerifyOptions options;
  options.reading.unit = ProgramUnit::kMillimetre;
  options.reading.initial_position = {{"X", 0}, {"Y", 0}, {"Z", 0}, {"B", 0}, {"C", 0}};
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  const auto message = [&](const std::string& original, const std::string& other) {
    return std::string(VerifyText(original, other, machine, {}, options).status().message());
  };
  EXPECT_EQ(message("G1 X1.\n", "G1 X1.01\n"), "");
  EXPECT_THAT(message("G1 X1.\n", "G1 X9.\n"),
              HasSubstr("line 1 of the compensated program does not go to the same position as line 1"));
  EXPECT_THAT(message("G1 X1.\nX2.\n", "G1 X1.\n"),
              HasSubstr("line 2 of the original: the compensated program ends before it"));
  EXPECT_THAT(message("G1 X1.\n", "G1 X1.\nX2.\n"),
              HasSubstr("line 2 of the compensated program: the original has no such move"));
  EXPECT_THAT(message("G1 X1.\nB10.\n", "G1 X1.\nB11.\n"), HasSubstr("line 2"));
  EXPECT_THAT(message("G28 X0\n", "G1 X0\n"), HasSubstr("is not the same block"));
}

// One word wrong by 1 um, in any place of a program of short moves, and in any of the three axes: the error behind that
// block is as large, and the block is named.
TEST(Verify, EachWordCounts) {
  constexpr double kWrongMm = 0.001, kRoundingMm = 0.00015;
  constexpr int kBlocks = 40;
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  std::string program;
  for (int i = 0; i < kBlocks; ++i) {
    absl::StrAppendFormat(&program, "G01 X%.4f Y%.4f Z%.4f B%.4f C%.4f F2000\n", 0.09 * i, 80 - 0.03 * i, -0.05 * i,
                          10 + 0.02 * i, 5 - 0.04 * i);
  }
  VerifyOptions options;
  options.reading = testing::InMm();
  options.tool_tip_mm = {0, 0, -testing::kToolMm};
  const auto errors = testing::ConstantErrors(machine, {{"EB0B", testing::kTiltRad}});
  RewriteReport report;
  const auto text = RewriteText(program, testing::LeaningHead(), testing::InMm(), &report);
  ASSERT_TRUE(text.ok()) << text.status();
  const auto clean = VerifyText(program, *text, machine, errors, options);
  ASSERT_TRUE(clean.ok()) << clean.status();
  EXPECT_LT(clean->end_after.max_mm, kRoundingMm);
  int planted = 0;
  for (const char axis : {'X', 'Y', 'Z'}) {
    size_t line_at = text->find("G01");  // behind the head
    for (int i = 0; i < kBlocks; ++i, line_at = text->find('\n', line_at) + 1) {
      const size_t at = text->find(axis, line_at) + 1, end = text->find(' ', at);
      double value = 0;
      ASSERT_TRUE(absl::SimpleAtod(text->substr(at, end - at), &value));
      std::string wrong = *text;
      wrong.replace(at, end - at, absl::StrFormat("%.4f", value + kWrongMm));
      const auto verified = VerifyText(program, wrong, machine, errors, options);
      ASSERT_TRUE(verified.ok()) << verified.status();
      EXPECT_NEAR(verified->end_after.max_mm, kWrongMm, kRoundingMm) << axis << i;
      EXPECT_EQ(verified->worst_line, i + 1) << axis;
      ++planted;
    }
  }
  EXPECT_EQ(planted, 3 * kBlocks);
}

// A tip on the other side than the machine's tool_direction points to would double the error: nobody corrects or
// verifies with it.
TEST(Verify, AToolTipOnTheWrongSideIsRefused) {
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  const auto errors = testing::ConstantErrors(machine, {{"EB0B", testing::kTiltRad}});
  const std::string program = "G90 G1 X1. Y0. Z0. B0. C0. F100\n";
  for (const double side : {1.0, -1.0}) {
    compensate::Options compensation;
    compensation.tool_tip_mm = side * testing::kToolMm * machine.tool_direction;
    VerifyOptions verification;
    verification.tool_tip_mm = compensation.tool_tip_mm;
    verification.reading = testing::InMm();
    const absl::Status of_compensator = compensate::Compensator::Create(machine, errors, compensation).status(),
                       of_verify = VerifyText(program, program, machine, errors, verification).status();
    EXPECT_EQ(of_compensator.ok(), side > 0.0) << of_compensator;
    EXPECT_EQ(of_verify.ok(), side > 0.0) << of_verify;
    if (side > 0.0) continue;
    for (const absl::Status& status : {of_compensator, of_verify})
      EXPECT_THAT(std::string(status.message()), HasSubstr("on the other side than tool_direction"));
  }
}

// What is passed is paired and listed by its lines; the blocks that bring the control back in front of it are none of
// the original's.
TEST(Verify, WhatIsPassedIsNotJudged) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const auto errors = testing::ConstantErrors(machine, {{"EB0B", testing::kTiltRad}});
  VerifyOptions options;
  options.tool_tip_mm = {0, 0, -testing::kToolMm};
  options.reading = testing::InMm();
  options.reading.initial_position = {{"X", 0}, {"Y", 0}, {"Z", 0}, {"B", 0}, {"C", 0}};
  options.reading.on_unsupported = OnUnsupported::kPass;
  const std::string program =
      "G90 G1 X50. Y0. F100\n"  // 1
      "G2 X50. I-#1\n"          // 2: passed
      "G2 X50. I-50.\n"         // 3: from an unknown position
      "G1 X1. Y0. Z0. B0. C0.\n"
      "X2.\n"
      "T2 M6\n"  // 6
      "G0 X1. Y0. Z0.\n"
      "B0. C0.\n"
      "G28 Z0\n"  // 9
      "G2 X1. I-1.\n"
      "G0 Z0.\n"
      "G1 X3. M99\n";
  RewriteReport report;
  const auto text = RewriteText(program, testing::LeaningHead(), options.reading, &report);
  ASSERT_TRUE(text.ok()) << text.status();
  const auto verified = VerifyText(program, *text, machine, errors, options);
  ASSERT_TRUE(verified.ok()) << verified.status() << *text;
  EXPECT_EQ(verified->blocks_passed, 2);
  EXPECT_EQ(verified->blocks_unsupported, 3);
  const auto lines = [](const LineRanges& ranges) {
    std::string all;
    for (const reports::LineRange& range : ranges.listed) absl::StrAppend(&all, range.first, "-", range.last, " ");
    return all;
  };
  EXPECT_EQ(lines(verified->not_judged), "2-3 7-7 9-10 ");
  EXPECT_THAT(verified->not_judged.listed[0].reason, HasSubstr("expression"));
  EXPECT_EQ(lines(report.not_corrected), "2-3 7-7 9-10 12-12 ");
  EXPECT_THAT(ToJson(*verified), HasSubstr("\"ranges_not_judged\": 3"));
  // Under a control that turns the tool otherwise nothing is judged, whatever the words say.
  const std::string tcp = "G90 G1 X1. Y0. Z0. B0. C0. F100\nG43.5 H1 P3\nH1\nX2. Y0. Z0. B0. C0.\n";
  options.reading.tool_lengths = {{1, 0.0}};
  const auto ranges = VerifyText(tcp, tcp, machine, errors, options);
  ASSERT_TRUE(ranges.ok()) << ranges.status();
  EXPECT_EQ(lines(ranges->not_judged), "2-4 ");
}

TEST(Verify, MissingFilesAreNamed) {
  const auto status = VerifyFiles("/no/such/original.nc", "/no/such/other.nc",
                                  testing::CountingOn(machine::testing::MultiTasking()), {}, {})
                          .status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), HasSubstr("/no/such/original.nc"));
}

}  // namespace
}  // namespace axiscal::nc
