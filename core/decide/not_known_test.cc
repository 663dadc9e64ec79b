// What the sessions do not tell is said.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "core/decide/close_loop.h"
#include "core/identify/testing/scenario.h"
#include "core/plan/session_builder.h"

namespace axiscal::decide {
namespace {

using loop::Effect;
using loop::Report;
using loop::Unexplained;
using loop::Verdict;

using ballbar::Pattern;
using identify::testing::Errors;
using identify::testing::Measure;
using identify::testing::Measured;
using machine::Machine;
using testing::Contains;
using testing::Not;

Machine Declaring(const std::vector<std::string>& symbols) {
  Machine machine = machine::testing::MultiTasking();
  machine.declared.clear();
  for (const std::string& symbol : symbols) machine.declared.push_back(*machine::ParseErrorSymbol(symbol));
  return machine;
}

Report Close(const Machine& machine, const std::vector<session::Session>& fit,
             const std::vector<session::Session>& check = {}) {
  return CloseLoop(machine, *identify::BindSessions(machine, fit), *identify::BindSessions(machine, check)).value();
}

std::vector<std::string> NamesOf(const Machine& machine, const std::vector<machine::ErrorTerm>& terms) {
  std::vector<std::string> names;
  for (const machine::ErrorTerm& term : terms) names.push_back(machine::NameOf(machine, term));
  return names;
}

// Everything that the report says an effect may be.
std::vector<std::string> ClassOf(const Machine& machine, const Effect& effect) {
  std::vector<std::string> names = NamesOf(machine, effect.equivalent);
  names.push_back(machine::NameOf(machine, effect.term));
  return names;
}

// A table ball that turns with C stands where it stands: what Y lifts while it follows is the tilt of C.
TEST(NotKnown, AnEffectThatNoReadingShowsIsListedAsNotVisible) {
  const Machine machine = Declaring({"EX0C", "EY0C", "EA0C", "EB0C", "EZ0T"});
  const auto sessions = Measure(machine, Errors(machine, R"({"terms": [
      {"symbol": "EZY", "shape": "linear", "amplitude": 80}]})"),
                                {}, {{"CR", Pattern::kCR, 356.4}, {"CA", Pattern::kCA, 356.4}});
  const Report report = Close(machine, sessions);
  EXPECT_EQ(report.verdict, Verdict::kAdequate);
  EXPECT_TRUE(report.effects.empty());
  EXPECT_THAT(NamesOf(machine, report.not_visible), Contains("EZY:linear"));
  EXPECT_THAT(NamesOf(machine, report.not_visible), Not(Contains("ECC:backlash")));
}

TEST(NotKnown, WhatOnlyACheckSessionShowsIsNamedAndTheCheckIsGone) {
  const Machine machine = Declaring({"EX0C", "EY0C", "EA0C", "EB0C", "EZ0T"});
  const machine::ErrorModel truth =
      Errors(machine, R"({"EX0C": 20, "terms": [{"symbol": "EBB", "shape": "backlash", "amplitude": 40}]})");
  const auto fit = Measure(machine, truth, {}, {{"CR", Pattern::kCR, 356.4}, {"CA", Pattern::kCA, 356.4}});
  const auto check = Measure(machine, truth, {}, {{"CT", Pattern::kCT, 356.4}, {"BX", Pattern::kBX, 356.4}});
  const Report report = Close(machine, fit, check);
  ASSERT_EQ(report.effects.size(), 1u);
  EXPECT_THAT(ClassOf(machine, report.effects[0]), Contains("EBB:backlash"));
  EXPECT_TRUE(report.is_check_fitted);
  EXPECT_EQ(report.fitted.sessions.size(), 4u);
  EXPECT_EQ(report.verdict, Verdict::kExtended);
}

TEST(NotKnown, SessionsMayBeCalledAsFittedCheckSessionsAre) {
  const Machine machine = Declaring({"EX0C", "EY0C", "EA0C", "EB0C", "EZ0T"});
  const machine::ErrorModel truth =
      Errors(machine, R"({"EX0C": 20, "terms": [{"symbol": "EBB", "shape": "backlash", "amplitude": 40}]})");
  const auto fit = Measure(machine, truth, {}, {{"CR", Pattern::kCR, 356.4}, {"check CR", Pattern::kCA, 356.4}});
  const auto check = Measure(machine, truth, {}, {{"CR", Pattern::kCT, 356.4}, {"BX", Pattern::kBX, 356.4}});
  const Report report = Close(machine, fit, check);
  ASSERT_EQ(report.effects.size(), 1u);
  EXPECT_THAT(ClassOf(machine, report.effects[0]), Contains("EBB:backlash"));
  EXPECT_TRUE(report.is_check_fitted);
}

