// Every test that can be planned gives the truth: plan, simulate, log, reduce, identify. The tests are those of the
// planners' own lists, so that a new one is held to this as well.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "core/base/testing/source_path.h"
#include "core/plan/test.h"
#include "tests/rates/planned_score.h"

namespace axiscal::rates {
namespace {

using ::testing::HasSubstr;

class PlannedCoverage : public ::testing::TestWithParam<std::string> {};

// Of `intervals` numbers at least so many hold what each should hold with probability `share`: three standard
// deviations of a binomial count.
int Least(int intervals, double share) {
  return static_cast<int>(std::floor(share * intervals - 3.0 * std::sqrt(share * (1.0 - share) * intervals)));
}

TEST_P(PlannedCoverage, IntervalsHoldTheTruth) {
  constexpr int kIntervals = 600, kMostFits = 800;
  const PlannedScore score = JudgePlanned(GetParam(), kIntervals, kMostFits);
  ASSERT_GT(score.cases, 0) << "no machine here runs it";
  // A fit that does not converge says so and gives no number.
  EXPECT_LE(static_cast<int>(score.refused.size()), score.fits / 10) << ::testing::PrintToString(score.refused);
  const Coverage& all = score.coverage.at("all");
  EXPECT_GE(all.intervals, kIntervals) << "tells too little to judge it";
  EXPECT_GE(all.held, Least(all.intervals, 0.95)) << ToText(score.coverage);
}

INSTANTIATE_TEST_SUITE_P(Every, PlannedCoverage, ::testing::ValuesIn(plan::TestNames()), [](const auto& test) {
  std::string name = test.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

// docs/validation.md is made by a command (tests/validation/run): a test that came later is missing there.
TEST(Validation, ThePageHasEveryTest) {
  std::ifstream file(base::SourcePath("/docs/validation.md"));
  std::stringstream page;
  page << file.rdbuf();
  for (const std::string& name : plan::TestNames())
    EXPECT_THAT(page.str(), HasSubstr("| `" + name + "` |")) << "run tests/validation/run";
}

}  // namespace
}  // namespace axiscal::rates
