// Rotary axes that the tool changer leaves where they stand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/nc/testing/rewritten.h"

namespace axiscal::nc {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::kAtZero;
using ::testing::Not;
using testing::Rewritten;

RewriteOptions Keeping(const std::vector<std::string>& axes) {
  RewriteOptions options = kAtZero;
  options.tool_change_keeps = axes;
  return options;
}

// A three-axis program of a shop: nothing names B and C.
constexpr char kTwoTools[] = "G1 X1.\nT2 M6\nG0 X2. Y1.\nZ1.\nG1 X3.\n";

TEST(ToolChange, StatedAxesStandWhereTheyStoodAndAllOthersAreUnknown) {
  EXPECT_REFUSED(kAtZero, kTwoTools, "the position of B is unknown: not programmed since line 2");
  EXPECT_REWRITTEN(Keeping({"B", "C"}), kTwoTools, "G1 X1.0417\nT2 M6\nG0 X2. Y1.\nZ1. X2.0417\nG1 X3.0417\n");
  EXPECT_REFUSED(Keeping({"C"}), kTwoTools, "the position of B is unknown: not programmed since line 2");
  // What the program said of them last, and not where they began.
  const std::string turned = "G0 B90. C10.\nT2 M6\nG0 X2. Y1. Z1.";
  const testing::Outcome kept = Rewritten(turned + "\nG1 Z2.\n", Keeping({"B", "C"}));
  const testing::Outcome named = Rewritten(turned + " B90. C10.\nG1 Z2.\n", kAtZero);
  ASSERT_TRUE(kept.status.ok() && named.status.ok()) << kept.status << named.status;
  EXPECT_EQ(kept.text.substr(kept.text.find("G1 Z")), named.text.substr(named.text.find("G1 Z")));
  EXPECT_THAT(kept.text, Not(HasSubstr("G1 Z2.\n")));
  const testing::Outcome noted = Rewritten(kTwoTools, Keeping({"B", "C"}));
  EXPECT_THAT(TextsOf(noted.report.notes),
              Contains("line 2: tool changes are taken to leave B, C where they stand, as stated"));
}

TEST(ToolChange, TheRefusalSaysWhatToState) {
  const testing::Outcome asked = Rewritten(kTwoTools, kAtZero);
  EXPECT_THAT(asked.report.missing,
              Contains("--tool-change-keeps \"B C\" (only if the tool changer leaves them where they stand)"));
  RewriteOptions unknown = testing::InMm();
  const testing::Outcome both = Rewritten("T2 M6\nG0 X2. Y1. Z1.\nG1 X3.\n", unknown);
  EXPECT_THAT(both.report.missing,
              ElementsAre("--start \"B=... C=...\"",
                          "--tool-change-keeps \"B C\" (only if the tool changer leaves them where they stand)"));
}

TEST(ToolChange, NothingIsKeptWhereItIsNotSure) {
  const RewriteOptions options = Keeping({"B", "C"});
  const std::string rest = "G0 X2. Y1. Z1.\nG1 X3.\n";
  // Pallets, machine positions of all axes, a change that may be skipped with a rotary word in front of it.
  EXPECT_REFUSED(options, "G1 X1.\nM60\n" + rest, "the position of B is unknown");
  EXPECT_REFUSED(options, "G1 X1.\nT2 M6 M60\n" + rest, "the position of B is unknown");
  EXPECT_REFUSED(options, "G1 X1.\nG28\nT2 M6\n" + rest, "the position of B is unknown");
  EXPECT_REFUSED(options, "G1 X1.\n/T2 M6\n" + rest, "the position of B is unknown");
  RewriteOptions executed = options;
  executed.block_delete = BlockDelete::kExecuted;
  EXPECT_TRUE(Rewritten("G1 X1.\n/T2 M6\n" + rest, executed).status.ok());
}

TEST(ToolChange, KlartextCallsItsTools) {
  RewriteOptions options = Keeping({"B", "C"});
  options.dialect = "heidenhain";
  options.tool_lengths = {{1, 100.0}, {2, 50.0}};
  const std::string program =
      "TOOL CALL 1 Z S100\nL X+1 Y+1 Z+1 R0 FMAX\nTOOL CALL 2 Z S100\nL X+2 Y+1 Z+1 R0 FMAX\nL X+3 F100\n";
  const testing::Outcome done = Rewritten(program, options);
  EXPECT_TRUE(done.status.ok()) << done.status;
  ASSERT_EQ(done.report.shifts.size(), 2u);
  EXPECT_EQ(done.report.shifts[0].tool, 1);
  EXPECT_EQ(done.report.shifts[1].tool, 2);
  options.tool_change_keeps.clear();
  EXPECT_REFUSED(options, program, "the position of B is unknown");
}

// A program that calls none has the tool of the one in front of it, or not: the length that corrections are made for is
// not known.
TEST(ToolChange, ACalledToolStaysBehindItsProgram) {
  RewriteOptions options = Keeping({"B", "C"});
  options.dialect = "heidenhain";
  options.tool_lengths = {{1, 100.0}};
  const std::string first = "BEGIN PGM A MM\nTOOL CALL 1 Z S100\nL X+1 Y+1 Z+1 R0 FMAX\n";
  const std::string second = "BEGIN PGM B MM\nL X+2 Y+1 Z+1 B+0 C+0 R0 F100\n";
  for (const char* const end : {"", "END PGM A MM\n"}) {
    EXPECT_REFUSED(options, first + end + second, "a tool length is active that is not stated");
    const std::string called = "BEGIN PGM B MM\nTOOL CALL 1 Z S100\nL X+2 Y+1 Z+1 B+0 C+0 R0 F100\n";
    EXPECT_TRUE(Rewritten(first + end + called, options).status.ok());
  }
  EXPECT_TRUE(Rewritten("BEGIN PGM A MM\nL X+1 Y+1 Z+1 R0 FMAX\nEND PGM A MM\n" + second, options).status.ok());
}

// With --orientation a rotary axis stands at its corrected command, in front of the tool change and behind it.
TEST(ToolChange, CorrectedRotaryAxesStayWhereTheyAre) {
  RewriteOptions options = Keeping({"B", "C"});
  options.orientation = true;
  const std::string program = "G1 X1. Y0 Z0 B30. C10. F100\nT2 M6\nG0 X2. Y1. Z1.\nG1 X3.\n";
  const testing::Outcome done = Rewritten(program, options);
  ASSERT_TRUE(done.status.ok()) << done.status;
  EXPECT_THAT(done.text.substr(done.text.find("M6")), Not(HasSubstr("B")));
  EXPECT_LT(done.report.error_after.max_mm, 1e-4);
}

TEST(ToolChange, OnlyRotaryAxesOfTheMachineCanBeStated) {
  for (const char* const name : {"X", "A", ""}) {
    RewriteReport report;
    const auto text = RewriteText(kTwoTools, testing::LeaningHead(), Keeping({name}), &report);
    EXPECT_EQ(text.status().code(), absl::StatusCode::kInvalidArgument) << name;
    EXPECT_THAT(std::string(text.status().message()), HasSubstr("must be a rotary axis of machine"));
  }
}

}  // namespace
}  // namespace axiscal::nc
