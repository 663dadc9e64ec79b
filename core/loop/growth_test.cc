#include "core/loop/growth.h"

#include <gtest/gtest.h>

#include <set>

#include "core/identify/testing/scenario.h"
#include "core/loop/fitting.h"
#include "core/plan/session_builder.h"

namespace axiscal::loop {
namespace {

using ballbar::Pattern;

// What grows out of `effects`, which somebody put there.
Attempt Grown(const machine::Machine& machine, const std::vector<instruments::MeasuringRun>& runs,
              const std::vector<Added>& effects) {
  Way way;
  way.most_effects = 3;
  Attempt attempt{Extension(machine, runs), way, {}, {}, false, false, {}};
  attempt.extension.effects = effects;
  const Options options;
  const identify::Options identify_options;
  absl::StatusOr<identify::Fit> fit = FitExtension(machine, attempt.extension, identify_options);
  EXPECT_TRUE(fit.ok()) << fit.status();
  if (!fit.ok()) return attempt;
  EXPECT_TRUE(Growth(machine, options, identify_options, &attempt).Extend(&*fit).ok());
  return attempt;
}

// Fitted beside effects that were dropped later, a spike may have become what its amplitude and length only make up.
TEST(Growth, ASpikeThatOutlastsTheTravelIsABacklash) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const machine::ErrorModel truth =
      identify::testing::Errors(machine, R"({"terms": [{"symbol": "EYY", "shape": "backlash", "amplitude": 0.5}]})");
  const auto runs = identify::BindSessions(machine, identify::testing::Measure(machine, truth, {},
                                                                               {{"CR", Pattern::kCR, 356.4},
                                                                                {"CA", Pattern::kCA, 356.4},
                                                                                {"CT", Pattern::kCT, 356.4},
                                                                                {"BY", Pattern::kBY, 356.4}}));
  ASSERT_TRUE(runs.ok()) << runs.status();
  const machine::ErrorTerm backlash = truth.terms[0];
  machine::ErrorTerm spike = backlash;
  constexpr double kLengthMm = 3000.0;
  spike.shape = shapes::Reversal{*shapes::VariableAxis(backlash.shape), kLengthMm};
  spike.amplitude = {0.5 * backlash.amplitude[0], 0.0};

  const Attempt attempt = Grown(machine, *runs, {{{Family::kReversal, spike}, 100.0, {}, {}}});
  ASSERT_EQ(attempt.extension.effects.size(), 1u);
  EXPECT_EQ(attempt.extension.NameOf(0), "EYY:backlash");
}

// What names found later explain was no slip.
TEST(Growth, ASlipThatExplainsNothingIsDropped) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const machine::ErrorModel truth =
      identify::testing::Errors(machine, R"({"terms": [{"symbol": "EXX", "shape": "backlash", "amplitude": 4}]})");
  const auto runs = identify::BindSessions(machine, identify::testing::Measure(machine, truth, {}));
  ASSERT_TRUE(runs.ok()) << runs.status();
  constexpr int kRun = 2, kMoment = 120;
  const Attempt attempt = Grown(machine, *runs, {{{Family::kStep, {}, kRun, kMoment, kMoment, kMoment}, 30.0, {}, {}}});
  ASSERT_EQ(attempt.extension.effects.size(), 1u);
  EXPECT_EQ(attempt.extension.NameOf(0), "EXX:backlash");
  EXPECT_TRUE(std::any_of(attempt.report.steps.begin(), attempt.report.steps.end(), [](const SelectionStep& step) {
    return step.change == SelectionStep::kDropped && step.name == "a slip in session CR";
  }));
}

// The tool point stands in one place to the table: a tilt that turns with the sense of C is a shift along Y and one
// along Z, each of which is worth little beside the other.
TEST(Growth, OneEffectTakesThePlaceOfTwo) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const machine::ErrorModel truth =
      identify::testing::Errors(machine, R"({"terms": [{"symbol": "EAC", "shape": "backlash", "amplitude": 30}]})");
  const auto runs = identify::BindSessions(
      machine,
      identify::testing::Measure(
          machine, truth, {}, {{"CR", Pattern::kCR, 356.4}, {"CA", Pattern::kCA, 356.4}, {"CT", Pattern::kCT, 356.4}}));
  ASSERT_TRUE(runs.ok()) << runs.status();
  std::vector<Added> parts;
  for (const machine::Component component : {machine::Component::kY, machine::Component::kZ}) {
    machine::ErrorTerm part = truth.terms[0];
    part.component = component;
    part.amplitude = {0.001, 0.0};
    parts.push_back({{Family::kBacklash, part}, 1e9, {}, {}});
  }
  const Attempt attempt = Grown(machine, *runs, parts);
  ASSERT_EQ(attempt.extension.effects.size(), 1u);
  EXPECT_EQ(attempt.extension.NameOf(0), "EAC:backlash");
}

