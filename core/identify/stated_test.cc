// Warmth and certificates from session to errors: corrected to 20 deg C, with what they leave uncertain in the budget.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/identify/identify.h"
#include "core/identify/monte_carlo.h"
#include "core/identify/report.h"
#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"
#include "core/reports/identification.h"
#include "core/synthetic/simulate.h"

namespace axiscal::identify {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

const machine::Machine kStatedMachine = machine::testing::MultiTasking();

constexpr char kScales[] = R"({"terms": [{"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 40},
    {"symbol": "EYY", "shape": "linear", "variable": "Y", "amplitude": -25}]})";
constexpr char kOneScale[] = R"({"terms": [{"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 40}]})";

session::Session Empty(const std::string& name, const std::string& instrument, double sigma_um,
                       const std::vector<session::HeaderEntry>& keys) {
  session::Session session;
  session.header = {{"machine", "mt"},
                    {"session", name},
                    {"instrument", instrument},
                    {"sigma_um", absl::StrCat(sigma_um)},
                    {"tool_tip_mm", "0 0 -150"}};
  session.header.insert(session.header.end(), keys.begin(), keys.end());
  for (const machine::Axis& axis : kStatedMachine.axes)
    session.columns.push_back({axis.name + (axis.kind == machine::AxisKind::kLinear ? "_mm" : "_deg"), {}, {}});
  session.columns.push_back({"temp_C", {}, {}});
  return session;
}

void AddRow(double x_mm, double y_mm, double celsius, session::Session* session) {
  for (session::Column& column : session->columns)
    column.values.push_back(column.name == "X_mm"     ? x_mm
                            : column.name == "Y_mm"   ? y_mm
                            : column.name == "temp_C" ? celsius
                                                      : 0.0);
}

// A comparator along X at 30 deg C.
session::Session Comparator(const std::string& name, const std::vector<session::HeaderEntry>& keys,
                            double celsius = 30.0) {
  session::Session session = Empty(name, "length", 0.3, {{"beam", "1 0 0"}});
  session.header.insert(session.header.end(), keys.begin(), keys.end());
  for (int i = 0; i <= 20; ++i) AddRow(-250.0 + 25.0 * i, 0.0, celsius, &session);
  return session;
}

// A ball bar once round in XY while the shop warms up.
session::Session WarmCircle(const std::string& name, const std::vector<session::HeaderEntry>& keys) {
  session::Session session = Empty(name, "ballbar", 0.3, {{"table_ball_mm", "0 0 -150"}, {"bar_length_mm", "150"}});
  session.header.insert(session.header.end(), keys.begin(), keys.end());
  constexpr int kReadings = 180;
  for (int i = 0; i < kReadings; ++i) {
    const double t = 2.0 * std::numbers::pi * i / kReadings;
    AddRow(150.0 * std::cos(t), 150.0 * std::sin(t), 26.0 + 4.0 * i / kReadings, &session);
  }
  return session;
}

std::vector<session::Session> Measured(const std::vector<session::Session>& planned, const std::string& errors,
                                       uint64_t seed, bool is_as_stated) {
  std::vector<session::Session> measured;
  for (const session::Session& plan : planned) {
    synthetic::NoiseOptions noise;
    noise.seed = 100 * seed + measured.size();
    if (!is_as_stated) noise.stated_seed = seed;
    auto one = synthetic::Simulate(kStatedMachine, *machine::ReadErrors(errors, kStatedMachine), plan, noise);
    EXPECT_TRUE(one.ok()) << one.status();
    measured.push_back(*std::move(one));
  }
  return measured;
}

Fit FitOf(const std::vector<session::Session>& planned, const std::string& errors, uint64_t seed,
          bool is_as_stated = false) {
  Options options;
  options.model = *machine::ReadErrors(errors, kStatedMachine);
  auto fit = FitSessions(kStatedMachine, Measured(planned, errors, seed, is_as_stated), options);
  EXPECT_TRUE(fit.ok()) << fit.status();
  return fit.ok() ? *std::move(fit) : Fit();
}

