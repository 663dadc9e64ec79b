// Drilling cycles: X and Y right where the drill goes in, Z at the bottom, and what the cycle has no word for.
#include "core/nc/testing/rewritten.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using testing::kAtZero;

RewriteOptions In(const std::string& dialect) {
  RewriteOptions options = kAtZero;
  options.dialect = dialect;
  return options;
}

// Z leans by 100 urad about Y, and the head as in LeaningHead.
constexpr double kLeanRad = 1e-4;
compensate::Compensator LeaningZ() {
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  return testing::MustCreate(machine, testing::ConstantErrors(machine, {{"EB0Z", kLeanRad}}),
                             {0, 0, -testing::kToolMm});
}

TEST(Cycles, EachHoleIsCorrectedWhereItIs) {
  const std::string head = "G90 G17 G21 G94\nG0 X0. Y0. Z50. B0. C0.\n",
                    corrected = "G90 G17 G21 G94\nG0 X0.0417 Y0. Z50. B0. C0.\n";
  for (const char* dialect : {"fanuc", "mazak", "haas", "linuxcnc"}) {
    EXPECT_REWRITTEN(In(dialect), head + "G98 G81 X10. Y5. Z-8. R2. F200\nX20.\nY7.\nG80\nG0 X30.\n",
                     corrected + "G98 G81 X10.0417 Y5. Z-8. R2. F200\nX20.0417\nY7.\nG80\nG0 X30.0417\n");
    EXPECT_REWRITTEN(In(dialect), head + "G99G83X10.Y5.Z-8.R2.Q1.F200\nM8\nX20.\nG80\n",
                     corrected + "G99G83X10.0417Y5.Z-8.R2.Q1.F200\nM8\nX20.0417\nG80\n");
  }
  EXPECT_REWRITTEN(In("fanuc"), head + "G81 Z-8. R2. F200\n", corrected + "G81 Z-8. R2. F200\n");
}

TEST(Cycles, DepthAndRFollowEachHole) {
  // Y leans by 100 urad about X, seen along Y in Z: EA0Y turns what Y carries.
  const machine::Machine machine = testing::CountingOn(machine::testing::MultiTasking());
  const auto compensator =
      testing::MustCreate(machine, testing::ConstantErrors(machine, {{"EA0Y", 1e-4}}), {0, 0, -testing::kToolMm});
  const std::string program =
      "G90 G17 G21 G94\nG0 X0. Y0. Z50. B0. C0.\nG99 G81 X10. Y0. Z-8. R2. F200\nY100. (SECOND)\nX20.\nG80\n";
  const testing::Outcome outcome = testing::Rewritten(program, In("fanuc"), compensator);
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_THAT(outcome.text, HasSubstr(" Z-8.01"));  // 10 um deeper or higher at Y100: inserted, and R with it
  EXPECT_THAT(outcome.text, HasSubstr(" R1.99"));
  EXPECT_EQ(outcome.report.holes, 3);
  VerifyOptions verify;
  verify.tool_tip_mm = {0, 0, -testing::kToolMm};
  verify.reading = In("fanuc");
  const auto report = VerifyText(program, outcome.text, machine, compensator.carried(), verify);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->moves, 4);
  EXPECT_EQ(report->blocks_unsupported, 0);
  EXPECT_GT(report->end_before.max_mm, 9e-3);
  EXPECT_LT(report->end_after.max_mm, 1.5e-3);  // the lean of 10 mm by 100 urad, and rounding
}

TEST(Cycles, TheLeanIsSaidPerHoleAndRefusedAboveTheTolerance) {
  const std::string program = "G90 G17 G21 G94\nG0 X0. Y0. Z50. B0. C0.\nG81 X10. Y0. Z-48. R2. F200\nX20.\nG80\n";
  RewriteOptions options = In("fanuc");
  const testing::Outcome outcome = testing::Rewritten(program, options, LeaningZ());
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_NEAR(outcome.report.max_hole_left_mm, 50 * kLeanRad, 2e-4);
  ASSERT_EQ(outcome.report.left.size(), 2u);
  EXPECT_EQ(outcome.report.left[1].line, 4);
  EXPECT_THAT(outcome.report.left[0].reason, HasSubstr("um are left at the bottom of the hole: the drill leans"));
  options.cycle_tolerance_mm = 0.004;
  EXPECT_REFUSED_BY(LeaningZ(), options, program, "the limit is 4.0 um");
  EXPECT_REFUSED_BY(LeaningZ(), options, program, "--cycle-tolerance-um");
  options.cycle_tolerance_mm = 0.0;
  EXPECT_FALSE(Validate(options).ok());
}

