#include "core/reports/warning.h"

#include <gtest/gtest.h>

namespace axiscal::reports {
namespace {

void Says(const WarningFacts& facts, WarningKind kind, const std::string& text) {
  const Warning warning = InWords(facts);
  EXPECT_EQ(warning.kind, kind);
  EXPECT_EQ(warning.text, text);
}

TEST(Warning, EachKindIsWorded) {
  Says(Scatter{.times_sigma = 2.34}, WarningKind::kScatter,
       "the readings scatter by 2.3 times their stated sigma about this model: it lacks something, or a session is bad");
  Says(Scatter{.times_sigma = 3.0, .about = Scatter::About::kCutter}, WarningKind::kScatter,
       "the readings scatter by 3.0 times their stated sigma about the curves of this cutter: a number of it is "
       "another, or readings are bad");
  Says(SetAside{12, 100}, WarningKind::kSetAside,
       "12 of 100 readings stand out and were set aside, too many for chips: the model lacks something that they show");
  Says(NoInterval{{"EX0C", "EA0C"}}, WarningKind::kInterval,
       "EX0C, EA0C: the readings leave the set-up so open that no interval can be stated (another set-up with other "
       "errors explains them as well)");
  Says(NoNumber{{{"EX0C", 1234.5, "um"}, {"EA0C", -400.0, "urad"}}}, WarningKind::kNoNumber,
       "EX0C at 1234 um, EA0C at -400 urad: the fit ended there because something had to take up what the readings "
       "show, but no reading supports such a size; do not compensate with this model away from the measured poses");
  Says(SharedStages{{"BX", "BY"}, {"run_out_x of set-up mount"}}, WarningKind::kHeld,
       "the held errors come from sessions that are used again (BX, BY): the stated sigmas take both stages for "
       "independent; identify from all sessions together");
  Says(SharedStages{{}, {"run_out_x of set-up mount"}}, WarningKind::kHeld,
       "the held errors rest on the same stated sigma as this fit (run_out_x of set-up mount): the stated sigmas take "
       "both stages for independent; identify from all sessions together");
  Says(CoarseReadings{"CR", 2.0, 0.3, 0.57735, 2.0}, WarningKind::kResolution,
       "session 'CR': readings stand in steps of 2 um, expected at most 2 times the stated sigma of 0.3 um: what "
       "rounding hides is counted as noise of 0.5774 um");
}

TEST(Warning, OfAStoredCalibrationSaysWhatToDo) {
  EXPECT_EQ(PoorFitText(5.2, false),
            "the readings scatter by 2.280 times their stated sigma about this model: it lacks something (axiscal "
            "close-loop looks for it), or a session is bad");
  EXPECT_EQ(PoorFitText(5.2, true),
            "the readings scatter by 2.280 times their stated sigma about this model: it lacks something that has no "
            "name yet, or a session is bad");
}

}  // namespace
}  // namespace axiscal::reports
