#include "core/identify/budget.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/machine/testing/machines.h"

namespace axiscal::identify {
namespace {

using ::testing::HasSubstr;

const machine::Machine kMachine = machine::testing::MultiTasking();

std::string WithSources(const std::string& sources) {
  return R"({"axiscal": "budget/1", "sources": [)" + sources + "]}";
}

TEST(Budget, SourcesComeInUmAndUrad) {
  const auto budget = ReadBudget(R"({"axiscal": "budget/1", "reading_noise": false, "note": "from the data sheet",
      "sources": [
        {"name": "C angle", "symbol": "EC0C", "half_width": 70, "drawn": "reading", "sessions": ["I"]},
        {"name": "squareness", "symbol": "EYX", "shape": "linear", "sigma": 8, "drawn": "run"},
        {"name": "probe", "reading": true, "half_width": 4, "drawn": "session"}]})",
                                 kMachine);
  ASSERT_TRUE(budget.ok()) << budget.status();
  EXPECT_FALSE(budget->with_reading_noise);
  ASSERT_EQ(budget->sources.size(), 3u);
  const Source& angle = budget->sources[0];
  EXPECT_EQ(machine::NameOf(kMachine, angle.term), "EC0C");
  EXPECT_NEAR(angle.scale, 70e-6, 1e-18);
  EXPECT_NEAR(angle.sigma(), 70e-6 / std::sqrt(3.0), 1e-12);
  EXPECT_TRUE(angle.ActsIn("I"));
  EXPECT_FALSE(angle.ActsIn("II"));
  const Source& squareness = budget->sources[1];
  EXPECT_EQ(machine::NameOf(kMachine, squareness.term), "EYX:linear");
  EXPECT_EQ(squareness.distribution, Distribution::kNormal);
  EXPECT_EQ(squareness.drawn_per, DrawnPer::kRun);
  EXPECT_TRUE(squareness.ActsIn("anything"));
  EXPECT_TRUE(budget->sources[2].is_reading);
  EXPECT_NEAR(budget->sources[2].scale, 4e-3, 1e-15);
}

// The two parts of a probe's lobe are drawn each, along the approach of every touch.
TEST(Budget, APreTravelLobeIsASource) {
  const auto budget = ReadBudget(
      WithSources(R"({"name": "lobe", "symbol": "ERT", "shape": "lobe", "order": 3, "sigma": 2, "drawn": "run"})"),
      kMachine);
  ASSERT_TRUE(budget.ok()) << budget.status();
  EXPECT_EQ(machine::NameOf(kMachine, budget->sources[0].term), "ERT:lobe(3)");
  EXPECT_NEAR(budget->sources[0].scale, 2e-3, 1e-15);
}

struct Bad {
  const char* text;
  const char* message;
};

TEST(Budget, SaysWhereItIsWrong) {
  const Bad kBad[] = {
      {"[]", "\"axiscal\": \"budget/1\""},
      {R"({"axiscal": "budget/2"})", "budget/1"},
      {R"({"axiscal": "budget/1", "source": []})", "budget: source: unknown member"},
      {R"({"axiscal": "budget/1", "sources": {}})", "expected a list"},
      {R"({"axiscal": "budget/1", "reading_noise": "no"})", "budget: reading_noise: \"no\", expected true or false"},
      {R"({"axiscal": "budget/1", "reading_noise": false})", "nothing would be drawn"},
  };
  for (const Bad& bad : kBad) {
    const auto budget = ReadBudget(bad.text, kMachine);
    EXPECT_THAT(std::string(budget.status().message()), HasSubstr(bad.message)) << bad.text;
    EXPECT_EQ(budget.status().code(), absl::StatusCode::kInvalidArgument) << bad.text;
  }
  const Bad kBadSources[] = {
      {R"(7)", "sources[0]: 7, expected an object"},
      {R"({"symbol": "EC0C", "sigma": 1, "drawn": "run"})", "sources[0]: 'name' is missing"},
      {R"({"name": "a", "symbol": "EC0C", "drawn": "run"})", "one of 'half_width' (uniform) and 'sigma' (normal)"},
      {R"({"name": "a", "symbol": "EC0C", "sigma": 1, "half_width": 1, "drawn": "run"})", "one of 'half_width'"},
      {R"({"name": "a", "symbol": "EC0C", "sigma": 0, "drawn": "run"})", "'sigma' = 0, expected a number > 0"},
      {R"({"name": "a", "symbol": "EC0C", "sigma": 1})", "'drawn' is missing, expected \"reading\""},
      {R"({"name": "a", "symbol": "EC0C", "sigma": 1, "drawn": "day"})", "'drawn' = \"day\""},
      {R"({"name": "a", "symbol": "EC0Q", "sigma": 1, "drawn": "run"})", "machine 'mt' has no axis Q"},
      {R"({"name": "a", "symbol": "EXX", "sigma": 1, "drawn": "run"})", "EXX does not go with shape 'constant'"},
      {R"({"name": "a", "symbol": "EC0C", "amplitude": 2, "sigma": 1, "drawn": "run"})",
       "'amplitude' is what is drawn"},
      {R"({"name": "a", "symbol": "EXC", "shape": "harmonic", "order": 2, "phase_deg": 9, "sigma": 1, "drawn": "run"})",
       "'phase_deg' is what is drawn"},
      {R"({"name": "a", "symbol": "EC0C", "sigma": 1, "drawn": "run", "sessions": "I"})", "expected names of sessions"},
      {R"({"name": "a", "reading": true, "symbol": "EC0C", "sigma": 1, "drawn": "run"})", "does not go with 'reading'"},
      {R"({"name": "a", "reading": true, "sigma": 1, "drawn": "run"}, {"name": "a", "reading": true, "sigma": 1,
           "drawn": "run"})",
       "sources[1]: 'a' is there twice"},
  };
  for (const Bad& bad : kBadSources) {
    const auto budget = ReadBudget(WithSources(bad.text), kMachine);
    EXPECT_THAT(std::string(budget.status().message()), HasSubstr(bad.message)) << bad.text;
  }
}

TEST(Budget, NamesASessionThatIsNotThere) {
  const auto budget = ReadBudget(
      WithSources(R"({"name": "a", "symbol": "EC0C", "sigma": 1, "drawn": "run", "sessions": ["BX", "BQ"]})"),
      kMachine);
  ASSERT_TRUE(budget.ok()) << budget.status();
  EXPECT_TRUE(CheckSessions(*budget, {"BX", "BQ"}).ok());
  EXPECT_THAT(std::string(CheckSessions(*budget, {"BX", "BY"}).message()), HasSubstr("'a': session 'BQ' is not among"));
}

}  // namespace
}  // namespace axiscal::identify
