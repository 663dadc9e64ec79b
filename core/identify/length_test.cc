// Lengths and directions from session to errors: simulate, identify, compare with the truth.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/identify/identify.h"
#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"
#include "core/synthetic/simulate.h"

namespace axiscal::identify {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

const machine::Machine kMachine = machine::testing::MultiTasking();

session::Session Plan(const std::string& name, const std::string& instrument, double sigma_um,
                      const std::vector<session::HeaderEntry>& keys, double start_s) {
  session::Session session;
  session.header = {{"machine", "mt"},
                    {"session", name},
                    {"instrument", instrument},
                    {"sigma_um", absl::StrCat(sigma_um)},
                    {"tool_tip_mm", "0 0 -150"}};
  session.header.insert(session.header.end(), keys.begin(), keys.end());
  session.columns = {{"t_s", {start_s}, {}}};
  session.columns[0].values.clear();
  for (const machine::Axis& axis : kMachine.axes)
    session.columns.push_back({axis.name + (axis.kind == machine::AxisKind::kLinear ? "_mm" : "_deg"), {}, {}});
  return session;
}

void Go(double start_s, double x_mm, double y_mm, double z_mm, session::Session* session) {
  session->columns[0].values.push_back(start_s + 10.0 * static_cast<double>(session->columns[0].values.size()));
  for (size_t i = 1; i < session->columns.size(); ++i) {
    const std::string& name = session->columns[i].name;
    session->columns[i].values.push_back(name == "X_mm" ? x_mm : name == "Y_mm" ? y_mm : name == "Z_mm" ? z_mm : 0.0);
  }
}

// Along X there and back, `cycles` times.
session::Session AlongX(const std::string& name, const std::string& instrument, double sigma_um,
                        const std::vector<session::HeaderEntry>& keys, double start_s, int cycles = 3) {
  session::Session session = Plan(name, instrument, sigma_um, keys, start_s);
  for (int cycle = 0; cycle < cycles; ++cycle) {
    for (int i = -5; i <= 5; ++i) Go(start_s, 50.0 * i, 0, 0, &session);
    for (int i = 5; i >= -5; --i) Go(start_s, 50.0 * i, 0, 0, &session);
  }
  return session;
}

// A grid of the work space seen from an anchor.
session::Session Grid(const std::string& name, const std::string& anchor_mm, double start_s) {
  session::Session session =
      Plan(name, "length", 5.0, {{"anchor_mm", anchor_mm}, {"anchor_on", "bed"}, {"scale_sigma_um", "20"}}, start_s);
  for (const double x : {-200.0, -70.0, 70.0, 200.0})
    for (const double y : {-100.0, 0.0, 100.0})
      for (const double z : {0.0, 120.0, 240.0}) Go(start_s, x, y, z, &session);
  return session;
}

Result Fitted(const std::string& errors, const std::vector<session::Session>& planned, const std::string& asked,
              uint64_t seed) {
  const machine::ErrorModel truth = *machine::ReadErrors(errors, kMachine);
  std::vector<session::Session> measured;
  for (const session::Session& plan : planned) {
    synthetic::NoiseOptions noise;
    noise.seed = 100 * seed + measured.size();
    auto one = synthetic::Simulate(kMachine, truth, plan, noise);
    EXPECT_TRUE(one.ok()) << one.status();
    measured.push_back(*std::move(one));
  }
  Options options;
  options.model = *machine::ReadErrors(asked, kMachine);
  auto result = Identify(kMachine, measured, options);
  EXPECT_TRUE(result.ok()) << result.status();
  return result.ok() ? *std::move(result) : Result();
}

struct Expected {
  std::string name;
  double value;  // um, urad
};

void ExpectTruth(const Result& result, const std::vector<Expected>& truth) {
  EXPECT_LT(result.fit.chi2_per_dof, 1.5);
  EXPECT_GT(result.fit.chi2_per_dof, 0.6);
  for (const Expected& expected : truth) {
    bool found = false;
    for (const Estimate& estimate : result.estimates) {
      if (estimate.name != expected.name) continue;
      found = true;
      ASSERT_TRUE(estimate.identifiable) << estimate.name;
      EXPECT_NEAR(estimate.value / estimate.factor, expected.value, 3.0 * estimate.sigma / estimate.factor)
          << estimate.name;
    }
    EXPECT_TRUE(found) << expected.name;
  }
}

const char kLine[] = R"({"terms": [{"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 40},
    {"symbol": "EXX", "shape": "backlash", "variable": "X", "amplitude": 5},
    {"symbol": "EYX", "shape": "quadratic", "variable": "X", "amplitude": 8},
    {"symbol": "EBX", "shape": "quadratic", "variable": "X", "amplitude": 60}]})";

