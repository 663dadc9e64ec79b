// Subprograms: each run is corrected where the control runs it; runs that agree share one text, others are copies.
#include "core/nc/calls.h"

#include "core/nc/testing/rewritten.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::kAtZero;
using testing::Outcome;
using testing::Rewritten;

RewriteOptions In(const std::string& dialect) {
  RewriteOptions options = kAtZero;
  options.dialect = dialect;
  return options;
}

// At B = 0 the correction is 0.0417 in X, at B = 90 deg -0.0417 in Z.
TEST(Calls, RunsThatAgreeAreCorrectedInPlace) {
  EXPECT_REWRITTEN(kAtZero,
                   "%\nO1 (MAIN)\nG90 G21 G1 X1. F100\nM98 P1000\nX3.\nN9 M98 P1000 L2 (AGAIN)\nG0 Z50.\nM30\n"
                   "O1000 (SUB)\nX2.\nY5.\nM99\n\nO2\n%\n",
                   "%\nO1 (MAIN)\nG90 G21 G1 X1.0417 F100\nM98 P1000\nX3.0417\nN9 M98 P1000 L2 (AGAIN)\nG0 Z50.\nM30\n"
                   "O1000 (SUB)\nX2.0417\nY5.\nM99\n\nO2\n%\n");
  // M99 beside a move, calls in calls, a state that the subprogram leaves.
  EXPECT_REWRITTEN(
      kAtZero, "G1 X1. F100\nM98 P10\nX3.\nM30\nO10\nX2.\nM98 P0020\nX9. M99\nO20\nG91\nX1.\nG90\nM99\n",
      "G1 X1.0417 F100\nM98 P10\nX3.0417\nM30\nO10\nX2.0417\nM98 P0020\nX9.0417 M99\nO20\nG91\nX1.\nG90\nM99\n");
  EXPECT_REWRITTEN(kAtZero, "G1 X1. F100\nG65 P10 A1. Z-5.\nM98 P30010\nM30\nO10\nX2.\nM99\n",
                   "G1 X1.0417 F100\nG65 P10 A1. Z-5.\nM98 P30010\nM30\nO10\nX2.0417\nM99\n");
}

TEST(Calls, RunsThatDifferAreCopies) {
  const Outcome outcome = Rewritten(
      "G1 X1. B0. F100\nN10 M98 P1000 (A)\nB90.\nN20 M98 P1000 (B)\nB0.\nM98 P1000\nM30\nO1000\nX2.\nM99\nO1001\nM99\n",
      kAtZero);
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_EQ(outcome.text,
            "G1 X1.0417 B0. F100\nN10 M98 P1000 (A)\nB90. X2.0000 Z-0.0417\nN20 M98 P1002 (B)\nB0. X2.0417 "
            "Z0.0000\nM98 P1000\n"
            "M30\nO1000\nX2.0417\nM99\nO1002\nX2.\nM99\nO1001\nM99\n");
  EXPECT_THAT(TextsOf(outcome.report.notes), ::testing::Contains(HasSubstr("O1002 is a copy")));
}

TEST(Calls, RepeatsThatDifferAreSeveralCalls) {
  const Outcome outcome =
      Rewritten("G1 X1. B0. F100\nN5 M98 P7 L4 (C)\nX9.\nM30\nO7\nG91 B45.\nG90\nM99\n", In("fanuc"));
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_THAT(outcome.text, HasSubstr("N5 M98 P7 L1 (C)\nM98 P8 L1\nM98 P9 L1\nM98 P10 L1\nX8.9583"));
  EXPECT_THAT(outcome.text, HasSubstr("O7\nG91 B45. X-0.0122 Z-0.0295\nG90\nM99\nO8\nG91 B45. X-0.0295 Z-0.0122\n"));
  const Outcome packed = Rewritten("G1 X1. B0. F100\nM98 P30007\nX9.\nM30\nO7\nG91 B45.\nG90\nM99\n", In("fanuc"));
  EXPECT_THAT(packed.text, HasSubstr("M98 P10007\nM98 P10008\nM98 P10009\nX8.9705"));
}

