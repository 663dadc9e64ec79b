#include "core/identify/monte_carlo.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "core/identify/report.h"
#include "core/identify/testing/scenario.h"

namespace axiscal::identify {
namespace {

using ::testing::HasSubstr;

const machine::Machine kMachine = machine::testing::MultiTasking();

Budget ReadOrDie(const std::string& sources, bool reading_noise = true) {
  return ReadBudget(absl::StrCat(R"({"axiscal": "budget/1", "reading_noise": )", reading_noise ? "true" : "false",
                                 R"(, "sources": [)", sources, "]}"),
                    kMachine)
      .value();
}

// Six ball-bar sessions with a reading every 5 degrees.
Fit Measured(std::optional<Budget> budget = {}) {
  Options options;
  options.model = testing::Errors(kMachine, R"({"EA0B": 0, "EC0B": 0, "EX0C": 0, "EY0C": 0})");
  options.budget = std::move(budget);
  const auto truth = testing::Errors(kMachine, R"({"EA0B": 82.1, "EC0B": -61.0, "EX0C": -22.2, "EY0C": 15.3})");
  ballbar::PatternOptions plan;
  plan.step_deg = 5.0;
  std::vector<testing::Measured> patterns = testing::FivePatterns();
  patterns.push_back({"BY-again", ballbar::Pattern::kBY, 356.4});
  return FitSessions(kMachine, testing::Measure(kMachine, truth, {}, patterns, plan), options).value();
}

// With the readings' noise alone the spread is that of linear propagation: 300 runs tell a standard deviation to 4 %.
TEST(MonteCarlo, NoiseAloneGivesTheLinearUncertainty) {
  MonteCarloOptions options;
  options.runs = 300;
  const auto result = MonteCarlo(Measured(), options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->failed, 0);
  ASSERT_EQ(result->spreads.size(), 4u);
  for (const Spread& spread : result->spreads) {
    EXPECT_NEAR(spread.sigma / spread.linear_sigma, 1.0, 4 * 0.04) << spread.name;
    EXPECT_NEAR(spread.mean, spread.value, 4.0 * spread.sigma / std::sqrt(300.0)) << spread.name;
    EXPECT_NEAR((spread.high - spread.low) / spread.sigma, 2 * 1.96, 0.6) << spread.name;
  }
}

std::string Written(const MonteCarloResult& result) {
  reports::Identification report;
  report.fitted.monte_carlo = ReportOf(result);
  return reports::ToJson(report);
}

TEST(MonteCarlo, IsTheSameInWhateverOrderAndOnHoweverManyThreads) {
  const Fit fit = Measured();
  MonteCarloOptions options;
  options.runs = 40;
  options.seed = 7;
  options.budget = ReadOrDie(R"({"name": "C angle", "symbol": "EC0C", "half_width": 70, "drawn": "reading"})");
  const auto one = MonteCarlo(fit, options);
  ASSERT_TRUE(one.ok()) << one.status();
  options.for_each = [](int count, const std::function<void(int)>& body) {
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([=, &body] {
        for (int i = count - 1 - t; i >= 0; i -= 4) body(i);
      });
    }
    for (std::thread& thread : threads) thread.join();
  };
  const auto four = MonteCarlo(fit, options);
  ASSERT_TRUE(four.ok()) << four.status();
  EXPECT_EQ(Written(*one), Written(*four));
  options.seed = 8;
  EXPECT_NE(Written(*one), Written(*MonteCarlo(fit, options)));
}

// A tilt that stands for all sessions goes in full into the identified tilt, and into nothing else.
TEST(MonteCarlo, ASourceThatStandsForTheRunMovesWhatCannotTellItApart) {
  const Fit fit = Measured();
  MonteCarloOptions options;
  options.runs = 200;
  options.budget.with_reading_noise = false;
  const auto without = MonteCarlo(fit, options);
  options.budget = ReadOrDie(R"({"name": "tilt", "symbol": "EA0B", "half_width": 200, "drawn": "run"})", false);
  const auto with = MonteCarlo(fit, options);
  ASSERT_TRUE(without.ok() && with.ok());
  const Spread& tilt = with->spreads[0];
  ASSERT_EQ(tilt.name, "EA0B");
  EXPECT_LT(without->spreads[0].sigma, 5e-6);
  EXPECT_NEAR(tilt.sigma, 200e-6 / std::sqrt(3.0), 12e-6);  // uniform: half width over root 3
  EXPECT_GT(tilt.high - tilt.low, 2 * 180e-6);
  for (size_t i = 1; i < with->spreads.size(); ++i) {
    EXPECT_NEAR(with->spreads[i].sigma / without->spreads[i].sigma, 1.0, 0.3) << with->spreads[i].name;
  }
}

// A session whose readings are known to scatter counts for less: the spread shrinks against a fit that takes all alike.
TEST(MonteCarlo, ReadingsAreWeighedByTheSourcesThatScatterThem) {
  MonteCarloOptions options;
  options.runs = 150;
  options.budget = ReadOrDie(
      R"({"name": "loose magnet", "reading": true, "sigma": 20, "drawn": "reading", "sessions": ["BY-again"]})");
  const auto unweighted = MonteCarlo(Measured(), options);
  const Fit fit = Measured(options.budget);
  const auto weighted = MonteCarlo(fit, options);
  ASSERT_TRUE(unweighted.ok() && weighted.ok());
  double best = 1.0;
  for (size_t i = 0; i < weighted->spreads.size(); ++i) {
    const double ratio = weighted->spreads[i].sigma / unweighted->spreads[i].sigma;
    best = std::min(best, ratio);
    EXPECT_LT(ratio, 1.05) << weighted->spreads[i].name;
    // The fit knows of the scatter now: its own uncertainty is the simulated one.
    EXPECT_NEAR(weighted->spreads[i].sigma / weighted->spreads[i].linear_sigma, 1.0, 0.25) << weighted->spreads[i].name;
  }
  EXPECT_LT(best, 0.8);
}

// Without the readings' own noise the sources alone weigh: what the session states as its repeatability, which they
// explain, counts no second time.
TEST(MonteCarlo, WithoutReadingNoiseTheStatedSigmaDoesNotWeigh) {
  const auto truth = testing::Errors(kMachine, R"({"EA0B": 82.1, "EC0B": -61.0, "EX0C": -22.2, "EY0C": 15.3})");
  ballbar::PatternOptions plan;
  plan.step_deg = 5.0;
  const std::vector<session::Session> stated =
      testing::Measure(kMachine, truth, {}, testing::FivePatterns(), plan);
  std::vector<session::Session> loose = stated;
  for (session::Session& session : loose) {
    for (session::HeaderEntry& entry : session.header) {
      if (entry.key == "sigma_um") entry.value = "9";
    }
  }
  Options options;
  options.model = testing::Errors(kMachine, R"({"EA0B": 0, "EC0B": 0, "EX0C": 0, "EY0C": 0})");
  for (const bool reading_noise : {false, true}) {
    options.budget =
        ReadOrDie(R"({"name": "ball", "reading": true, "sigma": 0.3, "drawn": "reading"},
                     {"name": "C angle", "symbol": "EC0C", "half_width": 7, "drawn": "reading"})", reading_noise);
    const Result one = Identify(kMachine, stated, options).value(), other = Identify(kMachine, loose, options).value();
    double apart = 0.0;
    for (size_t i = 0; i < one.estimates.size(); ++i)
      apart = std::max(apart, std::abs(one.estimates[i].sigma / other.estimates[i].sigma - 1.0));
    if (reading_noise) {
      EXPECT_GT(apart, 0.05);
    } else {
      EXPECT_LT(apart, 1e-6);
    }
  }
}

TEST(MonteCarlo, RefusesWhatItCannotDo) {
  const Fit fit = Measured();
  MonteCarloOptions options;
  options.runs = 0;
  EXPECT_THAT(std::string(MonteCarlo(fit, options).status().message()), HasSubstr("runs = 0, must be 1 to 100000"));
  options.runs = 10;
  options.budget = ReadOrDie(R"({"name": "a", "symbol": "EC0C", "sigma": 1, "drawn": "run", "sessions": ["nowhere"]})");
  EXPECT_THAT(std::string(MonteCarlo(fit, options).status().message()), HasSubstr("session 'nowhere' is not among"));
  options.budget = {};
  options.cancelled = [] { return true; };
  EXPECT_EQ(MonteCarlo(fit, options).status().code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace axiscal::identify
