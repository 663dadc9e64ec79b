// The mark of a compensated program: where it stands, that it is refused as input, and when there is none.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/nc/rewrite.h"
#include "core/nc/testing/rewritten.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using testing::kAtZero;
using testing::LeaningHead;
using testing::MarkLine;

TEST(Mark, TheMarkStandsBehindTheProgramNumberAndIsRefusedAsInput) {
  const std::string program = "%\nO77\nG1 X1.\n%\n";
  RewriteReport report;
  const auto text = RewriteText(program, LeaningHead(), kAtZero, &report);
  ASSERT_TRUE(text.ok()) << text.status();
  EXPECT_EQ(*text, "%\nO77\n" + MarkLine(program) + "G1 X1.0417\n%\n");
  const auto twice = RewriteText(*text, LeaningHead(), kAtZero, &report);
  EXPECT_EQ(twice.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(twice.status().message()), HasSubstr("line 3"));
  // Rewritten by hand or by an editor, it is still ours.
  EXPECT_FALSE(RewriteText("G1 X1.\n; axiscal compensated by me\n", LeaningHead(), kAtZero, &report).ok());
}

// Whoever loads the program at the control reads no report.
TEST(Mark, TheHeadSaysOfWhatTheCalibrationWarns) {
  RewriteOptions options = kAtZero;
  options.machine = "mt";
  RewriteReport report;
  const auto quiet = RewriteText("G1 X1.\n", LeaningHead(), options, &report);
  ASSERT_TRUE(quiet.ok()) << quiet.status();
  EXPECT_EQ(quiet->find("WARNS"), std::string::npos) << *quiet;
  options.calibration_warns = {"size", "no-number", "bad)\n"};
  const auto text = RewriteText("G1 X1.\n", LeaningHead(), options, &report);
  ASSERT_TRUE(text.ok()) << text.status();
  EXPECT_THAT(*text,
              HasSubstr(")\n(AXISCAL MACHINE mt)\n(AXISCAL ITS CALIBRATION WARNS OF size no-number bad__ - READ ITS "
                        "REPORT)\n(AXISCAL TOOL POINT"));
}

TEST(Mark, AProgramOfWhichNoWordChangesCarriesNoMark) {
  RewriteOptions pass = kAtZero;
  pass.on_unsupported = OnUnsupported::kPass;
  // Nothing can be corrected; nothing moves; every correction is less than a word says (X at B90 gets 0).
  RewriteOptions coarse = kAtZero;
  coarse.decimals_mm = 1;
  const std::string tool_control = "%\r\nO1\r\nG43.4 H1\r\nG1 X1. B5.\r\nX2.\r\n%\r\n";
  const std::pair<std::string, RewriteOptions> cases[] = {
      {tool_control, pass}, {"M3 S200\nM30\n", kAtZero}, {"", kAtZero}, {"G1 X1.5 Y2.5\nX3.5\n", coarse}};
  for (const auto& [program, options] : cases) {
    RewriteReport report;
    const auto text = RewriteText(program, LeaningHead(), options, &report);
    ASSERT_TRUE(text.ok()) << text.status();
    EXPECT_EQ(*text, program);
    EXPECT_THAT(TextsOf(report.notes), ::testing::Contains(HasSubstr("no word changed")));
  }
}

TEST(Mark, TheMarkComesLaterWhereMuchStandsInFrontOfTheFirstChangedWord) {
  std::string head = "%\nO1\nG21\n";
  while (head.size() < 200'000) head += "M8\nG4 P1\nM9\n";
  const std::string program = head + "G1 X1.\nX2.\n";
  RewriteReport report;
  const auto text = RewriteText(program, LeaningHead(), kAtZero, &report);
  ASSERT_TRUE(text.ok()) << text.status();
  EXPECT_EQ(*text, head + MarkLine(program) + "G1 X1.0417\nX2.0417\n");
  EXPECT_EQ(RewriteText(*text, LeaningHead(), kAtZero, &report).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace axiscal::nc