TEST(Calls, EachControlHasItsOwnWay) {
  EXPECT_REWRITTEN(In("haas"), "G1 X1. F100\nM97 P500\nX3.\nM30\nN500 X2.\nM99\n",
                   "G1 X1.0417 F100\nM97 P500\nX3.0417\nM30\nN500 X2.0417\nM99\n");
  EXPECT_REWRITTEN(In("linuxcnc"), "o100 sub\nX2.\no100 endsub\nG1 X1. F100\no100 call [1.5] (GO)\nX3.\nM2\n",
                   "o100 sub\nX2.0417\no100 endsub\nG1 X1.0417 F100\no100 call [1.5] (GO)\nX3.0417\nM2\n");
  const Outcome named = Rewritten(
      "o<drill> sub\nG1 X2. F100\no<drill> endsub\nG0 X1. B0.\no<drill> call\nG0 B90.\nN7 o<Drill> call\nM2\n",
      In("linuxcnc"));
  ASSERT_TRUE(named.status.ok()) << named.status;
  EXPECT_THAT(named.text, HasSubstr("o<drill> endsub\no<drill_2> sub\nG1 X2. F100\no<drill_2> endsub\n"));
  EXPECT_THAT(named.text, HasSubstr("N7 o<drill_2> call\n"));
  EXPECT_REWRITTEN(
      In("heidenhain"),
      "0 BEGIN PGM A MM\n1 L X+1 F100\n2 CALL LBL 5\n3 LBL 9\n4 L X+3\n5 L M30\n6 LBL 5\n7 L X+2\n8 LBL 0\n"
      "9 END PGM A MM\n",
      "0 BEGIN PGM A MM\n1 L X+1.0417 F100\n2 CALL LBL 5\n3 LBL 9\n4 L X+3.0417\n5 L M30\n6 LBL 5\n"
      "7 L X+2.0417\n8 LBL 0\n9 END PGM A MM\n");
  EXPECT_REWRITTEN(
      In("sinumerik"), "%_N_A_MPF\nG1 X1 F100\nBORE P2 ; twice\nX3\nM30\n%_N_BORE_SPF\nPROC BORE\nX2\nX4 M17\n",
      "%_N_A_MPF\nG1 X1.0417 F100\nBORE P2 ; twice\nX3.0417\nM30\n%_N_BORE_SPF\nPROC BORE\nX2.0417\nX4.0417 M17\n");
}

TEST(Calls, RepeatedPartsAreWrittenOutWhereTheyDiffer) {
  const std::string head = "0 BEGIN PGM A MM\n1 L X+1 B+0 F100\n2 LBL 1\n", behind = "5 L M30\n6 END PGM A MM\n";
  EXPECT_REWRITTEN(In("heidenhain"), head + "3 L IY+5\n4 CALL LBL 1 REP 2\n" + behind,
                   "0 BEGIN PGM A MM\n1 L X+1.0417 B+0 F100\n2 LBL 1\n3 L IY+5\n4 CALL LBL 1 REP 2\n" + behind);
  EXPECT_REWRITTEN(In("heidenhain"), head + "3 L IB+45 FMAX\n4 CALL LBL 1 REP 1/1\n" + behind,
                   "0 BEGIN PGM A MM\n1 L X+1.0417 B+0 F100\n2 LBL 1\n3 L IB+45 X+1.0295 Z-0.0295 FMAX\n"
                   "L IB+45 X+1.0000 Z-0.0417 FMAX\n" +
                       behind);
}

