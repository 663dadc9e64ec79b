// What speaks for and against a new calibration, on facts.
#include "server/routines/judge.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace axiscal::routines {
namespace {

using compare::Comparison;
using compare::Verdict;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const CalibrationId kInUse(11);

compare::Difference One(const std::string& name, double difference, double sigma, Verdict verdict) {
  compare::Difference one;
  one.name = name;
  one.unit = "um";
  one.difference = difference;
  one.sigma = sigma;
  one.verdict = verdict;
  return one;
}

Comparison Of(const std::vector<compare::Difference>& errors, double probability, double max_mm) {
  Comparison comparison;
  comparison.errors = errors;
  comparison.joint = {1.0, static_cast<int>(errors.size()), probability};
  comparison.tool_point.emplace();
  comparison.tool_point->as_programmed.max_mm = max_mm;
  comparison.tool_point->as_programmed.rms_mm = max_mm / 2;
  return comparison;
}

TEST(Judge, WhatAgreesSaysHowFarTheToolPointMoves) {
  const Judgement judgement = JudgeComparison(Of({One("EX0C", 1, 1, Verdict::kAgrees)}, 0.4, 0.0012), kInUse);
  EXPECT_TRUE(judgement.agrees);
  EXPECT_THAT(judgement.doubts, IsEmpty());
  EXPECT_NEAR(*judgement.largest_change_um, 1.2, 1e-12);
  EXPECT_THAT(judgement.text, HasSubstr("it agrees with calibration 11"));
  EXPECT_THAT(judgement.text, HasSubstr("by up to 1.2 um (0.6 um rms)"));
}

TEST(Judge, WhatDiffersIsNamedTheClearestFirst) {
  const Judgement judgement =
      JudgeComparison(Of({One("EX0C", 4, 1, Verdict::kDiffers), One("EY0C", 21, 1.5, Verdict::kDiffers),
                          One("EZ0C", 0, 1, Verdict::kAgrees)},
                         1e-6, 0.02),
                      kInUse);
  EXPECT_FALSE(judgement.agrees);
  EXPECT_THAT(judgement.doubts, IsEmpty());
  EXPECT_THAT(judgement.text, HasSubstr("against calibration 11: EY0C +21 +- 1.5 um, EX0C +4 +- 1 um;"));
}

// No single error stands out, all together do.
TEST(Judge, WhatDiffersJointlyDoesNotAgree) {
  EXPECT_FALSE(JudgeComparison(Of({One("EX0C", 2, 1, Verdict::kMayDiffer)}, 0.01, 0.002), kInUse).agrees);
}

TEST(Judge, WhatIsNotKnownIsADoubt) {
  Comparison comparison = Of({One("EX0C", 1, 1, Verdict::kAgrees)}, 0.4, 0.001);
  comparison.tool_point->unknown = {"EX0B - EX0C"};
  EXPECT_THAT(JudgeComparison(comparison, kInUse).doubts, ElementsAre(HasSubstr("EX0B - EX0C")));
  comparison.tool_point.reset();
  const Judgement nowhere = JudgeComparison(comparison, kInUse);
  EXPECT_FALSE(nowhere.largest_change_um.has_value());
  EXPECT_THAT(nowhere.doubts, ElementsAre(HasSubstr("no readings with positions")));
  const Judgement unsure = JudgeComparison(Of({One("EX0C", 1, NAN, Verdict::kNoUncertainty)}, 1.0, 0.001), kInUse);
  EXPECT_FALSE(unsure.agrees);
  EXPECT_THAT(unsure.doubts, ElementsAre(HasSubstr("uncertainty is missing")));
  const Judgement other = JudgeComparison(Of({One("EXX:backlash", NAN, NAN, Verdict::kOnlyOne)}, 1.0, 0.001), kInUse);
  EXPECT_FALSE(other.agrees);
  EXPECT_THAT(other.doubts, ElementsAre(HasSubstr("do not have the same errors")));
  EXPECT_THAT(JudgeComparison(std::nullopt, std::nullopt).doubts, ElementsAre(HasSubstr("by a person")));
}

TEST(Judge, TolerancesAndWarningsAreDoubts) {
  records::CalibrationRecord candidate;
  candidate.content.estimates = {{"EX0C", records::EstimateUnit::kUm, true, 10.0, 1.0},
                                 {"EY0C", records::EstimateUnit::kUm, false, {}, {}}};
  const std::optional<reports::CalibrationReport> clean = reports::Identification();
  EXPECT_THAT(DoubtsOf(candidate, clean, {{"EX0C", -20, 20}}), IsEmpty());
  EXPECT_THAT(DoubtsOf(candidate, clean, {{"EX0C", -20, 8}}), ElementsAre(HasSubstr("EX0C is 10 +- 1, out of")));
  EXPECT_THAT(DoubtsOf(candidate, clean, {{"EX0C", -20, 10.5}}), ElementsAre(HasSubstr("not certainly within")));
  EXPECT_THAT(DoubtsOf(candidate, clean, {{"EY0C", -20, 20}, {"EB0C", -1, 1}}),
              ElementsAre(HasSubstr("EY0C has a tolerance and no number"), HasSubstr("EB0C has a tolerance")));
  reports::Identification warned;
  warned.fitted.warnings = {{reports::WarningKind::kScatter, "the readings scatter"}};
  EXPECT_THAT(DoubtsOf(candidate, warned, {}), ElementsAre("the readings scatter"));
  reports::Loop loop;
  loop.verdict = reports::Verdict::kUnexplained;
  EXPECT_THAT(DoubtsOf(candidate, loop, {}), ElementsAre(HasSubstr("cannot name")));
  EXPECT_THAT(DoubtsOf(candidate, std::nullopt, {}), ElementsAre("its report cannot be read"));
}

}  // namespace
}  // namespace axiscal::routines
