// Forecasts of machines whose future is known. How often intervals hold: tests/rates/drift_rates.cc.
#include "core/drift/forecast.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/drift/testing/histories.h"

namespace axiscal::drift {
namespace {

using ::testing::HasSubstr;

State Lived(Machine* machine, int weeks, double wear_per_week = 0.0) {
  State state;
  std::vector<Finding> all;
  for (int week = 0; week < weeks; ++week) {
    machine->truth(0) += wear_per_week;
    Tell(machine->Measure(week), &state, &all);
  }
  return state;
}

TEST(Forecast, OfAMachineThatStands) {
  Machine machine(31);
  const State state = Lived(&machine, 150);
  const auto forecast = ForecastOf(state, "EX0C", Week(175));
  ASSERT_TRUE(forecast.ok()) << forecast.status();
  EXPECT_LT(forecast->low, 10.0);
  EXPECT_GT(forecast->high, 10.0);
  EXPECT_LT(forecast->low, forecast->value);
  EXPECT_LT(forecast->value, forecast->high);
  EXPECT_LT(forecast->measured_low, forecast->low);
  EXPECT_GT(forecast->measured_high, forecast->high);
  // Nine tenths of a normal distribution are +- 1.645 sigma; a little more, because something may wander.
  const double half = 0.5 * (forecast->measured_high - forecast->measured_low);
  EXPECT_GT(half, 1.5 * 2.0);
  EXPECT_LT(half, 2.3 * 2.0);
  const auto narrow = ForecastOf(state, "EX0C", Week(175), {.coverage = 0.5, .prior = {}});
  ASSERT_TRUE(narrow.ok());
  EXPECT_LT(narrow->high - narrow->low, forecast->high - forecast->low);
  const auto far = ForecastOf(state, "EX0C", Week(400));
  ASSERT_TRUE(far.ok());
  EXPECT_GT(far->high - far->low, forecast->high - forecast->low);
}

TEST(Forecast, FollowsWear) {
  Machine machine(32);
  const State state = Lived(&machine, 150, 0.16);
  const auto forecast = ForecastOf(state, "EX0C", Week(149 + 52));
  ASSERT_TRUE(forecast.ok()) << forecast.status();
  const double then = machine.truth(0) + 52 * 0.16;
  EXPECT_LT(forecast->low, then);
  EXPECT_GT(forecast->high, then);
  EXPECT_GT(forecast->low, machine.truth(0));  // that it goes on is told
}

TEST(Forecast, WhatHasJustBeenMeasuredCounts) {
  // The last calibrations are not in the state's outlooks yet.
  Machine machine(33);
  State state = Lived(&machine, 100);
  std::vector<Finding> all;
  machine.truth(0) += 40.0;
  for (int week = 100; week < 103; ++week) Tell(machine.Measure(week), &state, &all);
  ASSERT_FALSE(Only<StepChange>(all).empty());
  const auto forecast = ForecastOf(state, "EX0C", Week(104));
  ASSERT_TRUE(forecast.ok());
  EXPECT_NEAR(forecast->value, 50.0, 5.0);
}

TEST(Crossing, OfWearComesWhereTheLimitIs) {
  Machine machine(34);
  const State state = Lived(&machine, 200, 0.16);
  const double limit = machine.truth(0) + 100 * 0.16;  // in a hundred weeks
  const auto crossing = CrossingOf(state, "EX0C", {-1000.0, limit});
  ASSERT_TRUE(crossing.ok()) << crossing.status();
  EXPECT_EQ(crossing->probability_now, 0.0);
  EXPECT_LT(crossing->probability_within_year, 0.1);
  ASSERT_TRUE(crossing->earliest && crossing->median && crossing->latest);
  EXPECT_LT(*crossing->earliest, Week(299));
  EXPECT_GT(*crossing->latest, Week(299));
  EXPECT_LT(*crossing->earliest, *crossing->median);
  EXPECT_LT(*crossing->median, *crossing->latest);
  EXPECT_GT(*crossing->earliest, Week(199));
}

TEST(Crossing, NowAndNever) {
  Machine machine(35);
  const State state = Lived(&machine, 100);
  const auto now = CrossingOf(state, "EB0C", {-10.0, 10.0});  // it is at 30
  ASSERT_TRUE(now.ok());
  EXPECT_EQ(now->probability_now, 1.0);
  EXPECT_EQ(now->earliest, Week(99));
  EXPECT_EQ(now->latest, Week(99));
  const auto never = CrossingOf(state, "EB0C", {-4000.0, 4000.0});
  ASSERT_TRUE(never.ok());
  EXPECT_EQ(never->probability_within_year, 0.0);
  EXPECT_FALSE(never->earliest || never->median || never->latest);
}

TEST(Crossing, WhatMayGoBackCountsOnceItWasOutside) {
  Machine machine(36);
  const State state = Lived(&machine, 30);
  const Limits limits{5.0, 15.0};
  const auto crossing = CrossingOf(state, "EX0C", limits);
  ASSERT_TRUE(crossing.ok());
  EXPECT_FALSE(crossing->earliest || crossing->latest);  // 30 calibrations are too few for dates
  // At its quartiles in a year, half of all courses are outside; within the year, at least as many.
  const auto quartiles = ForecastOf(state, "EX0C", Week(29 + 52), {.coverage = 0.5, .prior = {}});
  ASSERT_TRUE(quartiles.ok());
  const auto half = CrossingOf(state, "EX0C", {quartiles->low, quartiles->high});
  ASSERT_TRUE(half.ok());
  EXPECT_GT(half->probability_within_year, 0.45);
  EXPECT_GE(crossing->probability_within_year, crossing->probability_now);
}

TEST(GroupPrior, SaysWhatTheGroupIsLike) {
  std::vector<State> states;
  for (uint64_t seed = 41; seed < 45; ++seed) {
    Machine machine(seed);
    states.push_back(Lived(&machine, 120));
  }
  std::vector<const State*> machines;
  for (const State& state : states) machines.push_back(&state);
  const GroupPrior prior = PriorOfGroup(machines);
  double sum = 0.0, still = 0.0, still_flat = 0.0;
  for (int k = 0; k < kModels; ++k) {
    sum += prior[k];
    EXPECT_GT(prior[k], 0.0);
    if (SlopeIndex(k) == 0 && RateIndex(k) == 0) still += prior[k], still_flat += FlatPrior()[k];
  }
  EXPECT_NEAR(sum, 1.0, 1e-9);
  EXPECT_GT(still, still_flat);  // none of these wears or wanders
  EXPECT_EQ(PriorOfGroup({}), FlatPrior());
}

TEST(Forecast, RefusesWhatItCannotTell) {
  Machine machine(37);
  const State state = Lived(&machine, 20);
  EXPECT_EQ(ForecastOf(state, "EX0T", Week(30)).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(ForecastOf(state, "EX0C", Week(3)).status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(ForecastOf(state, "EX0C", Week(30), {.coverage = 1.0, .prior = {}}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(CrossingOf(state, "EX0C", {1.0, 1.0}).status().code(), absl::StatusCode::kInvalidArgument);
  const State young = Lived(&machine, 2);
  const auto refused = ForecastOf(young, "EX0C", Week(30));
  EXPECT_EQ(refused.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("EX0C was seen in 2 calibrations"));
}

}  // namespace
}  // namespace axiscal::drift