TEST(Calls, SubprogramsOfOtherFilesComeBackBesideTheProgram) {
  RewriteOptions options = In("fanuc");
  options.subprograms = {{"O1000.nc", "%\nO1000\nX2.\nM99\n%\n"}, {"O7", "O7\nM99\n"}};
  const Outcome outcome = Rewritten("G1 X1. B0. F100\nM98 P1000\nB90.\nM98 P1000\nM30\n", options);
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  EXPECT_EQ(outcome.text, "G1 X1.0417 B0. F100\nM98 P1000\nB90. X2.0000 Z-0.0417\nM98 P1001\nM30\n");
  ASSERT_EQ(outcome.report.subprograms.size(), 2u);
  EXPECT_EQ(outcome.report.subprograms[0].name, "O1000.nc");
  EXPECT_THAT(outcome.report.subprograms[0].text, HasSubstr("%\nO1000\n(AXISCAL COMPENSATED BY"));
  EXPECT_THAT(outcome.report.subprograms[0].text, HasSubstr(")\nX2.0417\nM99\n%\n"));
  EXPECT_EQ(outcome.report.subprograms[1].name, "O1001.nc");
  EXPECT_THAT(outcome.report.subprograms[1].text, HasSubstr("%\nO1001\n(AXISCAL"));
  EXPECT_THAT(outcome.report.subprograms[1].text, HasSubstr(")\nX2.\nM99\n%\n"));
  // A corrected one is no source.
  options.subprograms = {outcome.report.subprograms[0]};
  const Outcome again = Rewritten("G1 X1. F100\nM98 P1000\n", options);
  EXPECT_THAT(std::string(again.status.message()), HasSubstr("was compensated before"));

  options = In("heidenhain");
  options.subprograms = {{"part.h", "0 BEGIN PGM PART MM\n1 L X+2\n2 END PGM PART MM\n"}};
  const Outcome klartext = Rewritten("0 BEGIN PGM A MM\n1 L X+1 F100\n2 CALL PGM PART.H\n3 L X+3\n", options);
  ASSERT_TRUE(klartext.status.ok()) << klartext.status;
  ASSERT_EQ(klartext.report.subprograms.size(), 1u);
  EXPECT_THAT(klartext.report.subprograms[0].text, HasSubstr("1 L X+2.0417\n"));
  EXPECT_REFUSED(options, "0 BEGIN PGM A INCH\n1 L X+1 F100\n2 CALL PGM PART\n", "in another unit");

  options = In("sinumerik");
  options.subprograms = {{"L100.SPF", "X2\nRET\n"}, {"DRILL.SPF", "PROC DRILL SAVE\nX5\nRET\n"}};
  const Outcome sinumerik = Rewritten("G1 X1 F100\nL100 P2\nX3\nM30\n", options);
  ASSERT_TRUE(sinumerik.status.ok()) << sinumerik.status;
  EXPECT_THAT(sinumerik.report.subprograms[0].text, HasSubstr("X2.0417\nRET\n"));
  EXPECT_REFUSED(options, "G1 X1 F100\nDRILL\nM30\n", "line 2");
}

