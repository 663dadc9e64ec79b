// The words of findings.
#include "core/drift/finding.h"

#include <gtest/gtest.h>

namespace axiscal::drift {
namespace {

using namespace std::chrono_literals;  // dates

base::UtcTime On(int year, unsigned month, unsigned day, std::chrono::minutes minutes = 0min) {
  return std::chrono::sys_days(std::chrono::year(year) / std::chrono::month(month) / std::chrono::day(day)) + minutes;
}

StepChange Collision() {
  StepChange step{On(2026, 5, 5), On(2026, 5, 12), On(2026, 5, 19), {}, 12.0, 0.997, Word::kCertain, false};
  step.amounts = {{"EX0C", Unit::kUm, 21.2, 1.1}, {"EB0C", Unit::kUrad, 14.3, 2.0}};
  return step;
}

TEST(FindingText, AStep) {
  StepChange step = Collision();
  EXPECT_EQ(Text(step),
            "between 5 and 12 May 2026 EX0C and EB0C jumped together by 21 um and 14 urad, certainty 99.7 %");
  step.amounts = {{"EX0C", Unit::kUm, -2.13, 0.4}};
  step.word = Word::kProbable;
  step.certainty = 0.9;
  EXPECT_EQ(Text(step), "between 5 and 12 May 2026 EX0C jumped by -2.1 um, probable, certainty 90 %");
  step.is_revision = true;
  EXPECT_EQ(Text(step), "corrected: between 5 and 12 May 2026 EX0C jumped by -2.1 um, probable, certainty 90 %");
  step.is_revision = false;
  step.amounts.resize(3, {"EA0C", Unit::kUrad, 4.0, 1.0});
  EXPECT_EQ(Text(step),
            "between 5 and 12 May 2026 EX0C, EA0C and EA0C jumped together by -2.1 um, 4 urad and 4 urad, probable, "
            "certainty 90 %");
}

TEST(FindingText, DatesAreSaidAsShortlyAsTheyAreClear) {
  StepChange step = Collision();
  step.amounts.pop_back();
  step.after = On(2026, 4, 28);
  EXPECT_EQ(Text(step).substr(0, 34), "between 28 April and 12 May 2026 E");
  step.after = On(2025, 12, 30);
  step.by = On(2026, 1, 6);
  EXPECT_EQ(Text(step).substr(0, 44), "between 30 December 2025 and 6 January 2026 ");
  step.after = On(2026, 5, 5, 370min);
  step.by = On(2026, 5, 5, 955min);
  EXPECT_EQ(Text(step).substr(0, 48), "on 5 May 2026 between 06:10 UTC and 15:55 UTC EX");
}

TEST(FindingText, NothingIsSaidToBeSureNorMinusZero) {
  StepChange step = Collision();
  step.amounts = {{"EX0C", Unit::kUm, -0.2, 3.0}};
  step.certainty = 1.0;
  EXPECT_EQ(Text(step), "between 5 and 12 May 2026 EX0C jumped by 0 um, certainty 99.9 %");
}

TEST(FindingText, TheOthers) {
  const base::UtcTime at = On(2026, 5, 12);
  EXPECT_EQ(Text(Suspect{at, {{"EX0C", Unit::kUm, 21.2, 1.1}}, 0.995}),
            "the calibration of 12 May 2026 has EX0C off by 21 um from what was expected: a bad calibration or a jump, "
            "repeat it; certainty 99.5 %");
  EXPECT_EQ(Text(Retraction{On(2026, 5, 5), at, On(2026, 5, 19), {"EX0C", "EB0C"}}),
            "EX0C and EB0C went back: what was told as a jump between 5 and 12 May 2026 was a bad calibration rather");
  EXPECT_EQ(Text(Slope{at, false, {"EX0C", Unit::kUm, -8.04, 0.52}, 0.981}),
            "EX0C wears by -8.0 +- 0.5 um a year, certainty 98 %");
  EXPECT_EQ(Text(Slope{at, true, {"EX0C", Unit::kUm, 0.0, 0.5}, 0.7}), "EX0C no longer wears one way");
  Season season{at, false, {"EB0C", Unit::kUrad, 5.96, 0.4}, {}, 0.9995};
  EXPECT_EQ(Text(season), "EB0C goes with the season by 6.0 urad to either side, certainty 99.9 %");
  season.per_kelvin = Amount{"EB0C", Unit::kUrad, 1.25, 0.05};
  EXPECT_EQ(Text(season),
            "EB0C goes with the temperature by 1.25 urad per K, and by 6.0 urad to either side with the season, "
            "certainty 99.9 %");
  season.is_over = true;
  EXPECT_EQ(Text(season), "EB0C no longer goes with the season");
  EXPECT_EQ(Text(Noise{at, false, "EX0C", 1.83}),
            "EX0C scatters from calibration to calibration 1.8 times as much as its calibrations state");
  EXPECT_EQ(Text(Noise{at, true, "EX0C", 1.2}), "EX0C scatters as its calibrations state");
  EXPECT_EQ(
      Text(Unstable{On(2026, 4, 7), at}),
      "the calibrations from 7 April 2026 to 12 May 2026 agree neither with those before nor with each other: the "
      "machine or the measurement is not stable, and its history starts anew");
}

TEST(Certainty, RisesWithTheScore) {
  double before = 0.0;
  for (double score = -3.0; score < 40.0; score += 0.25) {
    EXPECT_GE(CertaintyOf(score), before);
    EXPECT_LT(CertaintyOf(score), 1.0);
    before = CertaintyOf(score);
  }
  EXPECT_EQ(WordOf(0.99), Word::kPossible);
  EXPECT_EQ(WordOf(1.0), Word::kProbable);
  EXPECT_EQ(WordOf(4.0), Word::kProbable);
  EXPECT_EQ(WordOf(4.01), Word::kCertain);
}

}  // namespace
}  // namespace axiscal::drift
