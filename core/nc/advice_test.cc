// What a refusal says to add, and what a report says of shifts.
#include "core/nc/advice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/nc/mark.h"
#include "core/nc/testing/rewritten.h"

namespace axiscal::nc {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::InMm;
using ::testing::IsEmpty;
using testing::kAtZero;
using testing::LeaningHead;
using testing::Rewritten;

std::vector<std::string> MissingOf(const std::string& program, const std::string& dialect = "fanuc",
                                   RewriteOptions options = kAtZero) {
  options.dialect = dialect;
  const testing::Outcome outcome = Rewritten(program, options);
  EXPECT_EQ(outcome.status.code(), absl::StatusCode::kFailedPrecondition) << program;
  for (const std::string& option : outcome.report.missing)
    EXPECT_THAT(std::string(outcome.status.message()), HasSubstr(option)) << program;
  return outcome.report.missing;
}

TEST(Advice, NamesTheOptionInTheWordsToAdd) {
  EXPECT_THAT(MissingOf("G55\nG1 X1.\n"), ElementsAre("--offset \"G55 X=... Y=... Z=... B=... C=...\""));
  EXPECT_THAT(MissingOf("G54.1 P6\nG1 X1.\n"), ElementsAre("--offset \"G54.1 P6 X=... Y=... Z=... B=... C=...\""));
  EXPECT_THAT(MissingOf("G43 H3 Z5.\n"), ElementsAre("--tool-length H3=..."));
  EXPECT_THAT(MissingOf("1 TOOL CALL 5 Z S2000\n2 L X+1 Y+1 Z+1 R0 F100\n", "heidenhain"),
              ElementsAre("--tool-length H5=..."));
  EXPECT_THAT(MissingOf("G1 X0. Y0. Z0. F100\nG41 D7 X20. Y10.\nX30.\nG40 Y40.\n"),
              ElementsAre("--tool-radius D7=..."));
  EXPECT_THAT(MissingOf("M47\nM123\nG1 X1.\n"),
              ElementsAre("--harmless-m 47,123 (only if they start no macro and move no axis)"));
  RewriteOptions unstated = kAtZero;
  unstated.unit = ProgramUnit::kUnstated;
  EXPECT_THAT(MissingOf("G1 X1.\n", "fanuc", unstated), ElementsAre("--unit mm (or inch)"));
  EXPECT_THAT(MissingOf("G55\nG43 H3 Z5.\nM47\n"),
              ElementsAre("--offset \"G55 X=... Y=... Z=... B=... C=...\"", "--tool-length H3=...",
                          "--harmless-m 47 (only if they start no macro and move no axis)"));
}

TEST(Advice, AxesThatNothingStatesAreAskedForTogether) {
  EXPECT_THAT(MissingOf("G1 X1. Y2. Z3. F100\n", "fanuc", InMm()), ElementsAre("--start \"B=... C=...\""));
  // A rapid waits for the block that names them.
  EXPECT_THAT(Rewritten("G0 X1. Y2. Z3.\nB0. C0.\nG1 X2. F100\n", InMm()).report.missing, IsEmpty());
}

TEST(Advice, NoOptionHelpsWhereNoneDoes) { EXPECT_THAT(MissingOf("G31 Z-5. F100\n"), IsEmpty()); }

// G10 states work offsets that no option does, takes some of them back, and states others.
TEST(Shifts, OffsetsThatTheProgramStatesHaveTheirNames) {
  RewriteOptions options = kAtZero;
  options.work_offsets = {{"G54", {}}};
  const std::string values = " X5. Y0. Z0. B0. C0.\n";
  const testing::Outcome outcome = Rewritten("G90 G21 G17 G94\nG54 G1 X1. F100\nG10 L2 P4" + values +
                                                 "G57\nX2. Y0. Z0. B0. C0.\nG10 L2 P2" + values + "G55\nX3.\n",
                                             options);
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  std::string names;
  for (const reports::Shift& shift : ReportOf(outcome.report).shifts) names += shift.work_offset + " ";
  EXPECT_EQ(names, "G54 G57 G55 ");
}

// The head leans by 100 urad: at B0 the tool point of a longer tool is off by more.
TEST(Shifts, ByToolAndOffsetWithTheLargest) {
  RewriteOptions options = kAtZero;
  options.work_offsets = {{"G54", {}}, {"G55", {{"X", 100.0}}}};
  options.tool_lengths = {{1, 0.0}, {2, 100.0}};
  const testing::Outcome outcome = Rewritten(
      "T1 M6\nG54 G43 H1\nG0 X0. Y0. Z0. B0. C0.\nG1 X1. F100\nB45.\nG55\nX5. B0.\nT2 M6\nG54 G43 H2\n"
      "G0 X0. Y0. Z0. B0. C0.\nG1 X7. F100\n",
      options);
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  const std::vector<Shift>& shifts = outcome.report.shifts;
  ASSERT_EQ(shifts.size(), 3u);
  const reports::Rewrite said = ReportOf(outcome.report);
  ASSERT_EQ(said.shifts.size(), 3u);
  EXPECT_EQ(said.shifts[0].tool + said.shifts[0].work_offset, "T1G54");
  EXPECT_EQ(said.shifts[1].tool + said.shifts[1].work_offset, "T1G55");
  EXPECT_EQ(said.shifts[2].tool + said.shifts[2].work_offset, "T2G54");
  EXPECT_EQ(said.shifts[1].moves, 1);
  EXPECT_EQ(said.shifts[1].line, 7);
  EXPECT_EQ(said.shifts[1].at[2].first, "X");
  EXPECT_EQ(said.shifts[1].at[2].second, 105.0);    // an axis position
  EXPECT_NEAR(said.shifts[0].max_um, 41.66, 0.01);  // testing/yao.h
  EXPECT_GT(said.shifts[2].max_um, 50.0);
  EXPECT_LE(said.shifts[2].rms_um, said.shifts[2].max_um);
}

TEST(Shifts, RotaryAxesThatAreNeverNamedAreSaid) {
  RewriteOptions options = InMm();
  options.initial_position = {{"B", 0.5}, {"C", 0.0}};
  const testing::Outcome outcome = Rewritten("G0 X0. Y0. Z0.\nG1 X1. F100\nC10.\n", options);
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  ASSERT_EQ(outcome.report.rotary_stood.size(), 1u);
  EXPECT_EQ(outcome.report.rotary_stood[0].first, "B");
  EXPECT_NEAR(outcome.report.rotary_stood[0].second, 28.6479, 1e-4);
}

TEST(Head, NamesMachineOffsetsToolsAndWhatMustBeOff) {
  const std::string program = "%\nO1\nG54 G1 X1. Y0. Z0. B0. C0. F100\n%\n";
  RewriteOptions options = kAtZero;
  options.machine = "mill-7";
  options.work_offsets = {{"G54", {{"X", -490.0}, {"C", 1.5707963267948966}}}};
  options.tool_lengths = {{5, 120.5}};
  options.tool_radii = {{4, 0}, {5, 6.25}};
  options.initial_position = {{"Z", 40}, {"B", 0.5235987755982988}};
  options.tool_change_keeps = {"B", "C"};
  RewriteReport report;
  const auto text = RewriteText(program, LeaningHead(), options, &report);
  ASSERT_TRUE(text.ok()) << text.status();
  EXPECT_THAT(*text, HasSubstr("%\nO1\n(AXISCAL COMPENSATED BY unnamed SOURCE CRC32C"));
  EXPECT_THAT(*text, HasSubstr(")\n(AXISCAL MACHINE mill-7)\n(AXISCAL TOOL POINT AT HOME "));
  EXPECT_THAT(*text, HasSubstr("\n(AXISCAL OFFSET G54 X-490 C90 MM DEG)\n(AXISCAL TOOL LENGTH 5 IS 120.5 MM)\n"
                               "(AXISCAL TOOL RADIUS 5 IS 6.25 MM)\n(AXISCAL START Z40 B30 MM DEG)\n"
                               "(AXISCAL TOOL CHANGES LEAVE B C)\n"
                               "(AXISCAL ERROR TABLES AND VOLUMETRIC COMPENSATION OF THE CONTROL MUST BE OFF)\n"
                               "G54 G1 "));
  EXPECT_EQ(MarkedMachine(*text), "mill-7");
  EXPECT_EQ(MarkedMachine(program), "");
  options.dialect = "sinumerik";
  const auto native = RewriteText("G54 G1 X1. Y0. Z0. B0. C0. F100\r\n", LeaningHead(), options, &report);
  ASSERT_TRUE(native.ok()) << native.status();
  EXPECT_THAT(*native, HasSubstr("\r\n;AXISCAL MACHINE mill-7\r\n"));
  EXPECT_EQ(MarkedMachine(*native), "mill-7");
  options.machine = "a)b";
  EXPECT_FALSE(RewriteText(program, LeaningHead(), options, &report).ok());
}

}  // namespace
}  // namespace axiscal::nc