TEST(Calls, WhatIsNotFollowedIsRefusedWithWhatHelps) {
  const std::string sub = "M30\nO1000\nX2.\nM99\n";
  for (const auto& [blocks, reason] : std::vector<std::pair<std::string, std::string>>{
           {"M98 P2000\n" + sub,
            "M98 (subprogram call): O2000 stands neither behind it in this text nor in a file of "
            "--subprograms"},
           {"M98 P1000\nM30\n%\nO1000\nX2.\nM99\n", "O1000 stands neither"},
           {"M98 P1000 M8\n" + sub, "put the call alone in its block"},
           {"/M98 P1000\n" + sub, "state --block-delete"},
           {"M98 P1000\nM30\nO1000\nX2.\n", "O1000: it does not end with a return"},
           {"M98 P1000\nM30\nO1000\nX2.\nM30\n", "the end of the program in a subprogram"},
           {"M98 P1000\nM30\nO1000\nM98 P1000\nM99\n", "calls nest deeper than 16"},
           {"M98 P1000\nM30\nO1000\nX2.\nM99\nO1000\nM99\n", "O1000: it stands there twice"},
           {"M98 P1000\nM30\nO1000 G91\nX2.\nM99\n", "words stand behind its number"},
           {"M98 P1000\nM30\nO1000\nIF[#1EQ0]GOTO5\nX2.\nN5 M99\n", "macro: condition"},
           {"M98 P1000\nM30\nO1000\nX#1\nM99\n", "macro or expression"}})
    EXPECT_REFUSED(kAtZero, "G1 X1. F100\n" + blocks, reason);
  EXPECT_REFUSED(In("haas"), "G1 X1. F100\nM97 P500\nN500 X2.\nM99\n", "the program runs into it");
  EXPECT_REFUSED(In("haas"), "G1 X1. F100\nM97 P500\nM30\nN500 X2.\nN501 X3.\nM99\nM97 P501\n",
                 "inside another subprogram");
  EXPECT_REFUSED(In("heidenhain"), "0 BEGIN PGM A MM\n1 L X+1\n2 CALL LBL 1\n3 LBL 1\n4 L X+2\n5 LBL 0\n",
                 "the program runs into it");
  EXPECT_REFUSED(In("heidenhain"), "0 BEGIN PGM A MM\n1 L X+1\n2 CALL LBL 7 REP 2\n", "does not stand in front of it");
}

// B-64484EN, "Subprogram call (M98)": what else stands in its block acts in front of it.
TEST(Calls, ModesInFrontOfACallActBeforeIt) {
  RewriteOptions options = In("fanuc");
  options.work_offsets = {{"G54", {{"X", 0.0}}}, {"G55", {{"X", 10.0}}}};
  EXPECT_REWRITTEN(options, "G1 X1. F100\nN5 G90 G55 M98 P1000 (B)\nX3.\nM30\nO1000\nG91 X2.\nG90 G54 X4.\nM99\n",
                   "G1 X1.0417 F100\nN5 G90 G55 M98 P1000 (B)\nX3.0417\nM30\nO1000\nG91 X2.\nG90 G54 X4.0417\nM99\n");
  // Runs that differ: each further call has none of the codes.
  const Outcome several = Rewritten("G1 X1. B0. F100\nG90 M98 P7 L2\nX9.\nM30\nO7\nG91 B45.\nG90\nM99\n", kAtZero);
  ASSERT_TRUE(several.status.ok()) << several.status;
  EXPECT_THAT(several.text, HasSubstr("\nG90 M98 P7 L1\nM98 P8 L1\n"));
  const std::string sub = "M30\nO1000\nX2.\nM99\n";
  for (const char* const block : {"M98 P1000 G90\n", "G90 X5. M98 P1000\n", "G28 M98 P1000\n", "G54.1 M98 P1000\n",
                                  "G4 M98 P1000\n", "G90 G65 P1000\n", "G90 M98 L2\n"})
    EXPECT_REFUSED(options, std::string("G1 X1. F100\n") + block + sub, "put the call alone in its block");
  EXPECT_REFUSED(options, "G1 X1. F100\nG57 M98 P1000\n" + sub, "G57");
}