// 1 um/(m K) of a coefficient at 10 K is 10 um/m of the machine's scale, beside the 1 um/m of the instrument's own; a
// thermometer that is off by 0.2 K is 11.5 x 0.2 = 2.3 um/m.
TEST(Stated, TheCoefficientIsInTheBudgetAsByHand) {
  const Fit fit = FitOf({Comparator("a", {{"expansion instrument", "11.5 1"}, {"temperature_sigma_K", "0.2"}})},
                        kOneScale, 1, /*is_as_stated=*/true);
  const Estimate& scale = fit.result.estimates[0];
  ASSERT_TRUE(scale.identifiable);
  ASSERT_THAT(fit.result.stated, SizeIs(2));
  // The weak prior of the beam's tilt takes up nothing of it; the instrument's scale of 1 um/m a hundredth.
  EXPECT_NEAR(std::abs(fit.result.stated[0].moved[0]) / scale.factor, 10.0, 0.01);
  EXPECT_NEAR(std::abs(fit.result.stated[1].moved[0]) / scale.factor, 2.3, 0.01);
  EXPECT_NEAR(scale.sigma / scale.factor, std::sqrt(10.0 * 10.0 + 2.3 * 2.3 + 1.0), 0.1);
  EXPECT_NEAR(scale.value / scale.factor, 40.0, 3.0);  // as stated: the instrument's scale and the noise alone
  const std::string json = reports::ToJson(ReportOf(fit.result));
  const auto read = reports::ReadIdentification(json);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_THAT(read->fitted.stated, SizeIs(2));
  EXPECT_EQ(read->fitted.stated[0].of, "expansion of instrument, 11.5 +- 1 um/(m K)");
  EXPECT_NEAR(std::abs(read->fitted.stated[0].moves[0].second), 10.0, 0.01);
}

// One coefficient is off by the same in all sessions that state it: measuring again makes it no better known. Two are
// independent.
TEST(Stated, OneFactIsOneErrorInAllSessions) {
  const std::vector<session::HeaderEntry> one = {{"expansion instrument", "11.5 1"}};
  const std::vector<session::HeaderEntry> other = {{"expansion instrument", "11.6 1"}};
  const auto sigma = [&](const std::vector<session::HeaderEntry>& of_b) {
    const Fit fit = FitOf({Comparator("a", one), Comparator("b", of_b)}, kOneScale, 2, true);
    return fit.result.estimates[0].sigma / fit.result.estimates[0].factor;
  };
  EXPECT_NEAR(sigma(one), std::sqrt(100.0 + 0.5), 0.1);
  EXPECT_NEAR(sigma(other), std::sqrt(50.0 + 0.5), 0.1);
}

// A steel comparator of 11.5 um/(m K) at 30 deg C counts 115 um/m too little. Where nobody says so that is an error of
// the machine.
TEST(Stated, WhatIsNotStatedIsTakenForTheMachine) {
  std::vector<session::Session> measured =
      Measured({Comparator("a", {{"expansion instrument", "11.5 0"}})}, kOneScale, 3, true);
  Options options;
  options.model = *machine::ReadErrors(kOneScale, kStatedMachine);
  const auto with = Identify(kStatedMachine, measured, options);
  std::erase_if(measured[0].header, [](const auto& entry) { return entry.key == "expansion instrument"; });
  const auto without = Identify(kStatedMachine, measured, options);
  ASSERT_TRUE(with.ok() && without.ok());
  const double factor = with->estimates[0].factor;
  EXPECT_NEAR(with->estimates[0].value / factor, 40.0, 3.0);
  EXPECT_NEAR((without->estimates[0].value - with->estimates[0].value) / factor, -115.0, 0.1);
}

std::vector<session::Session> Circles() {
  const std::vector<session::HeaderEntry> keys = {
      {"expansion bar", "11.5 1"},
      {"temperature_sigma_K", "0.3"},
      {"certificate bar_length", "4711 due 2027-01-31 value 150.0112 mm U 0.8 um k 2"},
      {"started", "2026-06-01T08:00:00Z"}};
  return {WarmCircle("one", keys), WarmCircle("two", keys), WarmCircle("three", keys)};
}

