#include "client/cli/loop_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace axiscal::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Json ReportOf(const Json& effect) {
  return {{"verdict", "extended"},
          {"effects", Json::array({effect})},
          {"fit",
           {{"before", {{"rms_um", 3.033}, {"rms_without_outliers_um", 1.2}}},
            {"after", {{"rms_um", 2.641}, {"rms_without_outliers_um", 0.31}}}}}};
}

Json Effect(const std::string& name, const std::string& shape, const std::string& unit) {
  return {{"name", name}, {"shape", shape}, {"amplitude", -2.92}, {"amplitude_sigma", 0.02},
          {"unit", unit}, {"rms_um", 0.9}};
}

TEST(LoopText, AmplitudesSayWhatTheyAreTheAmplitudeOf) {
  EXPECT_THAT(LoopText(ReportOf(Effect("EXX:backlash", "backlash", "um"))),
              HasSubstr("-2.92 +- 0.02 um peak to peak, 0.9 um rms in the readings\n"));
  EXPECT_THAT(LoopText(ReportOf(Effect("EYX:quadratic", "quadratic", "um"))),
              HasSubstr(" um at 250 mm or 1 rad from zero,"));
  Json warming = Effect("EZT:drift-exp", "drift-exp", "um");
  warming["tau_s"] = 1216.3;
  EXPECT_THAT(LoopText(ReportOf(warming)), HasSubstr(" um when warm (time constant 1216 s),"));
  Json spike = Effect("EYY:reversal", "reversal", "um");
  spike["length_mm"] = 5.5;
  EXPECT_THAT(LoopText(ReportOf(spike)), HasSubstr(" um at the reversal, decaying over 5.5 mm,"));
  EXPECT_THAT(LoopText(ReportOf(Effect("EB0B", "constant", "urad"))), HasSubstr("+- 0.02 urad, 0.9 um rms"));
}

TEST(LoopText, BadReadingsDoNotHideWhatTheModelGained) {
  Json report = ReportOf(Effect("EB0B", "constant", "urad"));
  EXPECT_THAT(LoopText(report), Not(HasSubstr("set aside")));
  report["outliers"] = Json::array({{{"session", "CR"}, {"row", 118}}});
  EXPECT_THAT(LoopText(report), HasSubstr("fit sessions                   3.033   2.641\n"
                                          "  without readings set aside   1.200  0.3100\n"));
}

TEST(LoopText, CheckSessionsThatWereFittedProveNothing) {
  Json report = ReportOf(Effect("EB0B", "constant", "urad"));
  report["check"] = report["fit"];
  EXPECT_THAT(LoopText(report), Not(HasSubstr("prove nothing")));
  report["check"]["fitted"] = true;
  EXPECT_THAT(LoopText(report), HasSubstr("all sessions were fitted together, and the check sessions prove nothing\n"));
  EXPECT_THAT(LoopText(report), HasSubstr("\nall sessions "));
}

TEST(LoopText, WhatTheSessionsDoNotTellIsNamed) {
  Json report = ReportOf(Effect("EB0B", "constant", "urad"));
  report["errors"] = Json::parse(R"([{"symbol": "EX0C", "value": 3.1, "identifiable": true},
                                     {"symbol": "EZ0T", "value": null, "identifiable": false}])");
  report["not_visible"] = Json::array({"EXZ:linear"});
  EXPECT_THAT(LoopText(report), HasSubstr("errors without a number, which the fit sessions do not tell: EZ0T\n"));
  EXPECT_THAT(LoopText(report), HasSubstr("\nthe fit sessions could not see"));
  report["check"] = report["fit"];
  report["check"]["fitted"] = true;
  EXPECT_THAT(LoopText(report), HasSubstr("errors without a number, which these sessions do not tell: EZ0T\n"));
  EXPECT_THAT(LoopText(report), HasSubstr("\nthese sessions could not see"));
}

TEST(LoopText, ASessionThatScattersIsNoSlip) {
  EXPECT_EQ(UnexplainedText(Json::parse(R"({"unexplained": [
                {"kind": "scatter", "variable": "t", "from": 0, "to": 9, "session": "CR", "rms_um": 20.02}]})")),
            "unexplained:\n  session CR: its readings scatter by 20 um rms, far more than it states\n");
}

TEST(LoopText, WarnsOfReadingsThatAreRounded) {
  Json report = ReportOf(Effect("EB0B", "constant", "urad"));
  report["warnings"] = Json::parse(R"([{"kind": "resolution", "text": "session 'CR': readings stand in steps"}])");
  EXPECT_THAT(LoopText(report), HasSubstr("\nwarning: session 'CR': readings stand in steps\n"));
}

TEST(LoopText, TheLimitCountsPartsWithoutAName) {
  Json report = ReportOf(Effect("EB0B", "constant", "urad"));
  report["stopped_early"] = true;
  EXPECT_THAT(LoopText(report), HasSubstr("stopped at the limit of --max-effects with 1 effects: more may be there\n"));
  report["unexplained"] = Json::parse(R"([{"kind": "slip", "variable": "t", "session": "CR"},
                                          {"kind": "check-session", "session": "CT"}])");
  EXPECT_THAT(LoopText(report), HasSubstr("with 1 effects and 1 parts without a name: more may be there\n"));
}

TEST(LoopText, AProposalForOneEffectSaysWhatItIsToldFrom) {
  Json report = ReportOf(Effect("EB0B", "constant", "urad"));
  Json proposal = {{"effect", "EB0B"},      {"text", "session CR again"}, {"test", "later"},
                   {"separates", {"EB0B"}}, {"correlation_before", 0.9},  {"correlation_after", 0.5},
                   {"expected_chi2", 40.0}, {"remaining", Json::array()}};
  report["next_measurement"] = Json::array({proposal});
  EXPECT_THAT(LoopText(report), HasSubstr("tells EB0B from errors that come close to it: correlation 0.900 -> 0.500"));
  report["next_measurement"][0]["separates"] = {"EB0B", "EX0T"};
  EXPECT_THAT(LoopText(report), HasSubstr("tells apart EB0B, EX0T: correlation"));
}

}  // namespace
}  // namespace axiscal::cli
