// Plans of length and direction instruments: simulated and identified, they give the errors that the machine has.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/identify/identify.h"
#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"
#include "core/plan/test.h"
#include "core/synthetic/simulate.h"

namespace axiscal::plan {
namespace {

using ::testing::HasSubstr;

machine::Machine WithTravel() {
  machine::Machine machine = machine::testing::TiltingTable();  // Y under the table: tool and table move
  for (machine::Axis& axis : machine.axes) {
    if (axis.kind != machine::AxisKind::kLinear) continue;
    axis.min_position = -200.0;
    axis.max_position = 300.0;
  }
  return machine;
}

std::vector<PlannedSession> PlannedBy(const machine::Machine& machine, const std::string& test) {
  Mounted mounted;
  mounted.tips_mm = {{0, 0, -150}};
  return FindTest(test)->plan(SituationOfMachine(machine, mounted));
}

struct Counted {
  int held = 0, all = 0, within_three = 0;
};

// Simulates the sessions with these errors and identifies them again.
void AddFit(const machine::Machine& machine, const std::vector<PlannedSession>& planned, const std::string& errors,
            uint64_t seed, Counted* counted) {
  const machine::ErrorModel truth = *machine::ReadErrors(errors, machine);
  std::vector<session::Session> measured;
  for (const PlannedSession& one : planned) {
    synthetic::NoiseOptions noise;
    noise.seed = 100 * seed + measured.size();
    auto session = synthetic::Simulate(machine, truth, one.session, noise);
    ASSERT_TRUE(session.ok()) << session.status();
    measured.push_back(*std::move(session));
  }
  identify::Options options;
  options.model = truth;
  const auto result = identify::Identify(machine, measured, options);
  ASSERT_TRUE(result.ok()) << result.status();
  const std::vector<identify::Parameter> parameters = identify::ListParameters(truth, false);
  for (size_t i = 0; i < parameters.size(); ++i) {
    const identify::Estimate& estimate = result->estimates[i];
    ASSERT_TRUE(estimate.identifiable) << estimate.name;
    const double off = std::abs(estimate.value - identify::ValueOf(truth, parameters[i])) / estimate.sigma;
    ++counted->all;
    counted->held += off <= result->coverage_factor;
    counted->within_three += off <= 3.0;
  }
}

// 95 % intervals hold the truth in 95 % but for 3.5 binomial standard deviations; one in 370 is beyond three sigmas.
void ExpectHonest(const Counted& counted) {
  const double all = counted.all;
  EXPECT_GE(all, 60.0);
  EXPECT_NEAR(counted.held / all, 0.95, 3.5 * std::sqrt(0.95 * 0.05 / all));
  EXPECT_GE(counted.within_three / all, 1.0 - 1.0 / 370.0 - 3.5 * std::sqrt(1.0 / 370.0 / all));
}

void Expect(const std::string& test, size_t sessions, const std::string& errors) {
  const machine::Machine machine = WithTravel();
  const std::vector<PlannedSession> planned = PlannedBy(machine, test);
  ASSERT_EQ(planned.size(), sessions);
  Counted counted;
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    AddFit(machine, planned, errors, seed, &counted);
    if (::testing::Test::HasFatalFailure()) return;
  }
  ExpectHonest(counted);
}

TEST(LengthTests, AnInterferometerTellsPositioning) {
  Expect("length-line", 3, R"({"terms": [{"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 40},
      {"symbol": "EXX", "shape": "backlash", "variable": "X", "amplitude": 4},
      {"symbol": "EYY", "shape": "linear", "variable": "Y", "amplitude": -30},
      {"symbol": "EZZ", "shape": "quadratic", "variable": "Z", "amplitude": 9}]})");
}

TEST(LengthTests, StraightnessOpticsTellStraightness) {
  Expect("straightness-line", 6, R"({"terms": [
      {"symbol": "EYX", "shape": "quadratic", "variable": "X", "amplitude": 12},
      {"symbol": "EZY", "shape": "quadratic", "variable": "Y", "amplitude": -7},
      {"symbol": "EXZ", "shape": "quadratic", "variable": "Z", "amplitude": 5}]})");
}

TEST(LengthTests, AutocollimatorsTellTurns) {
  Expect("direction-line", 9, R"({"terms": [
      {"symbol": "EBX", "shape": "linear", "variable": "X", "amplitude": 60},
      {"symbol": "EAY", "shape": "quadratic", "variable": "Y", "amplitude": -25},
      {"symbol": "ECZ", "shape": "linear", "variable": "Z", "amplitude": 35}]})");
}

TEST(LengthTests, AnIndexingTableTellsAngles) {
  Expect("direction-turn", 2, R"({"terms": [
      {"symbol": "ECC", "shape": "harmonic", "variable": "C", "order": 1, "amplitude": 30, "phase_deg": 40},
      {"symbol": "EAA", "shape": "backlash", "variable": "A", "amplitude": 12}]})");
}

TEST(LengthTests, DistancesTellSquareness) {
  Expect("distance-grid", 3, R"({"EB0Z": 120, "EC0Y": -90,
      "terms": [{"symbol": "EZZ", "shape": "linear", "variable": "Z", "amplitude": 200}]})");
}

// The tracker moves by a third of a mm and turns by as many mrad from look to look, as its set-up is drawn.
TEST(LengthTests, ATrackerThatMovesTellsScales) {
  Expect("tracker-references", 1, R"({"EB0Z": 120, "terms": [
      {"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": -150},
      {"symbol": "EZZ", "shape": "linear", "variable": "Z", "amplitude": 200}]})");
}

// The targets' ends are nine tenths of the travel apart; L grows as the axis rises, whatever branch it stands on.
TEST(LengthTests, LinesGoOverTheTravelBothWays) {
  const machine::Machine machine = WithTravel();
  const std::vector<PlannedSession> planned = PlannedBy(machine, "length-line");
  const std::vector<double>& x_mm = session::FindColumn(planned[0].session, "X_mm")->values;
  ASSERT_EQ(x_mm.size(), 110u);
  EXPECT_EQ(x_mm.front(), -175.0);
  EXPECT_EQ(x_mm[10], 275.0);
  EXPECT_EQ(x_mm[11], 275.0);
  EXPECT_EQ(session::FindColumn(planned[0].session, "X_sense")->values[10], 1.0);
  EXPECT_EQ(session::FindColumn(planned[0].session, "X_sense")->values[11], -1.0);
  EXPECT_THAT(planned[0].text, HasSubstr("X from -175 to 275 mm, 11 targets, 5 times there and back"));
  synthetic::NoiseOptions exact;
  exact.sigma_scale = 0.0;
  exact.draw_setup = false;
  for (const PlannedSession& one : planned) {
    const auto session = synthetic::Simulate(machine, {}, one.session, exact);
    ASSERT_TRUE(session.ok()) << session.status();
    const std::vector<double>& read_mm = session::FindColumn(*session, "L_mm")->values;
    EXPECT_NEAR(read_mm[10] - read_mm[0], 450.0, 1e-9) << one.text;
  }
}

}  // namespace
}  // namespace axiscal::plan