// LinuxCNC 2.9, "O codes": arguments are #1, #2 of the subprogram, and the caller keeps its own.
TEST(Calls, ArgumentsOfOWordsAreKnown) {
  const RewriteOptions options = In("linuxcnc");
  EXPECT_REWRITTEN(options, "o7 sub\nX#1 Y[#2+1]\no7 endsub\nG1 X1. F100\no7 call [2.5] [2*[3+1]]\nM2\n",
                   "o7 sub\nX2.5417 Y[#2+1]\no7 endsub\nG1 X1.0417 F100\no7 call [2.5] [2*[3+1]]\nM2\n");
  const Outcome twice = Rewritten(
      "#1=4\n#<a>=6\no7 sub\n#1=[#1+1]\n#<a>=9\nX#1\no7 endsub\nG1 X1. F100\no7 call [#1]\no7 call [#<a>]\nX#1\nM2\n",
      options);
  ASSERT_TRUE(twice.status.ok()) << twice.status;
  EXPECT_THAT(twice.text, HasSubstr("X5.0417\no7 endsub\no8 sub\n#1=[#1+1]\n#<a>=9\nX7.0417\no8 endsub\n"));
  EXPECT_THAT(twice.text, HasSubstr("o7 call [#1]\no8 call [#<a>]\nX4.0417\nM2\n"));
  for (const auto& [call, name] : std::vector<std::pair<std::string, std::string>>{
           {"o7 call", "#1"}, {"o7 call [atan[1]/[2]]", "#1"}, {"o7 call [#5]", "#1"}, {"o7 call [1] [2]", "#3"}})
    EXPECT_REFUSED(options, "o7 sub\nX" + name + "\no7 endsub\nG1 X1. F100\n" + call + "\nM2\n",
                   "the value of " + name + " is not known here");
}

// What was corrected holds for one order of blocks: a jump back to a call of it must not be passed.
TEST(Calls, JumpsBackToFollowedCallsAreNotPassed) {
  RewriteOptions options = kAtZero;
  options.on_unsupported = OnUnsupported::kPass;
  const std::string sub = "M30\nO7\nG1 X1. F100\nM99\n";
  EXPECT_REFUSED(options, "G1 X5. F100\nN3 M98 P7\nIF[#1EQ0]GOTO3\n" + sub, "it may lead back to blocks");
  EXPECT_REFUSED(options, "G1 X5. F100\nN3 M98 P7\nX6.\nGOTO 3\n" + sub, "it may lead back to blocks");
}

TEST(Calls, OtherWaysBackAreNotPassedEither) {
  RewriteOptions options = kAtZero;
  options.on_unsupported = OnUnsupported::kPass;
  EXPECT_REFUSED(options, "G1 X5. F100\nN3 M98 P7\nM99 P3\nO7\nG1 X1. F100\nM99\n", "it may lead back to blocks");
  options.dialect = "haas";
  EXPECT_REFUSED(options, "G1 X5. F100\nN3 M98 P7\nX6.\nM97 P3\nM30\nO7\nG1 X1. F100\nM99\n",
                 "it leads back to blocks");
}

TEST(Calls, ANullCorrectionReturnsTheBytes) {
  const std::string program = "G1 X1. F100\nM98 P1000\nM98 P9 (NONE)\nM30\nO1000\nX2.\nM99";
  RewriteReport report;
  const auto text = RewriteText(program, testing::PerfectMachine(), kAtZero, &report);
  ASSERT_TRUE(text.ok()) << text.status();
  EXPECT_EQ(*text, program);
  ASSERT_EQ(report.passed.size(), 1u);
  EXPECT_EQ(report.passed[0].line, 3);
}

TEST(Calls, VerifyRunsBothProgramsInTheirOrder) {
  const std::string program =
      "G1 X1. Y0. Z0. B0. C0. F100\nM98 P7 L3\nB0.\nM98 P7\nX9.\nM30\nO7\nG91 B30. X2.\nG90\nM98 "
      "P8\nM99\nO8\nY3.\nM99\n";
  const Outcome outcome = Rewritten(program, kAtZero);
  ASSERT_TRUE(outcome.status.ok()) << outcome.status;
  const compensate::Compensator compensator = testing::LeaningHead();
  VerifyOptions verify;
  verify.tool_tip_mm = {0, 0, -testing::kToolMm};
  verify.reading = kAtZero;
  const auto report = VerifyText(program, outcome.text, compensator.machine(), compensator.carried(), verify);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->moves, 11);
  EXPECT_EQ(report->blocks_unsupported, 0);
  EXPECT_GT(report->end_before.max_mm, 0.04);
  EXPECT_LT(report->end_after.max_mm, 1.5e-4);
}

}  // namespace
}  // namespace axiscal::nc
