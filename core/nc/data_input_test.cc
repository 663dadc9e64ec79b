// Work offsets that the program states: G10 L2 and L20, CYCL DEF 247.
#include "core/nc/testing/rewritten.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using testing::kAtZero;
using testing::Outcome;
using testing::Rewritten;

RewriteOptions In(const std::string& dialect) {
  RewriteOptions options = kAtZero;
  options.dialect = dialect;
  options.work_offsets = {{"G54", {{"X", 100.0}}}, {"G55", {}}};
  return options;
}

// The head leans with B: at B = 90 deg the correction is in Z alone, at 0 in X alone. A value of B that an offset gets
// shows at once.
TEST(DataInput, ValuesOfAWorkOffsetAreFollowed) {
  const std::string head = "G90 G54\nG1 X1. B0. F100\n";
  for (const char* dialect : {"fanuc", "mazak", "haas", "linuxcnc"}) {
    const Outcome outcome =
        Rewritten(head + "G10 L2 P1 B90.\nX2. B0.\nG10 L2 P2 X5. B0.\nX3.\nG55\nX4. B0.\n", In(dialect));
    ASSERT_TRUE(outcome.status.ok()) << outcome.status;
    EXPECT_THAT(outcome.text, HasSubstr("G10 L2 P1 B90.\nX2. B0. Z-0.0417\nG10 L2 P2 X5. B0.\n")) << dialect;
    EXPECT_THAT(outcome.text, HasSubstr("G55\nX4.0417 B0. Z0.0000\n")) << dialect;
  }
}

TEST(DataInput, AdditionalOffsetsAreThoseOfTheControl) {
  const std::string all = " X0. Y0. Z0. B90. C0.\n", behind = "X2. B0.\n";
  const std::string head = "G1 X1. F100\n";
  RewriteOptions options = kAtZero;
  for (const auto& [dialect, input, select] :
       std::vector<std::array<std::string, 3>>{{"fanuc", "G10 L20 P12", "G54.1 P12"},
                                               {"mazak", "G10 L20 P3", "G54.1 P3"},
                                               {"haas", "G10 L20 P3", "G154 P3"},
                                               {"haas", "G10 L20 P3", "G112"},
                                               {"haas", "G90 G10 L20 P99", "G154 P99"},
                                               {"linuxcnc", "G10 L2 P7", "G59.1"},
                                               {"fanuc", "G90 G10 L2 P6", "G59"}}) {
    options.dialect = dialect;
    const Outcome outcome = Rewritten(head + input + all + select + "\n" + behind, options);
    ASSERT_TRUE(outcome.status.ok()) << input << outcome.status;
    EXPECT_THAT(outcome.text, HasSubstr(input + all + select + "\nX2. B0. Z-0.0417\n")) << dialect;
  }
  // The first offset is in force when nothing selects one.
  options.dialect = "fanuc";
  EXPECT_THAT(Rewritten(head + "G10 L2 P1" + all + behind, options).text, HasSubstr(all + "X2. B0. Z-0.0417\n"));
}

TEST(DataInput, WhatIsNotFollowedIsRefusedWithWhatHelps) {
  const std::vector<std::array<std::string, 3>> blocks = {
      {"fanuc", "G10 L2 P0 X5.\n", "followed is L2 with P1 to P6 and L20 with P1 to P300"},
      {"fanuc", "G10 L10 P1 R5.\n", "with the word R5"},
      {"fanuc", "G10 L2 P3 X5.\n", "--offset \"G56 X=... \""},
      {"fanuc", "G91 G10 L2 P1 X5.\n", "program it in G90"},
      {"fanuc", "/G10 L2 P1 X5.\n", "state --block-delete"},
      {"fanuc", "G52 X1.\nG10 L2 P1 X5.\n", "G92, G52"},
      {"fanuc", "G10 L2 P1 X#1\n", "macro or expression"},
      {"fanuc", "G10 L2 P1 X5. U5.\n", "names no axis"},
      {"fanuc", "G10 L2 P2\n", "names no axis"},
      {"haas", "G10 L20 P100 X5.\n", "L20 with P1 to P99"},
      {"linuxcnc", "G10 L20 P1 X0\n", "state the values by L2"},
      {"linuxcnc", "G10 L2 P1 X0 R15\n", "with the word R15"},
      {"linuxcnc", "G10 L2 P10 X0\n", "followed is L2 with P1 to P9"},
  };
  for (const auto& [dialect, block, reason] : blocks)
    EXPECT_REFUSED(In(dialect), "G90 G54\nG1 X1. F100\n" + block + "X2.\n", reason);
  RewriteOptions no_unit = In("fanuc");
  no_unit.unit = ProgramUnit::kUnstated;
  EXPECT_REFUSED(no_unit, "G90 G54\nG10 L2 P1 X5.\n", "the unit is not known");
}