// An interferometer run both ways along X and across it, and a level on the tool.
std::vector<session::Session> LineSessions() {
  return {AlongX("positioning", "length", 0.3, {{"beam", "1 0 0"}}, 0.0),
          AlongX("straightness", "length", 0.5, {{"beam", "0 1 0"}}, 2000.0),
          AlongX("level", "direction", 1.0, {{"about", "0 1 0"}, {"reference", "bed"}}, 4000.0)};
}

TEST(Length, AnInterferometerAndALevelAlongX) {
  const Result result = Fitted(kLine, LineSessions(), kLine, 1);
  ExpectTruth(result, {{"EXX:linear", 40}, {"EXX:backlash", 5}, {"EYX:quadratic", 8}, {"EBX:quadratic", 60}});
  // The scale of the air is known to 1 um/m, and no reading tells it from the machine's.
  for (const Estimate& estimate : result.estimates) {
    if (estimate.name == "EXX:linear") {
      EXPECT_GT(estimate.sigma / estimate.factor, 0.9);
    }
  }
}

// Three anchors, each a session with a place of its own that is known to millimetres.
TEST(Length, ADrawWireFromThreeAnchors) {
  const std::string truth = R"({"EC0X": 300, "EA0Y": -200,
      "terms": [{"symbol": "EZZ", "shape": "linear", "variable": "Z", "amplitude": 400}]})";
  const Result result = Fitted(
      truth,
      {Grid("left", "-900 -700 -400", 0), Grid("right", "800 -900 300", 2000), Grid("back", "100 1100 -500", 4000)},
      truth, 2);
  ExpectTruth(result, {{"EC0X", 300}, {"EA0Y", -200}, {"EZZ:linear", 400}});
}

// One wire at three anchors has one scale error, drawn once for all of them.
std::vector<session::Session> OneWire(const std::string& serial) {
  std::vector<session::Session> grids = {Grid("left", "-900 -700 -400", 0), Grid("right", "800 -900 300", 2000),
                                         Grid("back", "100 1100 -500", 4000)};
  for (session::Session& grid : grids) {
    for (session::HeaderEntry& entry : grid.header)
      if (entry.key == "scale_sigma_um") entry.value = "100";
    if (!serial.empty()) grid.header.push_back({"serial", serial});
  }
  return grids;
}

// `fit_sigma_um`: of all but the last session, in place of what their plans state.
std::vector<session::Session> MeasuredWithOneWire(const std::string& truth, const std::string& serial, uint64_t seed,
                                                  const std::string& fit_sigma_um = "") {
  std::vector<session::Session> measured;
  std::vector<session::Session> plans = OneWire(serial);
  for (session::Session& plan : plans) {
    const bool is_last = &plan == &plans.back();
    for (session::HeaderEntry& entry : plan.header)
      if (entry.key == "sigma_um" && !is_last && !fit_sigma_um.empty()) entry.value = fit_sigma_um;
    synthetic::NoiseOptions noise;
    noise.seed = 100 * seed + measured.size();
    noise.stated_seed = seed;
    measured.push_back(synthetic::Simulate(kMachine, *machine::ReadErrors(truth, kMachine), plan, noise).value());
  }
  return measured;
}

const char kScaled[] = R"({"EC0X": 300, "terms": [
    {"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 200},
    {"symbol": "EYY", "shape": "linear", "variable": "Y", "amplitude": -100},
    {"symbol": "EZZ", "shape": "linear", "variable": "Z", "amplitude": 400}]})";

