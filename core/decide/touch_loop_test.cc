// The loop on touch sessions: what the machine lacks, and what the probe lacks, is found among the other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/units.h"
#include "core/decide/close_loop.h"
#include "core/identify/testing/scenario.h"
#include "core/plan/test.h"

namespace axiscal::decide {
namespace {

using loop::Effect;
using loop::Report;
using loop::Verdict;

using ::testing::HasSubstr;

machine::Machine Declaring() {
  machine::Machine machine = machine::testing::MultiTasking();
  machine.declared.clear();
  for (const char* symbol : {"EA0B", "EC0B", "EX0C", "EY0C", "EA0C", "EB0C"})
    machine.declared.push_back(*machine::ParseErrorSymbol(symbol));
  return machine;
}

constexpr char kDeclared[] = R"("EA0B": 40, "EC0B": -61, "EX0C": -22.2, "EY0C": 15.3, "EA0C": -42.9, "EB0C": 45.6)";

// A sphere touched at positions of B and of C with two styli, the ball at `ball_mm`.
std::vector<session::Session> Touched(const machine::Machine& machine, const std::string& terms,
                                      const Eigen::Vector3d& ball_mm, const std::string& prefix, uint64_t seed) {
  const machine::ErrorModel truth =
      identify::testing::Errors(machine, "{" + std::string(kDeclared) + (terms.empty() ? "" : ", " + terms) + "}");
  plan::Mounted mounted;
  mounted.tips_mm = {{0, 0, -350}};
  mounted.balls_mm = {ball_mm};
  std::vector<session::Session> sessions;
  for (const plan::PlannedSession& planned :
       plan::FindTest("touch-sphere")->plan(plan::SituationOfMachine(machine, mounted))) {
    session::Session session = planned.session;
    for (session::HeaderEntry& entry : session.header) {
      if (entry.key == "session") entry.value = prefix + entry.value;
    }
    synthetic::NoiseOptions noise;
    noise.sigma_scale = 0.5;
    noise.draw_setup = false;  // the ball was aligned; 5 mm beside it the probe would miss
    noise.seed = seed + sessions.size();
    auto simulated = synthetic::Simulate(machine, truth, session, noise);
    EXPECT_TRUE(simulated.ok()) << simulated.status();
    sessions.push_back(*std::move(simulated));
  }
  return sessions;
}

Report Close(const std::string& terms, uint64_t seed = 1) {
  const machine::Machine machine = Declaring();
  const auto fit = Touched(machine, terms, {90, 0, 60}, "fit-", seed),
             check = Touched(machine, terms, {20, 70, 90}, "check-", seed + 100);
  auto report = CloseLoop(machine, *identify::BindSessions(machine, fit), *identify::BindSessions(machine, check));
  EXPECT_TRUE(report.ok()) << report.status();
  return report.ok() ? *std::move(report) : Report();
}

bool Names(const Effect& effect, const std::string& name) {
  const machine::Machine machine = Declaring();
  if (machine::NameOf(machine, effect.term) == name) return true;
  return std::any_of(effect.equivalent.begin(), effect.equivalent.end(),
                     [&](const machine::ErrorTerm& other) { return machine::NameOf(machine, other) == name; });
}

TEST(TouchLoop, AMachineThatLacksNothingIsLeftAlone) {
  const Report report = Close("");
  EXPECT_EQ(report.verdict, Verdict::kAdequate);
  EXPECT_TRUE(report.effects.empty());
}

TEST(TouchLoop, LobesOfTheProbeAreFoundAgain) {
  const Report report =
      Close(R"("terms": [{"symbol": "ERT", "shape": "lobe", "order": 3, "amplitude": 3, "phase_deg": 40}])");
  ASSERT_EQ(report.effects.size(), 1u);
  const Effect& effect = report.effects[0];
  EXPECT_EQ(machine::NameOf(Declaring(), effect.term), "ERT:lobe(3)");
  EXPECT_NEAR(effect.amplitude, 3e-3, 4.0 * effect.amplitude_sigma);
  EXPECT_LT(effect.amplitude_sigma, 0.3e-3);
  EXPECT_NEAR(std::atan2(effect.term.amplitude[1], effect.term.amplitude[0]) * base::kDegPerRad, 40.0, 10.0);
  EXPECT_EQ(report.verdict, Verdict::kExtended);
  EXPECT_THAT(reports::ToJson(loop::ReportOf(Declaring(), report)), HasSubstr("\"variable\": \"approach\""));
}

// Pre-travel alike in all directions: a stylus that is smaller than stated.
TEST(TouchLoop, PreTravelOfTheProbeIsFoundAgain) {
  const Report report = Close(R"("terms": [{"symbol": "ERT", "shape": "pre-travel", "amplitude": 4}])");
  ASSERT_EQ(report.effects.size(), 1u);
  EXPECT_TRUE(Names(report.effects[0], "ERT:pre-travel"));
  EXPECT_NEAR(report.effects[0].amplitude, 4e-3, 4.0 * report.effects[0].amplitude_sigma);
}

TEST(TouchLoop, AnErrorOfTheMachineIsNotTakenForTheProbes) {
  const Report report = Close(R"("EB0B": 80)");
  ASSERT_EQ(report.effects.size(), 1u);
  EXPECT_TRUE(Names(report.effects[0], "EB0B")) << machine::NameOf(Declaring(), report.effects[0].term);
}

}  // namespace
}  // namespace axiscal::decide
