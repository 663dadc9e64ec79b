
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/decide/close_loop.h"
#include "core/identify/testing/scenario.h"

namespace axiscal::decide {
namespace {

using loop::Report;

using ::testing::Contains;
using ::testing::IsSupersetOf;
using ::testing::Not;

const machine::Machine kMachine = machine::testing::MultiTasking();

// Name of the one effect found, then those of its class.
std::vector<std::string> ClassFoundIn(const std::string& effect, double amplitude) {
  const auto truth = identify::testing::Errors(
      kMachine, absl::StrCat(R"({"EA0B": 82.1, "EC0B": -61.0, "EX0C": -22.2, "EY0C": 15.3, "terms": [{)", effect,
                             R"(, "amplitude": )", amplitude, "}]}"));
  const auto sessions = identify::testing::Measure(kMachine, truth, {});
  const Report report = CloseLoop(kMachine, *identify::BindSessions(kMachine, sessions), {}).value();
  EXPECT_EQ(report.effects.size(), 1u);
  if (report.effects.empty()) return {};
  std::vector<std::string> names = {machine::NameOf(kMachine, report.effects[0].term)};
  for (const machine::ErrorTerm& other : report.effects[0].equivalent) {
    names.push_back(machine::NameOf(kMachine, other));
  }
  return names;
}

// A drift of the tool holder's place and of its tilt are 0.98 alike while two tools are 50 mm apart in length; ten
// times as much of it and the second tool tells them.
TEST(Classes, AStrongDriftIsNoTilt) {
  const std::string drift = R"("symbol": "EXT", "shape": "drift")";
  EXPECT_THAT(ClassFoundIn(drift, 20.0), IsSupersetOf({"EXT:drift", "EBT:drift"}));
  EXPECT_THAT(ClassFoundIn(drift, 200.0), ::testing::ElementsAre("EXT:drift"));
}

TEST(Classes, AStrongStraightnessIsNoRoll) {
  const std::string straightness = R"("symbol": "EYY", "shape": "quadratic")";
  EXPECT_THAT(ClassFoundIn(straightness, 20.0), IsSupersetOf({"EYY:quadratic", "EAT:quadratic(Y)"}));
  const std::vector<std::string> strong = ClassFoundIn(straightness, 200.0);
  EXPECT_THAT(strong, Contains("EYY:quadratic"));
  EXPECT_THAT(strong, Not(Contains("EAT:quadratic(Y)")));
}

}  // namespace
}  // namespace axiscal::decide