// Readings that scatter as those of the instrument never did: no model explains them.
TEST(NotKnown, ACheckSessionThatNothingExplainsIsNamedSo) {
  const Machine machine = Declaring({"EX0C", "EY0C", "EA0C", "EB0C", "EZ0T"});
  const machine::ErrorModel truth = Errors(machine, R"({"EX0C": 20})");
  const auto fit = Measure(machine, truth, {}, {{"CR", Pattern::kCR, 356.4}, {"CA", Pattern::kCA, 356.4}});
  auto check = Measure(machine, truth, {}, {{"CT", Pattern::kCT, 356.4}, {"CR2", Pattern::kCR, 300.0}});
  std::vector<double>& readings = check[1].columns.back().values;
  ASSERT_EQ(readings.size(), static_cast<size_t>(check[1].reading_count()));
  std::mt19937 random(7);
  std::normal_distribution<double> scatter(0.0, 0.002);
  for (double& reading : readings) reading += scatter(random);
  const Report report = Close(machine, fit, check);
  EXPECT_TRUE(report.effects.empty());
  EXPECT_FALSE(report.is_check_fitted);
  EXPECT_THAT(report.axes_at_rest, Contains("B"));
  EXPECT_EQ(report.verdict, Verdict::kUnexplained);
  ASSERT_EQ(report.unexplained.size(), 1u);
  EXPECT_EQ(report.unexplained[0].kind, Unexplained::kCheckSession);
  EXPECT_EQ(report.unexplained[0].session, "CR2");
  EXPECT_NEAR(report.unexplained[0].rms_mm, 0.002, 0.0005);
}

// A broken probe or a loose ball is not a model that is adequate.
TEST(NotKnown, AFittedSessionThatScattersByMoreThanNoiseMayIsNamed) {
  const Machine machine = Declaring({"EX0C", "EY0C", "EA0C", "EB0C", "EZ0T"});
  const machine::ErrorModel truth = Errors(machine, R"({"EX0C": 20})");
  const auto closed = [&](double scatter_mm) {
    auto fit = Measure(machine, truth, {}, {{"CR", Pattern::kCR, 356.4}, {"CA", Pattern::kCA, 356.4}});
    std::mt19937 random(7);
    std::normal_distribution<double> scatter(0.0, scatter_mm);
    for (double& reading : fit[1].columns.back().values) reading += scatter(random);
    return Close(machine, fit);
  };
  EXPECT_EQ(closed(0.0006).verdict, Verdict::kAdequate);  // the instrument states 0.3 um
  const Report report = closed(0.005);
  EXPECT_TRUE(report.effects.empty());
  EXPECT_EQ(report.verdict, Verdict::kUnexplained);
  ASSERT_EQ(report.unexplained.size(), 1u);
  EXPECT_EQ(report.unexplained[0].kind, Unexplained::kScatter);
  EXPECT_EQ(report.unexplained[0].session, "CA");
  EXPECT_NEAR(report.unexplained[0].rms_mm, 0.005, 0.0005);
}

TEST(NotKnown, AnEffectThatOneSessionAloneShowsIsFound) {
  const Machine machine = Declaring({"EX0C", "EY0C", "EA0C", "EB0C", "EZ0T"});
  const machine::ErrorModel truth =
      Errors(machine, R"({"EX0C": 20, "terms": [{"symbol": "EBB", "shape": "backlash", "amplitude": 40}]})");
  const Report report =
      Close(machine, Measure(machine, truth, {},
                             {{"CR", Pattern::kCR, 356.4}, {"CA", Pattern::kCA, 356.4}, {"BX", Pattern::kBX, 356.4}}));
  ASSERT_EQ(report.effects.size(), 1u);
  EXPECT_THAT(ClassOf(machine, report.effects[0]), Contains("EBB:backlash"));
}

// Circles in the XY plane by ball bar, counter-clockwise and, where asked, clockwise.
std::vector<session::Session> Circles(const Machine& machine, const machine::ErrorModel& truth, bool both_senses) {
  const plan::Situation situation = plan::SituationOf(machine, {});
  constexpr double kBarMm = 100.0, kStep = std::numbers::pi / 90.0;
  std::vector<session::Session> sessions;
  for (const double sense : {1.0, -1.0}) {
    if (sense < 0.0 && !both_senses) break;
    plan::SessionBuilder builder(situation, sense > 0.0 ? "ccw" : "cw", {0, 0, -150}, {50, 30, -400}, kBarMm);
    for (int k = -10; k <= 190; ++k) {
      const double angle = sense * k * kStep;
      builder.AddInBed(std::vector<double>(machine.axis_count(), 0.0),
                       kBarMm * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0));
    }
    synthetic::NoiseOptions noise;
    noise.seed = sense > 0.0 ? 5 : 6;
    sessions.push_back(synthetic::Simulate(machine, truth, builder.Finish(), noise).value());
  }
  return sessions;
}

