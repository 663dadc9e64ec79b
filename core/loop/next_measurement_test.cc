#include "core/loop/next_measurement.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/decide/close_loop.h"
#include "core/identify/testing/scenario.h"
#include "core/loop/same_always.h"
#include "core/plan/test.h"

namespace axiscal::loop {
namespace {

using ballbar::Pattern;
using identify::testing::Errors;
using identify::testing::Measured;
using machine::ErrorTerm;
using machine::Machine;

bool Has(const Machine& machine, const std::vector<ErrorTerm>& terms, const std::string& name) {
  return std::any_of(terms.begin(), terms.end(),
                     [&](const ErrorTerm& term) { return machine::NameOf(machine, term) == name; });
}

// The reported effect and what it is not told from; names of one effect count once.
std::vector<ErrorTerm> ClassOf(const Machine& machine, const Effect& effect) {
  std::vector<ErrorTerm> all = {effect.term}, distinct;
  all.insert(all.end(), effect.equivalent.begin(), effect.equivalent.end());
  const std::vector<int> first = FirstOfTheSame(machine, {0, 0, -150}, all);
  for (size_t i = 0; i < all.size(); ++i) {
    if (first[i] == static_cast<int>(i)) distinct.push_back(all[i]);
  }
  return distinct;
}

Report Close(const Machine& machine, const std::vector<session::Session>& sessions) {
  return decide::CloseLoop(machine, *identify::BindSessions(machine, sessions), {}).value();
}

// Measures what the report proposes, on the same machine.
void AddProposed(const Machine& machine, const machine::ErrorModel& truth, const Report& report, uint64_t seed,
                 std::vector<session::Session>* sessions) {
  for (const Proposal& proposal : report.next_measurement) {
    if (proposal.test.empty()) continue;
    synthetic::NoiseOptions noise;
    noise.seed = seed + sessions->size();
    sessions->push_back(synthetic::Simulate(machine, truth, proposal.session, noise).value());
  }
}

// A circle in XY, one way: squareness shows as xy / R, and so does a servo of X that lags behind that of Y.
session::Session OneWayCircle(const Machine& machine) {
  const std::vector<instruments::MeasuringRun> none;
  const plan::Situation situation = plan::SituationOf(machine, none);
  session::Session circle = plan::FindTest("ballbar-circle")->plan(situation)[0].session;
  const size_t turn = circle.reading_count() / 2 + 1;
  for (session::Column& column : circle.columns) column.values.resize(turn);
  for (session::HeaderEntry& entry : circle.header) {
    if (entry.key == "session") entry.value = "circle-one-way";
  }
  return circle;
}

TEST(NextMeasurement, SquarenessAndServoMismatchAreToldApartByTheOtherSense) {
  Machine machine = machine::testing::TiltingTable();
  machine.declared.clear();
  // A servo that lags by much is told by the ends of the circle, where its speed is not that of the circle.
  for (const char* effect :
       {R"({"EC0Y": 60})", R"({"terms": [{"symbol": "EXX", "shape": "lag", "amplitude": 0.5}]})"}) {
    SCOPED_TRACE(effect);
    const machine::ErrorModel truth = Errors(machine, effect);
    std::vector<session::Session> sessions = {synthetic::Simulate(machine, truth, OneWayCircle(machine), {}).value()};
    const Report report = Close(machine, sessions);
    ASSERT_EQ(report.effects.size(), 1u);
    const std::vector<ErrorTerm> before = ClassOf(machine, report.effects[0]);
    EXPECT_TRUE(Has(machine, before, "EC0Y") || Has(machine, before, "EC0X"))
        << machine::NameOf(machine, before[0]) << " " << before.size();
    EXPECT_TRUE(Has(machine, before, "EXX:lag"));

    ASSERT_FALSE(report.next_measurement.empty());
    const Proposal& next = report.next_measurement[0];
    ASSERT_TRUE(next.test == "other-sense" || next.test == "ballbar-circle") << next.test;
    EXPECT_GT(next.correlation_before, 0.999);
    EXPECT_LT(next.correlation_after, 0.975);
    AddProposed(machine, truth, report, 100, &sessions);
    const Report after = Close(machine, sessions);
    ASSERT_FALSE(after.effects.empty());
    const std::vector<ErrorTerm> left = ClassOf(machine, after.effects[0]);
    EXPECT_NE(Has(machine, left, "EC0Y") || Has(machine, left, "EC0X"), Has(machine, left, "EXX:lag"));
    EXPECT_LT(left.size(), before.size());
  }
}

struct Case {
  const char* truth;  // the effect's name
  const char* json;   // as in errors.json
  std::vector<Measured> sessions;
};

class Shrinks : public ::testing::TestWithParam<Case> {};

TEST_P(Shrinks, TheClassShrinksToTheTrueEffectOnceTheProposedSessionsAreMeasured) {
  const Machine machine = machine::testing::MultiTasking();
  const machine::ErrorModel truth =
      Errors(machine, R"({"EA0B": 40, "EC0B": -61, "EX0C": -22, "EY0C": 15, "EZ0T": 30, "terms": [)" +
                          std::string(GetParam().json) + "]}");
  ballbar::PatternOptions options;
  options.step_deg = 2.0;
  std::vector<session::Session> sessions = identify::testing::Measure(machine, truth, {}, GetParam().sessions, options);
  const Report report = Close(machine, sessions);
  ASSERT_EQ(report.effects.size(), 1u);
  ASSERT_GT(ClassOf(machine, report.effects[0]).size(), 1u);
  ASSERT_FALSE(report.next_measurement.empty());
  for (const Proposal& proposal : report.next_measurement) {
    ASSERT_FALSE(proposal.test.empty());
    EXPECT_FALSE(proposal.separates.empty());
  }
  AddProposed(machine, truth, report, 7, &sessions);
  const Report after = Close(machine, sessions);
  ASSERT_FALSE(after.effects.empty());
  const std::vector<ErrorTerm> left = ClassOf(machine, after.effects[0]);
  EXPECT_EQ(left.size(), 1u) << machine::NameOf(machine, left.back());
  std::vector<ErrorTerm> all = {after.effects[0].term};
  all.insert(all.end(), after.effects[0].equivalent.begin(), after.effects[0].equivalent.end());
  EXPECT_TRUE(Has(machine, all, GetParam().truth)) << machine::NameOf(machine, all[0]);
}

INSTANTIATE_TEST_SUITE_P(
    Effects, Shrinks,
    ::testing::Values(Case{"EXX:backlash",
                           R"({"symbol": "EXX", "shape": "backlash", "amplitude": 6})",
                           {{"BX", Pattern::kBX, 356.4}, {"BZ", Pattern::kBZ, 356.4}}},
                      Case{"EZT:drift",
                           R"({"symbol": "EZT", "shape": "drift", "amplitude": 40})",
                           {{"BX", Pattern::kBX, 356.4}, {"CA", Pattern::kCA, 356.4}, {"CR", Pattern::kCR, 406.4}}},
                      Case{"EZC:harmonic(2)",
                           R"({"symbol": "EZC", "shape": "harmonic", "order": 2, "amplitude": 4, "phase_deg": 120})",
                           {{"CR", Pattern::kCR, 356.4}, {"CA", Pattern::kCA, 356.4}, {"BX", Pattern::kBX, 356.4}}}));

// Two axes that move the same body along the same line, one after the other, share a drift: nothing tells whose it is.
TEST(NextMeasurement, WhatNoMeasurementTellsIsNotPromised) {
  const Machine machine = machine::testing::MultiTasking();
  const int x = machine::FindAxis(machine, "X"), z = machine::FindAxis(machine, "Z");
  const ErrorTerm in_x{x, machine::Component::kZ, shapes::Drift{}, {0.01, 0}};
  const ErrorTerm in_z{z, machine::Component::kZ, shapes::Drift{}, {}};
  EXPECT_EQ(FirstOfTheSame(machine, {0, 0, -350}, {in_x, in_z}), (std::vector<int>{0, 0}));
  const int c = machine::FindAxis(machine, "C");
  const ErrorTerm across{c, machine::Component::kX, shapes::Harmonic{c, 1.0}, {}};
  const ErrorTerm other_across{c, machine::Component::kY, shapes::Harmonic{c, 1.0}, {}};
  const ErrorTerm twice{c, machine::Component::kY, shapes::Harmonic{c, 2.0}, {}};
  EXPECT_EQ(FirstOfTheSame(machine, {0, 0, -350}, {across, other_across, twice}), (std::vector<int>{0, 0, 2}));
  // What remembers a temperature is no drift, and not the same along all axes; its time constant does not matter.
  const ErrorTerm late_z{machine.tool_joint(), machine::Component::kZ, shapes::ThermalLag{"T_spindle_C", 900.0}, {}};
  ErrorTerm late_x = late_z, later_z = late_z, body_z = late_z;
  late_x.component = machine::Component::kX;
  std::get<shapes::ThermalLag>(later_z.shape).tau_s = 1500.0;
  body_z.shape = shapes::ThermalLag{shapes::kTemperatureChannel, 900.0};
  EXPECT_EQ(FirstOfTheSame(machine, {0, 0, -350}, {in_z, late_z, late_x, later_z, body_z}),
            (std::vector<int>{0, 1, 2, 1, 4}));
  const ErrorTerm curve{c, machine::Component::kX, shapes::Curve{c, {.is_turn = true}}, {}};
  EXPECT_EQ(FirstOfTheSame(machine, {0, 0, -350}, {curve, across, curve, other_across}),
            (std::vector<int>{0, 1, 2, 1}));
  machine::ErrorModel truth;
  truth.terms.push_back(in_x);
  const auto sessions = identify::testing::Measure(machine, truth, {});
  auto problem = identify::MakeProblem(machine, *identify::BindSessions(machine, sessions));
  const identify::Point point = identify::StartingPoint(*problem, truth);
  EXPECT_TRUE(Proposer(*problem, point).Propose(in_x, {in_z}).empty());
}

TEST(NextMeasurement, AnEffectWithoutOthersNeedsNoMeasurement) {
  const Machine machine = machine::testing::MultiTasking();
  const machine::ErrorModel truth =
      Errors(machine, R"({"terms": [{"symbol": "EXX", "shape": "backlash", "amplitude": 5}]})");
  const auto sessions = identify::testing::Measure(machine, truth, {});
  auto problem = identify::MakeProblem(machine, *identify::BindSessions(machine, sessions));
  const identify::Point point = identify::StartingPoint(*problem, truth);
  EXPECT_TRUE(Proposer(*problem, point).Propose(truth.terms[0], {}).empty());
}

}  // namespace
}  // namespace axiscal::loop
