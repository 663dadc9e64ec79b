// Programs that do not say whether they are in inch or mm.
#include "core/nc/testing/rewritten.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using testing::kAtZero;
using testing::LeaningHead;
using testing::Rewritten;

RewriteOptions Of(ProgramUnit unit, const std::string& dialect = "fanuc") {
  RewriteOptions options = kAtZero;
  options.unit = unit;
  options.dialect = dialect;
  return options;
}

TEST(Unit, IsAskedForWhereNothingStatesIt) {
  const RewriteOptions unstated = Of(ProgramUnit::kUnstated);
  for (const char* program : {"G90 G1 X1. F100\nX2.\n", "B10.\n", "G92 X0.\n", "G52 X5.\n", "G2 X2. I1.\n"})
    EXPECT_REFUSED(unstated, program, "state it with --unit mm or --unit inch");
  EXPECT_REFUSED(Of(ProgramUnit::kUnstated, "sinumerik"), "G1 X1\n", "--unit");
  EXPECT_REFUSED(Of(ProgramUnit::kUnstated, "linuxcnc"), "G1 X1\n", "--unit");
  // A name is not a unit.
  EXPECT_REFUSED(Of(ProgramUnit::kUnstated, "heidenhain"), "0 BEGIN PGM INCH\n1 L X+1 R0\n", "--unit");
  EXPECT_REFUSED(Of(ProgramUnit::kUnstated, "heidenhain"), "0 BEGIN PGM INCH5\n1 L X+1 R0\n", "--unit");
  EXPECT_REFUSED(Of(ProgramUnit::kUnstated, "heidenhain"), "1 L X+1 R0\n", "--unit");
  // Once, not for each of its blocks.
  const testing::Outcome twice = Rewritten("G1 X1.\nX2.\n", unstated);
  EXPECT_EQ(twice.report.blocks_refused, 2);
  EXPECT_EQ(twice.report.refused.size(), 1u);
}

TEST(Unit, MovesInFrontOfTheFirstCodeStayAndAreListed) {
  RewriteOptions passing = Of(ProgramUnit::kUnstated);
  passing.on_unsupported = OnUnsupported::kPass;
  RewriteReport report;
  const auto text =
      RewriteText("G1 X1.\nX2.\nG21 X3. Y0. Z0. B0. C0.\n", LeaningHead(), passing, &report);
  ASSERT_TRUE(text.ok());
  EXPECT_THAT(*text, HasSubstr("G1 X1.\nX2.\nG21 X3.0417 Y0. Z0. B0. C0.\n"));
  ASSERT_EQ(report.passed.size(), 1u);
  EXPECT_THAT(report.passed[0].reason, HasSubstr("--unit"));
}

TEST(Unit, WhatIsStatedHoldsUntilTheProgramSaysAnother) {
  EXPECT_REWRITTEN(Of(ProgramUnit::kMillimetre), "G1 X1.\n", "G1 X1.0417\n");
  EXPECT_REWRITTEN(Of(ProgramUnit::kInch), "G1 X1.\n", "G1 X1.00164\n");
  EXPECT_REWRITTEN(Of(ProgramUnit::kInch), "G21 G1 X1.\n", "G21 G1 X1.0417\n");
  EXPECT_REWRITTEN(Of(ProgramUnit::kUnstated), "G21 G1 X1.\n", "G21 G1 X1.0417\n");
  EXPECT_REWRITTEN(Of(ProgramUnit::kUnstated), "G20 G1 X1.\n", "G20 G1 X1.00164\n");
  EXPECT_REWRITTEN(Of(ProgramUnit::kUnstated, "heidenhain"), "0 BEGIN PGM A mm\n1 L X+1 R0\n",
                   "0 BEGIN PGM A mm\n1 L X+1.0417 R0\n");
}

// Behind its end another program of the text begins in the unit that is in force, which may be either.
TEST(Unit, FurtherProgramsOfOneTextStateTheirs) {
  const std::string second = "O2\nG1 X1. Y0. Z0. B0. C0.\n";
  EXPECT_REFUSED(Of(ProgramUnit::kUnstated), "O1\nG21 G1 X1.\nM30\n" + second, "unit");
  EXPECT_REFUSED(Of(ProgramUnit::kMillimetre), "O1\nG20 G1 X1.\nM30\n" + second, "unit");
  EXPECT_TRUE(Rewritten("O1\nG21 G1 X1.\nM30\n" + second, Of(ProgramUnit::kMillimetre)).status.ok());
}

TEST(Unit, ASubprogramMayLeaveAnother) {
  RewriteOptions passing = Of(ProgramUnit::kMillimetre);
  passing.on_unsupported = OnUnsupported::kPass;
  const std::string behind = "G90 G94 G17 G54 G49\nG0 X1. Y0. Z0. B0. C0.\n";
  passing.work_offsets = {{"G54", {}}};
  EXPECT_REWRITTEN(passing, "G1 X1.\nM98 P7\n" + behind, "G1 X1.0417\nG01 X1.0000\nM98 P7\n" + behind);
  EXPECT_REWRITTEN(passing, "G1 X1.\nM98 P7\nG21\n" + behind,
                   "G1 X1.0417\nG01 X1.0000\nM98 P7\nG21\nG90 G94 G17 G54 G49\nG0 X1.0417 Y0. Z0. B0. C0.\n");
}

TEST(Unit, ANullCorrectionAsksForNothing) {
  RewriteReport report;
  const auto text = RewriteText("G1 X1.\n", testing::PerfectMachine(), Of(ProgramUnit::kUnstated), &report);
  ASSERT_TRUE(text.ok());
  EXPECT_EQ(*text, "G1 X1.\n");
}

}  // namespace
}  // namespace axiscal::nc
