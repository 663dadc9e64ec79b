#include "client/cli/loop_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace axiscal::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

reports::Loop ReportOf(const reports::Effect& effect) {
  reports::Loop report;
  report.verdict = reports::Verdict::kExtended;
  report.effects = {effect};
  report.fit.before = {.rms_um = 3.033, .rms_without_outliers_um = 1.2};
  report.fit.after = {.rms_um = 2.641, .rms_without_outliers_um = 0.31};
  return report;
}

reports::Effect Effect(const std::string& name, const std::string& shape, const std::string& unit) {
  reports::Effect effect;
  effect.is.name = name;
  effect.is.term.shape = shape;
  effect.amplitude = -2.92;
  effect.amplitude_sigma = 0.02;
  effect.unit = unit;
  effect.rms_um = 0.9;
  return effect;
}

reports::Check Fitted(const reports::Loop& report, bool fitted) {
  return {.before = report.fit.before, .after = report.fit.after, .fitted = fitted};
}

TEST(LoopText, AmplitudesSayWhatTheyAreTheAmplitudeOf) {
  EXPECT_THAT(LoopText(ReportOf(Effect("EXX:backlash", "backlash", "um"))),
              HasSubstr("-2.92 +- 0.02 um peak to peak, 0.9 um rms in the readings\n"));
  EXPECT_THAT(LoopText(ReportOf(Effect("EYX:quadratic", "quadratic", "um"))),
              HasSubstr(" um at 250 mm or 1 rad from zero,"));
  reports::Effect warming = Effect("EZT:drift-exp", "drift-exp", "um");
  warming.is.term.tau_s = 1216.3;
  EXPECT_THAT(LoopText(ReportOf(warming)), HasSubstr(" um when warm (time constant 1216 s),"));
  reports::Effect spike = Effect("EYY:reversal", "reversal", "um");
  spike.is.term.length_mm = 5.5;
  EXPECT_THAT(LoopText(ReportOf(spike)), HasSubstr(" um at the reversal, decaying over 5.5 mm,"));
  EXPECT_THAT(LoopText(ReportOf(Effect("EB0B", "constant", "urad"))), HasSubstr("+- 0.02 urad, 0.9 um rms"));
}

TEST(LoopText, AnotherTimeConstantIsNotTheSame) {
  reports::Effect late = Effect("EXX:thermal-lag(X,temp_C)", "thermal-lag", "um/(K m)");
  late.is.term.tau_s = 0.0;
  late.equivalent.push_back(late.is);
  late.equivalent[0].term.tau_s = 66.5;
  EXPECT_THAT(LoopText(ReportOf(late)),
              HasSubstr("cannot tell it from EXX:thermal-lag(X,temp_C) of time constant 66.5 s (here 0 s)\n"));
}

// Only of a session whose references could tell.
TEST(LoopText, ATrackerMayHaveBeenKnocked) {
  reports::Loop report = ReportOf(Effect("EB0B", "constant", "urad"));
  reports::Unexplained part;
  part.kind = reports::PartKind::kSlip;
  part.variable = "t";
  part.session = "tracker";
  part.from = 310.0;
  part.to = 320.0;
  part.slip = reports::Slip{};
  report.unexplained = {part};
  report.fitted.sessions.resize(1);
  report.fitted.sessions[0].in.session = "tracker";
  EXPECT_THAT(LoopText(report), Not(HasSubstr("knocked")));
  report.fitted.sessions[0].setup = {{"frame_x", {}}, {"reference_r1_x", {}}};
  EXPECT_THAT(LoopText(report), HasSubstr("\"# knocked_s: 315\""));
}

TEST(LoopText, SaysWhatIsNoErrorOfTheMachine) {
  reports::Loop report;
  EXPECT_THAT(LoopText(report), Not(HasSubstr("no errors of the machine")));
  report.causes = {{reports::CauseKind::kInstrument, "rtest: the gain of its channels; sessions R1, R2", 812.4,
                    "calibrate the instrument; it reads too much: x by x +2.1 +- 0.1 %"}};
  EXPECT_THAT(LoopText(report),
              HasSubstr("verdict: the declared model is adequate: what the readings show beside it is no error of the "
                        "machine\nno errors of the machine, and never compensated:\n"
                        "  the instrument: rtest: the gain of its channels; sessions R1, R2 (chi-square 812)\n"
                        "      calibrate the instrument; it reads too much: x by x +2.1 +- 0.1 %\n"));
}