TEST(Cycles, WhatIsNotFollowedIsRefused) {
  const std::string head = "G90 G17 G21 G94\nG0 X0. Y0. Z50. B0. C0.\n";
  const std::vector<std::pair<std::string, std::string>> blocks = {
      {"G81 X10. Z-8. F200\n", "its first block must state R and Z"},
      {"G81 X10. R2. F200\n", "its first block must state R and Z"},
      {"G81 R2. F200\n", "without words of X, Y or Z"},
      {"G81 X10. Z-8. R2. F200\nR3.\n", "without words of X, Y or Z"},
      {"G81 X10. Z8. R2. F200\n", "its bottom is not below R"},
      {"G81 X10. Z-8. R60. F200\n", "R is above where Z stood"},
      {"G91 G81 X10. Z-8. R-40. F200\n", "in G91"},
      {"G81 X10. Z-8. R2. F200\nG91 X5. L3\n", "in G91"},
      {"G18 G81 X10. Z-8. R2. F200\n", "in another plane"},
      {"G93 G81 X10. Z-8. R2. F200\n", "in G93"},
      {"G81 X10. Z-8. R2. C5. F200\n", "with a word of C"},
      {"G81 X10. Z-8. R2. F200\nG83 X20. Q1.\n", "its first block must state R and Z"},
      {"G81 X10. Z-8. R2. F200\nG52 Z3.\nX20.\n", "work offset or tool length changed in it"},
      {"G81 X10. Z-8. R2. E5. F200\n", "with a word E"},
      {"G81 X10. Z-8. R2. F200\n/G99\nX20.\n", "may be skipped"},
      {"G87 X10. Z-8. R2. F200\n", "canned cycle"},
      {"G81 X10. Z-8. R2. L0 F200\n", "no repeat"},
      {"G81 X#1 Z-8. R2. F200\n", "line 3"},
  };
  for (const auto& [block, reason] : blocks) EXPECT_REFUSED(In("fanuc"), head + block, reason);
  EXPECT_REFUSED(In("linuxcnc"), head + "G76 X10. Z-8. R2. F200\n", "canned cycle");
  RewriteOptions turning = In("fanuc");
  turning.orientation = true;
  EXPECT_REFUSED(turning, head + "G81 X10. Z-8. R2. F200\n", "with --orientation");
  EXPECT_REFUSED(In("fanuc"), "M6\nG0 X0. Y0. Z50.\nG81 X10. Z-8. R2. F200\n", "the position of B is unknown");
}

TEST(Cycles, DataWithoutAHoleAndHolesThatMayBeSkipped) {
  const std::string head = "G90 G17 G21 G94\nG0 X0. Y0. Z50. B0. C0.\n",
                    corrected = "G90 G17 G21 G94\nG0 X0.0417 Y0. Z50. B0. C0.\n";
  EXPECT_REWRITTEN(In("haas"), head + "G81 Z-8. R2. L0 F200\nX20.\n",
                   corrected + "G81 Z-8. R2. L0 F200\nX20.0417 Z-8.0000 R2.0000\n");
  EXPECT_REWRITTEN(In("fanuc"), head + "G81 X10. Z-8. R2. F200\n/X15.\nX20. Y0.\n",
                   corrected + "G81 X10.0417 Z-8. R2. F200\n/X15.0417\nX20.0417 Y0. Z-8.0000 R2.0000\n");
}

TEST(Cycles, PassedHolesBeginWhereTheProgramSays) {
  RewriteOptions options = In("fanuc");
  options.on_unsupported = OnUnsupported::kPass;
  EXPECT_REWRITTEN(options,
                   "G21 G0 X1. Y0. Z50.\nG91 G81 X10. Z-8. R-40. F200\nX5.\nG80\nG90 G0 X2. Y0. Z50. B0. C0.\n",
                   "G21 G0 X1.0417 Y0. Z50.\nG00 X1.0000\nG91 G81 X10. Z-8. R-40. F200\nX5.\nG80\nG90 G0 X2.0417 Y0. "
                   "Z50. B0. C0.\n");
}

}  // namespace
}  // namespace axiscal::nc