// The bar's length is known to 0.4 um: 2.7 um/m of both scales, however often it is measured. Mean warmth 8 K: 8 um/m.
TEST(Stated, ABarWithACertificateTellsScales) {
  const Fit fit = FitOf(Circles(), kScales, 4);
  for (const Estimate& estimate : fit.result.estimates) {
    ASSERT_TRUE(estimate.identifiable) << estimate.name;
    const double truth = estimate.name == "EXX:linear" ? 40.0 : -25.0;
    EXPECT_NEAR(estimate.value / estimate.factor, truth, 3.0 * estimate.sigma / estimate.factor) << estimate.name;
    const double by_hand = std::sqrt(8.0 * 8.0 + 2.667 * 2.667 + 3.45 * 3.45);
    EXPECT_NEAR(estimate.sigma / estimate.factor, by_hand, 0.1 * by_hand) << estimate.name;
  }
  for (const SetupOffset& offset : fit.result.sessions[0].setup) {
    if (offset.name != "bar_length") continue;
    EXPECT_EQ(offset.value, 0.0);
    EXPECT_NEAR(offset.sigma, 0.4e-3, 1e-9);
  }
  EXPECT_THAT(fit.result.warnings, Not(Contains(::testing::VariantWith<reports::Expired>(::testing::_))));
}

TEST(Stated, IntervalsHoldTheTruth) {
  constexpr int kRuns = 400;
  int held = 0, all = 0;
  for (int run = 0; run < kRuns; ++run) {
    const Fit fit = FitOf(Circles(), kScales, 1000 + static_cast<uint64_t>(run));
    // EXX and EYY are off together by the bar: only their difference is a second draw.
    const Estimate& estimate = fit.result.estimates[0];
    ASSERT_TRUE(estimate.identifiable);
    ++all;
    held += std::abs(estimate.value / estimate.factor - 40.0) <=
            fit.result.coverage_factor * estimate.sigma / estimate.factor;
  }
  // 0.95 +- 3 sqrt(0.95 * 0.05 / 400)
  EXPECT_NEAR(static_cast<double>(held) / all, 0.95, 0.033);
}

TEST(Stated, MonteCarloDrawsWhatIsStated) {
  const Fit fit = FitOf(Circles(), kScales, 5);
  MonteCarloOptions options;
  options.runs = 400;
  options.seed = 3;
  const auto drawn = MonteCarlo(fit, options);
  ASSERT_TRUE(drawn.ok()) << drawn.status();
  for (const Spread& spread : drawn->spreads)
    EXPECT_NEAR(spread.sigma, spread.linear_sigma, 0.12 * spread.linear_sigma) << spread.name;  // 3 / sqrt(2 * 400)
}

TEST(Stated, ExpiredCertificatesAreSaid) {
  std::vector<session::Session> planned = Circles();
  planned.resize(2);
  for (session::HeaderEntry& entry : planned[0].header)
    if (entry.key == "started") entry.value = "2027-02-01T00:00:00Z";
  std::erase_if(planned[1].header, [](const auto& entry) { return entry.key == "started"; });
  const Fit fit = FitOf(planned, kScales, 6);
  std::vector<std::string> texts;
  for (const reports::WarningFacts& facts : fit.result.warnings) {
    const reports::Warning warning = reports::InWords(facts);
    if (warning.kind == reports::WarningKind::kCertificate) texts.push_back(warning.text);
  }
  EXPECT_THAT(texts, ElementsAre(HasSubstr("session one: certificate 4711 of bar_length is valid until 2027-01-31 and "
                                           "was expired when the session began on 2027-02-01"),
                                 HasSubstr("session two: certificate 4711 of bar_length is valid until 2027-01-31, and "
                                           "no '# started: ...' says")));
}

}  // namespace
}  // namespace axiscal::identify