TEST(LoopText, SaysWhatIsNotCorrected) {
  reports::Loop report = ReportOf(Effect("EB0B", "constant", "urad"));
  EXPECT_THAT(LoopText(report), Not(HasSubstr("not corrected")));
  report.held_back = {{reports::HeldBackKind::kUndecided, "EAC:harmonic(1)", 40.0, 0.31, "measure an R-test at 150 mm"},
                      {reports::HeldBackKind::kUncertain, "EXX:linear", 20.0, 0.08, "measure more of X"},
                      {reports::HeldBackKind::kNoGain, "EYX:curve", 30.0, 0.01, "measure all of X"},
                      {reports::HeldBackKind::kHidden, "EBC:harmonic(1)", 90.0, 0.02, "measure more of C"}};
  EXPECT_THAT(LoopText(report),
              HasSubstr("found and not corrected, as the machine could be worse for it over the measured box, or "
                        "no gain is certain:\n"
                        "  EAC:harmonic(1): these sessions do not tell what it is (worse with probability 0.31)\n"
                        "      measure an R-test at 150 mm\n"
                        "  EXX:linear: these sessions hardly tell how large it is (worse with probability 0.08)\n"
                        "      measure more of X\n"
                        "  EYX:curve: no gain over the box is certain\n"
                        "      measure all of X\n"
                        "  EBC:harmonic(1): over the box it does many times of all that the readings show\n"
                        "      measure more of C\n"));
}

TEST(LoopText, SaysThatNominalDataAreWrong) {
  reports::Loop report;
  report.verdict = reports::Verdict::kUnexplained;
  report.causes = {{reports::CauseKind::kNominal, "machine.json: axis C turns the other way", 5e4, "axis C: ..."}};
  EXPECT_THAT(LoopText(report), HasSubstr("verdict: nominal data are wrong: no errors were looked for\n"));
  EXPECT_THAT(LoopText(report),
              HasSubstr("  nominal data: machine.json: axis C turns the other way (chi-square 50000)\n"));
  EXPECT_THAT(LoopText(report), HasSubstr("over the measured box: not known before the nominal data are right\n"));
}

TEST(LoopText, BadReadingsDoNotHideWhatTheModelGained) {
  reports::Loop report = ReportOf(Effect("EB0B", "constant", "urad"));
  EXPECT_THAT(LoopText(report), Not(HasSubstr("set aside")));
  report.fitted.outliers = {{.session = "CR", .row = 118}};
  EXPECT_THAT(LoopText(report), HasSubstr("fit sessions                   3.033   2.641\n"
                                          "  without readings set aside   1.200  0.3100\n"));
}

TEST(LoopText, CheckSessionsThatWereFittedProveNothing) {
  reports::Loop report = ReportOf(Effect("EB0B", "constant", "urad"));
  report.check = Fitted(report, false);
  EXPECT_THAT(LoopText(report), Not(HasSubstr("prove nothing")));
  report.check = Fitted(report, true);
  EXPECT_THAT(LoopText(report), HasSubstr("all sessions were fitted together, and the check sessions prove nothing\n"));
  EXPECT_THAT(LoopText(report), HasSubstr("\nall sessions "));
}

TEST(LoopText, WhatTheSessionsDoNotTellIsNamed) {
  reports::Loop report = ReportOf(Effect("EB0B", "constant", "urad"));
  report.fitted.errors = {{.symbol = "EX0C", .name = "EX0C", .value = 3.1, .identifiable = true},
                          {.symbol = "EZ0T", .name = "EZ0T", .identifiable = false}};
  report.not_visible = {{.term = {}, .name = "EXZ:linear"}};
  EXPECT_THAT(LoopText(report), HasSubstr("errors without a number, which the fit sessions do not tell: EZ0T\n"));
  EXPECT_THAT(LoopText(report), HasSubstr("\nthe fit sessions could not see"));
  report.check = Fitted(report, true);
  EXPECT_THAT(LoopText(report), HasSubstr("errors without a number, which these sessions do not tell: EZ0T\n"));
  EXPECT_THAT(LoopText(report), HasSubstr("\nthese sessions could not see"));
}

