// Blocks that start something else: macros and changers behind M codes, cycles that act where they are defined.
#include "core/nc/testing/rewritten.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using testing::kAtZero;
using testing::LeaningHead;

RewriteOptions In(const std::string& dialect) {
  RewriteOptions options = kAtZero;
  options.dialect = dialect;
  return options;
}

TEST(Trigger, MCodesThatNoManualListsAreAskedFor) {
  for (const char* dialect : {"fanuc", "mazak", "haas", "linuxcnc", "sinumerik", "heidenhain"}) {
    const std::string move = std::string(dialect) == "heidenhain" ? "L X+1.5 R0 M247\n" : "G1 X1.5 M247\n";
    EXPECT_REFUSED(In(dialect), move,
                   "M247: it may start a macro or move axes, if it does neither, state --harmless-m 247");
    RewriteOptions stated = In(dialect);
    stated.harmless_m = {247};
    EXPECT_TRUE(testing::Rewritten(move, stated).status.ok()) << dialect;
  }
  // User-defined in LinuxCNC, of its kinematics in others' eyes: unknown there.
  EXPECT_REFUSED(In("linuxcnc"), "M100 P1\n", "--harmless-m 100");
  for (const char* dialect : {"fanuc", "haas", "sinumerik", "heidenhain"})
    EXPECT_REFUSED(In(dialect), "M428\n", "--harmless-m 428");
  EXPECT_REFUSED(In("linuxcnc"), "M428\n", "switches the kinematics");
  EXPECT_REFUSED(In("fanuc"), "M19.1\n", "M19.1: it may start a macro or move axes");
}

TEST(Trigger, WhatAnUnknownMCodeLeavesIsNotKnown) {
  RewriteOptions passing = kAtZero;
  passing.on_unsupported = OnUnsupported::kPass;
  const std::string behind = "G90 G21 G94 G17 G49 G1 X2. Y0. Z0. B0. C0.\n";
  EXPECT_REWRITTEN(passing, "G1 X1.\nM247\n" + behind, "G1 X1.0417\nG01 X1.0000\nM247\n" + behind);
  passing.harmless_m = {247};
  EXPECT_REWRITTEN(passing, "G1 X1.\nM247\nG1 X2.\n", "G1 X1.0417\nM247\nG1 X2.0417\n");
}

TEST(Trigger, OnlyCodesOfTheBuilderMayBeStated) {
  RewriteOptions options = kAtZero;
  for (const int known : {98, 6, 60, 30}) {
    options.harmless_m = {known};
    const absl::Status status = Validate(options);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(status.message()), HasSubstr(absl::StrCat("harmless_m: M", known, " is known")));
  }
  options.harmless_m = {-1};
  EXPECT_FALSE(Validate(options).ok());
  options.harmless_m = {10000};
  EXPECT_FALSE(Validate(options).ok());
  options.harmless_m = {8, 47, 9999};
  EXPECT_TRUE(Validate(options).ok());
}

// The changer leaves the axes where it likes: the next block must not get words of axes that it does not name.
TEST(Trigger, BehindAPalletChangeNothingIsKnown) {
  for (const auto& [dialect, code] : {std::pair("fanuc", "M60"), std::pair("mazak", "M60"), std::pair("haas", "M50"),
                                      std::pair("haas", "M16"), std::pair("linuxcnc", "M60")}) {
    const std::string program = absl::StrCat("G1 X1.\n", code, "\nG0 Z5.\nG0 X2. Y0. B0. C0.\n");
    EXPECT_REWRITTEN(In(dialect), program, absl::StrCat("G1 X1.0417\n", code, "\nG0 Z5.\nG0 X2.0417 Y0. B0. C0.\n"));
    EXPECT_REFUSED(In(dialect), absl::StrCat("G0 X1. ", code, "\n"), "words of axes in one block");
  }
}

TEST(Trigger, CyclesThatActWhereTheyAreDefined) {
  const std::string begin = "L X+1 R0 FMAX\nCYCL DEF 200 DRILLING ~\nQ200=+2 ~\nQ201=-20\n";
  // 221 drills its pattern at once.
  EXPECT_REFUSED(In("heidenhain"), begin + "CYCL DEF 221 CARTESIAN PATTERN ~\nQ225=+15\nL Z+50 R0 FMAX\n",
                 "CYCL DEF 221 (runs the last cycle at the points of a pattern, which no word states: call it at each");
  EXPECT_REFUSED(In("heidenhain"), "CYCL DEF 359 OF THE BUILDER\n", "may act where it is defined");
  EXPECT_REFUSED(In("heidenhain"), "TCH PROBE 410 DATUM INSIDE RECTAN.\n", "it may set the datum");
  EXPECT_REFUSED(In("heidenhain"), "FUNCTION COUNT REPEAT LBL 3\n", "jumps back");
  EXPECT_REFUSED(In("heidenhain"), "L X+1 R0 M89\n", "calls a cycle behind each move");
  EXPECT_REFUSED(In("heidenhain"), "L X+1 R0 M118 X2\n", "M118");
  EXPECT_TRUE(testing::Rewritten(begin + "L X+2 R0 FMAX\n", In("heidenhain")).status.ok());
  RewriteOptions passing = In("heidenhain");
  passing.on_unsupported = OnUnsupported::kPass;
  // Behind it a block without X and Y does not get them.
  EXPECT_REWRITTEN(passing, begin + "CYCL DEF 221 CARTESIAN PATTERN\nL Z+50 R0 FMAX\nL X+2 Y+0 B+0 C+0 R0 FMAX\n",
                   "L X+1.0417 R0 FMAX\nCYCL DEF 200 DRILLING ~\nQ200=+2 ~\nQ201=-20\nL X+1.0000 FMAX\nCYCL DEF 221 "
                   "CARTESIAN PATTERN\nL "
                   "Z+50 R0 FMAX\nL X+2.0417 Y+0 B+0 C+0 R0 FMAX\n");
}

}  // namespace
}  // namespace axiscal::nc