TEST(DataInput, Cycle247SelectsTheDatumThatIsStated) {
  RewriteOptions options = kAtZero;
  options.dialect = "heidenhain";
  options.work_offsets = {{"PRESET 2", {{"B", 90.0 * base::kRadPerDeg}}}};
  const std::string head = "0 BEGIN PGM A MM\n1 L X+1 F100\n";
  for (const std::string cycle :
       {"2 CYCL DEF 247 DATUM SETTING ~\n Q339=+2 ;DATUM NUMBER\n", "2 CYCL DEF 247 DATUM SETTING Q339=2\n",
        "2 CYCL DEF 247 SETTING ~\n   ; TEXT ~\n Q339 = +2\n"}) {
    const Outcome outcome = Rewritten(head + cycle + "3 L X+2 B+0\n", options);
    ASSERT_TRUE(outcome.status.ok()) << outcome.status;
    EXPECT_THAT(outcome.text, HasSubstr(cycle + "3 L X+2 B+0 Z-0.0417\n"));
  }
  for (const auto& [cycle, reason] : std::vector<std::pair<std::string, std::string>>{
           {"2 CYCL DEF 247 DATUM SETTING ~\n Q339=+3\n", "PRESET 3 is not stated: state it with --offset \"PRESET 3"},
           {"2 CYCL DEF 247 DATUM SETTING ~\n Q339=Q5\n", "Q339 is no plain number"},
           {"2 CYCL DEF 247 DATUM SETTING ~\n Q338=+2\n", "its lines state no number by Q339"},
           {"2 CYCL DEF 247 DATUM SETTING\n", "its lines state no number by Q339"},
           {"/2 CYCL DEF 247 DATUM SETTING ~\n Q339=+2\n", "in a block that may be skipped"},
           {"2 CC X+1 Y+1\n3 CYCL DEF 247 SET ~\n Q339=+2\n4 C X+1 Y+2 DR+\n", "CC"}})
    EXPECT_REFUSED(options, head + cycle + "5 L X+2 B+0\n", reason);
  // Its lines end without the number.
  EXPECT_REFUSED(options, head + "2 CYCL DEF 247 SET ~\n3 L X+2\n", "a work offset is active");
  // With blocks that are passed nothing may stand between its lines.
  options.on_unsupported = OnUnsupported::kPass;
  const Outcome passed = Rewritten(head + "2 CYCL DEF 247 SETTING ~\n Q339=+3\n3 L X+2\n", options);
  ASSERT_TRUE(passed.status.ok()) << passed.status;
  EXPECT_THAT(passed.text, HasSubstr("F100\nL X+1.0000\n2 CYCL DEF 247 SETTING ~\n Q339=+3\n3 L X+2\n"));
}

TEST(DataInput, VerifyFollowsTheSameOffsets) {
  const std::string program = "G90 G54\nG1 X1. Y0. Z0. B0. C0. F100\nG10 L2 P2 X5. B45.\nG55\nX2. B0.\nZ5.\n";
  const Outcome outcome = Rewritten(program, In("fanuc"));
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  const compensate::Compensator compensator = testing::LeaningHead();
  VerifyOptions verify;
  verify.tool_tip_mm = {0, 0, -testing::kToolMm};
  verify.reading = In("fanuc");
  const auto report = VerifyText(program, outcome.text, compensator.machine(), compensator.carried(), verify);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->moves, 3);
  EXPECT_GT(report->end_before.max_mm, 0.04);
  EXPECT_LT(report->end_after.max_mm, 1.5e-4);
}

}  // namespace
}  // namespace axiscal::nc