TEST(LoopText, TheBoxIsSaidAndNoGainThatIsNotHeld) {
  reports::Loop report = ReportOf(Effect("EB0B", "constant", "urad"));
  EXPECT_THAT(LoopText(report), Not(HasSubstr("measured box")));
  report.volumetric = {.box = {{"X", -200.0, 200.0, "mm"}, {"C", 0.0, 360.0, "deg"}},
                       .poses = 400,
                       .uncorrected = {31.4, 30.0, 33.0},
                       .before = {5.2, 5.0, 5.4},
                       .after = {0.31, 0.2, 0.5},
                       .gain_is_held = true,
                       .weakest = {"EY0C", "EA0C"},
                       .undecided = {"EB0B"},
                       .unknown = {"EX0C"}};
  EXPECT_THAT(
      LoopText(report),
      HasSubstr(
          "tool point over the measured box (X -200 to 200 mm, C 0 to 360 deg), less work offset and tool, "
          "[95 % interval]:\n  machine as it is 31.4 um rms [30, 33]\n  corrected for the declared errors "
          "5.2 um rms [5, 5.4], for what was found too 0.31 um rms [0.2, 0.5]\n  most of what is left: how well "
          "EY0C, EA0C is known\n  most of what is left: whether it is EB0B or what these sessions cannot tell from "
          "it\n  without what nobody knows "
          "there: EX0C\n"));
  report.volumetric->gain_is_held = false;
  EXPECT_THAT(LoopText(report),
              HasSubstr("\n  corrected 0.31 um rms [0.2, 0.5]: no gain over the declared errors alone "
                        "is promised\n"));
}

TEST(LoopText, ASessionThatScattersIsNoSlip) {
  reports::Loop report;
  report.unexplained = {
      {.kind = reports::PartKind::kScatter, .variable = "t", .from = 0, .to = 9, .session = "CR", .rms_um = 20.02}};
  EXPECT_EQ(UnexplainedText(report),
            "unexplained:\n  session CR: its readings scatter by 20 um rms, far more than it states\n");
}

TEST(LoopText, WarnsOfReadingsThatAreRounded) {
  reports::Loop report = ReportOf(Effect("EB0B", "constant", "urad"));
  report.fitted.warnings = {{reports::WarningKind::kResolution, "session 'CR': readings stand in steps"}};
  EXPECT_THAT(LoopText(report), HasSubstr("\nwarning: session 'CR': readings stand in steps\n"));
}

TEST(LoopText, TheLimitCountsPartsWithoutAName) {
  reports::Loop report = ReportOf(Effect("EB0B", "constant", "urad"));
  report.stopped_early = true;
  EXPECT_THAT(LoopText(report), HasSubstr("stopped at the limit of --max-effects with 1 effects: more may be there\n"));
  report.unexplained = {{.kind = reports::PartKind::kSlip, .variable = "t", .session = "CR"},
                        {.kind = reports::PartKind::kCheckSession, .session = "CT"}};
  EXPECT_THAT(LoopText(report), HasSubstr("with 1 effects and 1 parts without a name: more may be there\n"));
}

TEST(LoopText, AProposalForOneEffectSaysWhatItIsToldFrom) {
  reports::Loop report = ReportOf(Effect("EB0B", "constant", "urad"));
  reports::Proposal proposal;
  proposal.effect = "EB0B";
  proposal.separates = {"EB0B"};
  proposal.test = {.test = "later",
                   .text = "session CR again",
                   .correlation_before = 0.9,
                   .correlation_after = 0.5,
                   .expected_chi2 = 40.0};
  report.next_measurement = {proposal};
  EXPECT_THAT(LoopText(report), HasSubstr("tells EB0B from errors that come close to it: correlation 0.900 -> 0.500"));
  report.next_measurement[0].separates = {"EB0B", "EX0T"};
  EXPECT_THAT(LoopText(report), HasSubstr("tells apart EB0B, EX0T: correlation"));
}

}  // namespace
}  // namespace axiscal::cli