TEST(Length, OneScaleOfOneSerialNumberIsOneUnknown) {
  Options options;
  options.model = *machine::ReadErrors(kScaled, kMachine);
  const machine::ErrorModel truth = *options.model;
  const std::vector<Parameter> parameters = ListParameters(truth, false);
  std::vector<double> squares(parameters.size());
  constexpr int kRuns = 60;
  for (int run = 0; run < kRuns; ++run) {
    const auto fit =
        FitSessions(kMachine, MeasuredWithOneWire(kScaled, "WDS-10443", 50 + static_cast<uint64_t>(run)), options);
    ASSERT_TRUE(fit.ok()) << fit.status();
    ASSERT_LT(fit->result.fit.chi2_per_dof, 1.6);
    for (size_t i = 0; i < parameters.size(); ++i) {
      const Estimate& estimate = fit->result.estimates[i];
      ASSERT_TRUE(estimate.identifiable) << estimate.name;
      squares[i] += std::pow((estimate.value - ValueOf(truth, parameters[i])) / estimate.sigma, 2) / kRuns;
    }
    // One value, with one sigma, in all three sessions; a share of each length's sigma is that of the wire's.
    const std::vector<SessionFit>& sessions = fit->result.sessions;
    ASSERT_EQ(sessions.size(), 3u);
    for (const SessionFit& session : sessions) {
      ASSERT_EQ(session.setup.size(), 8u);
      EXPECT_EQ(session.setup.back().name, "scale");
      EXPECT_EQ(session.setup.back().value, sessions[0].setup.back().value);
      EXPECT_EQ(session.setup.back().sigma, sessions[0].setup.back().sigma);
    }
    EXPECT_NE(sessions[0].setup[0].value, sessions[1].setup[0].value);
    ASSERT_EQ(fit->result.stated.size(), 1u);
    EXPECT_EQ(fit->result.stated[0].of, "scale of instrument WDS-10443, +- 100 um/m");
    EXPECT_NEAR(std::abs(fit->result.stated[0].moved[1]) / fit->result.estimates[1].factor, 100.0, 5.0);
  }
  // Mean squares of 60 normal numbers scatter by sqrt(2 / 60) = 0.18.
  for (size_t i = 0; i < parameters.size(); ++i) {
    EXPECT_LT(squares[i], 1.0 + 4.0 * 0.18) << i;
    EXPECT_GT(squares[i], 1.0 - 4.0 * 0.18) << i;
  }
}

TEST(Length, SessionsOfOneSerialNumberStateOneSigma) {
  std::vector<session::Session> measured = MeasuredWithOneWire("{}", "WDS-10443", 1);
  for (session::HeaderEntry& entry : measured[1].header)
    if (entry.key == "scale_sigma_um") entry.value = "50";
  Options options;
  options.model = *machine::ReadErrors(kScaled, kMachine);
  EXPECT_EQ(Identify(kMachine, measured, options).status().message(),
            "sessions 'left' and 'right' are of one instrument, serial 'WDS-10443', whose scale_sigma_um is 100 and "
            "50, expected the same in both");
  // Two instruments may state what they like.
  for (session::HeaderEntry& entry : measured[1].header)
    if (entry.key == "serial") entry.value = "WDS-10444";
  EXPECT_TRUE(Identify(kMachine, measured, options).ok());
}

struct Checked {
  Fit fit, check;
};
// All sessions but the last are fitted, the last checks.
absl::StatusOr<Checked> CheckedByTheLast(std::vector<session::Session> measured) {
  const session::Session check = measured.back();
  measured.pop_back();
  Options options;
  options.model = *machine::ReadErrors(kScaled, kMachine);
  ASSIGN_OR_RETURN(Fit fit, FitSessions(kMachine, measured, options));
  ASSIGN_OR_RETURN(const auto runs, BindSessions(kMachine, {check}));
  ASSIGN_OR_RETURN(Fit checked, CheckRuns(kMachine, runs, fit, options));
  return Checked{std::move(fit), std::move(checked)};
}

// A session that checks was measured with the wire of the fit: its scale is the fit's.
TEST(Length, TheScaleOfTheFitIsThatOfASessionThatChecks) {
  const auto both = CheckedByTheLast(MeasuredWithOneWire(kScaled, "WDS-10443", 3));
  ASSERT_TRUE(both.ok()) << both.status();
  const SetupOffset& scale = both->check.result.sessions[0].setup.back();
  EXPECT_EQ(scale.value, both->fit.result.sessions[0].setup.back().value);
  EXPECT_EQ(scale.sigma, 0.0);
}