// A ball measured by R-test in poses that follow no line: neighbours say nothing of each other.
session::Session Poses(const machine::Machine& machine, const machine::ErrorModel& truth, const std::string& name,
                       int count, uint64_t seed) {
  const plan::Situation situation = plan::SituationOf(machine, {});
  plan::SessionBuilder builder(situation, name, {0, 0, -150}, {80, 30, -400});
  for (int k = 0; k < count; ++k) {
    std::vector<double> positions(machine.axis_count(), 0.0);
    positions[machine::FindAxis(machine, "B")] = ((k * 7) % 5 - 2) * 0.2;
    positions[machine::FindAxis(machine, "C")] = ((k * 11) % 12 - 6) * 0.5;
    builder.Add(positions, Eigen::Vector3d::Zero());
  }
  synthetic::NoiseOptions noise;
  noise.seed = seed;
  return synthetic::Simulate(machine, truth, builder.Finish(), noise).value();
}

TEST(Growth, ASlipInTheMiddleOfAShortSessionIsGivenItsMoment) {
  const machine::Machine machine = machine::testing::MultiTasking();
  constexpr int kCount = 30, kSlipped = 15;
  std::vector<session::Session> sessions = {Poses(machine, {}, "R1", kCount, 3), Poses(machine, {}, "R2", kCount, 4)};
  const double by_mm[] = {0.02, -0.015, 0.01};
  for (int k = kSlipped; k < kCount; ++k)
    for (size_t row = 0; row < 3; ++row) (sessions[1].columns.end() - 3 + row)->values[k] += by_mm[row];
  const auto runs = identify::BindSessions(machine, sessions);
  ASSERT_TRUE(runs.ok()) << runs.status();
  const Report report = CloseLoop(machine, *runs, {}).value();
  EXPECT_TRUE(report.effects.empty());
  EXPECT_TRUE(report.fitted.outliers.empty());
  ASSERT_EQ(report.unexplained.size(), 1u);
  EXPECT_EQ(report.unexplained[0].kind, Unexplained::kSlip);
  EXPECT_EQ(report.unexplained[0].session, "R2");
  const std::vector<double>& times_s = session::FindColumn(sessions[1], "t_s")->values;
  EXPECT_EQ(report.unexplained[0].from, times_s[kSlipped - 1]);
  EXPECT_EQ(report.unexplained[0].to, times_s[kSlipped]);
}

class LastReadings : public testing::TestWithParam<int> {};

// Among readings that an effect moves about a bad one at an end does not stand out of its neighbours, and what moved
// the last reading alone might have slipped.
TEST_P(LastReadings, AreBadAndDidNotSlip) {
  machine::Machine machine = machine::testing::MultiTasking();
  const machine::ErrorModel truth = identify::testing::Errors(machine, R"({"terms": [
      {"symbol": "EXC", "shape": "harmonic", "order": 2, "amplitude": 12, "phase_deg": 40},
      {"symbol": "EZC", "shape": "harmonic", "order": 3, "amplitude": 9, "phase_deg": 10}]})");
  constexpr int kCount = 30;
  std::vector<session::Session> sessions = {Poses(machine, truth, "R1", kCount, 3),
                                            Poses(machine, truth, "R2", kCount, 4)};
  const int bad = GetParam();
  const double off_mm[] = {-0.073, -0.049, -0.061};  // no two as what slipped would read
  for (int k = kCount - bad; k < kCount; ++k) sessions[1].columns.back().values[k] += off_mm[k + bad - kCount];
  const auto runs = identify::BindSessions(machine, sessions);
  ASSERT_TRUE(runs.ok()) << runs.status();
  const Report report = CloseLoop(machine, *runs, {}).value();
  EXPECT_TRUE(report.unexplained.empty());
  EXPECT_EQ(report.effects.size(), 2u);
  std::set<int> listed;
  for (const identify::Outlier& outlier : report.fitted.outliers) {
    EXPECT_EQ(outlier.session, "R2");
    listed.insert(outlier.row);
  }
  std::set<int> expected;
  for (int k = kCount - bad; k < kCount; ++k) expected.insert(k + 1);
  EXPECT_EQ(listed, expected);
}

INSTANTIATE_TEST_SUITE_P(Counts, LastReadings, testing::Values(1, 2, 3));

}  // namespace
}  // namespace axiscal::loop