// One way round, axes that lag by different times trace the ellipse of axes out of square (ISO 230-4). X stands on Y
// here: EC0X is what they are out of square by.
TEST(NotKnown, SquarenessLooksLikeServoMismatchUntilTheOtherSenseIsRun) {
  const Machine machine = Declaring({});
  const machine::ErrorModel truth = Errors(machine, R"({"EC0X": 30})");
  const Report one_way = Close(machine, Circles(machine, truth, false));
  ASSERT_EQ(one_way.effects.size(), 1u);
  const std::vector<std::string> alike = ClassOf(machine, one_way.effects[0]);
  EXPECT_THAT(alike, Contains("EC0X"));
  EXPECT_THAT(alike, Contains(testing::HasSubstr(":lag")));
  const Report both = Close(machine, Circles(machine, truth, true));
  ASSERT_EQ(both.effects.size(), 1u);
  EXPECT_THAT(ClassOf(machine, both.effects[0]), Contains("EC0X"));
  EXPECT_THAT(ClassOf(machine, both.effects[0]), Not(Contains(testing::HasSubstr(":lag"))));
}

// A shift of the table is the ball's. What is left of it are rounding and the curvature of the bar: it takes nothing
// up that it would have to be metres for.
TEST(NotKnown, ADeclaredErrorThatHardlyShowsHidesNoEffect) {
  using machine::testing::kX, machine::testing::kY, machine::testing::kZ;
  using machine::testing::Linear, machine::testing::Rotary;
  const Machine machine =
      machine::testing::Make("tt", {Linear("Y", kY), Linear("Z", kZ), Linear("X", kX)},
                             {Rotary("B", -kY, {30, 0, -80}), Rotary("C", -kZ, {30, 10, 0})}, {"EX0C", "EA0Z", "EB0Z"});
  const machine::ErrorModel truth = Errors(
      machine,
      R"({"EX0C": 30, "EA0Z": 60, "EB0Z": -70, "terms": [{"symbol": "EBY", "shape": "linear", "amplitude": -294}]})");
  const plan::Situation situation = plan::SituationOf(machine, {});
  constexpr double kBarMm = 150.0;
  std::vector<session::Session> sessions;
  for (int plane = 0; plane < 3; ++plane) {
    plan::SessionBuilder builder(situation, absl::StrCat("plane-", plane), {0, 0, -150}, {0, 0, 50}, kBarMm);
    for (int deg = 0; deg <= 360; ++deg) {
      Eigen::Vector3d bar_mm = Eigen::Vector3d::Zero();
      bar_mm[plane] = kBarMm * std::cos(deg * std::numbers::pi / 180.0);
      bar_mm[(plane + 1) % 3] = kBarMm * std::sin(deg * std::numbers::pi / 180.0);
      builder.AddInBed(std::vector<double>(machine.axis_count(), 0.0), bar_mm);
    }
    synthetic::NoiseOptions noise;
    noise.seed = 5 + plane;
    noise.resolution_mm = 1e-4;
    sessions.push_back(synthetic::Simulate(machine, truth, builder.Finish(), noise).value());
  }
  const Report report = Close(machine, sessions);
  ASSERT_EQ(report.effects.size(), 1u);
  EXPECT_THAT(ClassOf(machine, report.effects[0]), Contains("EC0X"));
}

// Backlash of an axis that turns one way only is a constant; with both senses it is itself.
TEST(NotKnown, BacklashNeedsBothSenses) {
  const Machine machine = Declaring({"EX0C", "EY0C", "EA0C", "EB0C", "EZ0T"});
  const machine::ErrorModel truth =
      Errors(machine, R"({"terms": [{"symbol": "ECC", "shape": "backlash", "amplitude": 60}]})");
  const std::vector<Measured> patterns = {{"CR", Pattern::kCR, 356.4}, {"CT", Pattern::kCT, 356.4}};
  ballbar::PatternOptions options;
  options.both_senses = false;
  EXPECT_TRUE(Close(machine, Measure(machine, truth, {}, patterns, options)).effects.empty());
  const Report both = Close(machine, Measure(machine, truth, {}, patterns));
  ASSERT_EQ(both.effects.size(), 1u);
  EXPECT_THAT(ClassOf(machine, both.effects[0]), Contains("ECC:backlash"));
}

}  // namespace
}  // namespace axiscal::decide