// It fits what that wire measured at a third anchor, where the first two leave no noise in the errors.
TEST(Length, WhatOneWireTellsHoldsAtAThirdAnchor) {
  constexpr int kRuns = 12;
  double chi2 = 0.0, freedom = 0.0;
  for (uint64_t seed = 1; seed <= kRuns; ++seed) {
    const auto both = CheckedByTheLast(MeasuredWithOneWire(kScaled, "WDS-10443", seed, "0.001"));
    ASSERT_TRUE(both.ok()) << both.status();
    // Fitted are the anchor and the length's zero.
    const double free = both->check.result.fit.readings - 4.0;
    chi2 += both->check.result.fit.chi2_per_dof * free;
    freedom += free;
  }
  // A chi-square has twice its degrees of freedom as variance.
  EXPECT_NEAR(chi2 / freedom, 1.0, 4.0 * std::sqrt(2.0 / freedom));
}

// Two halves of one run share beam, target and zero, wherever the middle of each stands: a step between them is the
// machine's.
TEST(Length, HalvesOfOneSetUpCountFromOneZero) {
  const std::string truth = R"({"terms": [{"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 100}]})";
  session::Session low =
      Plan("low", "length", 0.3, {{"beam", "1 0 0"}, {"setup", "one"}, {"scale_sigma_um", "5"}}, 0.0);
  session::Session high =
      Plan("high", "length", 0.3, {{"beam", "1 0 0"}, {"setup", "one"}, {"scale_sigma_um", "5"}}, 2000.0);
  for (int k = 0; k < 12; ++k) {
    Go(0.0, -250.0 + 0.01 * k, 0, 0, &low);  // each half stands: alone it tells nothing of a slope
    Go(2000.0, 250.0 + 0.01 * k, 0, 0, &high);
  }
  const machine::ErrorModel model = *machine::ReadErrors(truth, kMachine);
  std::vector<session::Session> measured;
  for (const session::Session& plan : {low, high}) {
    synthetic::NoiseOptions noise;
    noise.seed = 7 + measured.size();
    noise.setup_seed = 3;
    measured.push_back(*synthetic::Simulate(kMachine, model, plan, noise));
  }
  Options options;
  options.model = model;
  const auto result = Identify(kMachine, measured, options);
  ASSERT_TRUE(result.ok()) << result.status();
  ExpectTruth(*result, {{"EXX:linear", 100}});
  measured[1].header[5].value = "0 1 0";
  EXPECT_THAT(std::string(Identify(kMachine, measured, options).status().message()),
              HasSubstr("share the setup 'one' but not anchor or beam"));
}

// A beam along X sees a shift of the tool only as its zero.
TEST(Length, WhatNoReadingTellsHasNoNumber) {
  const Result result = Fitted("{}", {LineSessions()[0]}, R"({"EX0T": 0,
      "terms": [{"symbol": "EXX", "shape": "backlash", "variable": "X", "amplitude": 0}]})",
                               3);
  ASSERT_EQ(result.estimates.size(), 2u);
  EXPECT_FALSE(result.estimates[0].identifiable);
  EXPECT_TRUE(result.estimates[1].identifiable);
  EXPECT_FALSE(result.not_separable.empty());
}

TEST(Length, IntervalsHoldTheTruth) {
  constexpr int kRuns = 120;
  const std::vector<Expected> truth = {
      {"EXX:linear", 40}, {"EXX:backlash", 5}, {"EYX:quadratic", 8}, {"EBX:quadratic", 60}};
  int held = 0, all = 0;
  for (int run = 0; run < kRuns; ++run) {
    const Result result = Fitted(kLine, LineSessions(), kLine, 1000 + static_cast<uint64_t>(run));
    for (const Expected& expected : truth) {
      for (const Estimate& estimate : result.estimates) {
        if (estimate.name != expected.name || !estimate.identifiable) continue;
        ++all;
        held += std::abs(estimate.value / estimate.factor - expected.value) <=
                result.coverage_factor * estimate.sigma / estimate.factor;
      }
    }
  }
  EXPECT_EQ(all, kRuns * static_cast<int>(truth.size()));
  // 0.95 +- 3 sqrt(0.95 * 0.05 / 480)
  EXPECT_NEAR(static_cast<double>(held) / all, 0.95, 0.03);
}

}  // namespace
}  // namespace axiscal::identify
