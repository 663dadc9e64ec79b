// Every kind of effect: known answers of the fitted formulas, and what the other forms have in common with them.
#include "core/synthetic/effect.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/machine/error_json.h"
#include "core/synthetic/testing/plans.h"

namespace axiscal::synthetic {
namespace {

using machine::Component;
using ::testing::HasSubstr;
using testing::Moving;

const machine::Machine& Mt() {
  static const machine::Machine* const kMachine = new machine::Machine(machine::testing::MultiTasking());
  return *kMachine;
}
constexpr int kX = 2, kB = 3, kC = 4;  // axes of the machine: Z Y X B C

// Every axis to and fro in its own way, warming up.
History Plan() {
  instruments::MeasuringRun run;
  run.axis_count = Mt().axis_count();
  run.has_time = true;
  constexpr int kReadings = 800;
  run.measured_mm.setZero(1, kReadings);
  std::vector<double> celsius;
  for (int k = 0; k < kReadings; ++k) {
    const double t = 1.5 * k;
    run.time_s.push_back(t);
    for (int axis = 0; axis < run.axis_count; ++axis) {
      const double swing = std::sin(0.011 * (axis + 1.3) * k + axis);
      run.positions.push_back(Mt().axes[axis].kind == machine::AxisKind::kLinear ? 200.0 * swing : 1.5 * swing);
    }
    celsius.push_back(20.0 + 3.0 * (1.0 - std::exp(-t / 400.0)) + 0.5 * std::sin(t / 150.0));
  }
  instruments::DeriveMotion(&run);
  History history;
  Append(run, {{"temp_C", celsius}}, &history);
  return history;
}

Effect Of(EffectKind kind, int joint, Component component, double rms) {
  Effect effect;
  effect.kind = kind;
  effect.joint = joint;
  effect.component = component;
  effect.rms = rms;
  if (joint < Mt().axis_count()) effect.axis = joint;
  return effect;
}

// One of each kind.
std::vector<Effect> AllKinds() {
  std::vector<Effect> effects = {Of(EffectKind::kCurve, kX, Component::kY, 4e-3),
                                 Of(EffectKind::kCurve, kC, Component::kC, 20e-6),
                                 Of(EffectKind::kTimeCurve, Mt().tool_joint(), Component::kZ, 5e-3),
                                 Of(EffectKind::kRipple, kC, Component::kC, 10e-6),
                                 Of(EffectKind::kGravity, kX, Component::kB, 30e-6),
                                 Of(EffectKind::kGravity, kB, Component::kB, 30e-6),
                                 Of(EffectKind::kCrossed, kX, Component::kZ, 3e-3),
                                 Of(EffectKind::kHeat, Mt().tool_joint(), Component::kZ, 8e-3),
                                 Of(EffectKind::kHeat, kX, Component::kX, 8e-3),
                                 Of(EffectKind::kHeat, Mt().tool_joint(), Component::kX, 8e-3),
                                 Of(EffectKind::kBacklash, kX, Component::kX, 3e-3),
                                 Of(EffectKind::kWindUp, kB, Component::kB, 15e-6),
                                 Of(EffectKind::kFriction, kX, Component::kX, 2e-3),
                                 Of(EffectKind::kLastMove, kX, Component::kX, 2e-3),
                                 Of(EffectKind::kFollowing, kX, Component::kX, 2e-3),
                                 Of(EffectKind::kFollowing, kC, Component::kC, 9e-6)};
  effects[2].axis = -1;
  effects[3].frequency = 17.3;
  effects[4].axis = effects[5].axis = -1;
  effects[6].second_axis = 0;
  for (const size_t i : {7, 8, 9}) {
    effects[i].channel = i == 9 ? kTimeChannel : "temp_C";
    effects[i].tau_s = 300.0;
  }
  effects[15].is_of_speed = false;
  effects[15].delay_s = 0.3;
  effects[14].delay_s = 1.0;  // long enough for a servo to show that its error is not of speed alone
  return effects;
}

DrawnEffect Draw(const Effect& effect, Form form, const History& plan, uint64_t seed = 7) {
  base::Random random(seed);
  auto drawn = DrawEffect(Mt(), {}, effect, form, plan, &random);
  EXPECT_TRUE(drawn.ok()) << drawn.status();
  return *std::move(drawn);
}

double RmsOfDifference(std::vector<double> a, const std::vector<double>& b) {
  for (size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return RmsAboutMean(a);
}

TEST(Effects, HaveTheSizeThatWasAskedForInBothForms) {
  const History plan = Plan();
  for (const Effect& effect : AllKinds()) {
    for (const Form form : {Form::kOwn, Form::kIndependent}) {
      const std::vector<double> errors = Draw(effect, form, plan).Errors(plan);
      EXPECT_NEAR(RmsAboutMean(errors), effect.rms, 1e-9 * effect.rms) << NameOf(Mt(), effect);
      EXPECT_EQ(errors, Draw(effect, form, plan).Errors(plan)) << NameOf(Mt(), effect);
    }
  }
}

// The other form is another function: not the fitted one at another amplitude.
TEST(Effects, IndependentFormsAreNotTheOwnForms) {
  const History plan = Plan();
  for (const Effect& effect : AllKinds()) {
    const std::vector<double> own = Draw(effect, Form::kOwn, plan).Errors(plan);
    const std::vector<double> other = Draw(effect, Form::kIndependent, plan).Errors(plan);
    double product = 0.0, own_mean = 0.0, other_mean = 0.0;
    const double count = static_cast<double>(own.size());
    for (size_t k = 0; k < own.size(); ++k) {
      own_mean += own[k] / count;
      other_mean += other[k] / count;
    }
    for (size_t k = 0; k < own.size(); ++k) product += (own[k] - own_mean) * (other[k] - other_mean) / count;
    const double correlation = product / (effect.rms * effect.rms);
    EXPECT_LT(std::abs(correlation), 0.99999) << NameOf(Mt(), effect);
  }
}

// What two forms of one physics with nothing drawn at random share.
TEST(Effects, IndependentFormsAreLikeTheOwnOnesWherePhysicsIsTheSame) {
  const History plan = Plan();
  for (const Effect& effect : AllKinds()) {
    const bool is_drawn = effect.kind == EffectKind::kCurve || effect.kind == EffectKind::kTimeCurve ||
                          effect.kind == EffectKind::kRipple || effect.kind == EffectKind::kGravity ||
                          effect.kind == EffectKind::kCrossed || effect.kind == EffectKind::kBacklash;
    if (is_drawn) continue;
    const std::vector<double> own = Draw(effect, Form::kOwn, plan).Errors(plan);
    const double off = RmsOfDifference(Draw(effect, Form::kIndependent, plan).Errors(plan), own);
    EXPECT_LT(off, 0.7 * effect.rms) << NameOf(Mt(), effect);
  }
}

TEST(Effects, OfOtherHistoriesAreTheSameFunction) {
  const History plan = Plan();
  Effect curve = Of(EffectKind::kCurve, kX, Component::kY, 4e-3);
  for (const Form form : {Form::kOwn, Form::kIndependent}) {
    const DrawnEffect drawn = Draw(curve, form, plan);
    const std::vector<double> errors = drawn.Errors(plan);
    const History one = Moving({0.0}, {plan.PositionsOf(123)[kX]});
    EXPECT_DOUBLE_EQ(drawn.Errors(one)[0], errors[123]);
  }
}

TEST(Effects, DriftStaysWhereItEnded) {
  Effect drift = Of(EffectKind::kTimeCurve, Mt().tool_joint(), Component::kZ, 5e-3);
  drift.axis = -1;
  const History plan = Plan();
  for (const Form form : {Form::kOwn, Form::kIndependent}) {
    const DrawnEffect drawn = Draw(drift, form, plan);
    const std::vector<double> later = drawn.Errors(Moving({plan.time_s.back(), 1e5}, {0, 0}));
    EXPECT_EQ(later[0], drawn.Errors(plan).back());
    EXPECT_EQ(later[1], later[0]);
  }
}

TEST(Effects, CurvesOfATurnClose) {
  const Effect curve = Of(EffectKind::kCurve, kC, Component::kX, 4e-3);
  for (const Form form : {Form::kOwn, Form::kIndependent}) {
    for (uint64_t seed = 1; seed <= 6; ++seed) {  // three kernels by chance
      const DrawnEffect drawn = Draw(curve, form, Plan(), seed);
      const std::vector<double> errors = drawn.Errors(Moving({0, 1}, {-0.4, -0.4 + 2.0 * std::numbers::pi}));
      EXPECT_NEAR(errors[0], errors[1], 1e-12);
    }
  }
}

TEST(Own, RippleIsATermOfErrorsJson) {
  Effect ripple = Of(EffectKind::kRipple, kC, Component::kC, 10e-6);
  ripple.frequency = 17.3;
  const History plan = Plan();
  const DrawnEffect drawn = Draw(ripple, Form::kOwn, plan);
  ASSERT_TRUE(drawn.term.has_value());
  EXPECT_EQ(machine::NameOf(Mt(), *drawn.term), "ECC:harmonic(17.3)");
  const std::vector<double> errors = drawn.Errors(plan);
  for (const size_t k : {0, 5, 700}) {
    const double by_term = machine::ErrorsAt(Mt(), {{*drawn.term}}, plan.StateOf(k))[kC][5];
    EXPECT_NEAR(errors[k], by_term, 1e-18);
    const double angle = 17.3 * plan.PositionsOf(k)[kC];
    EXPECT_NEAR(by_term, drawn.term->amplitude[0] * std::cos(angle) + drawn.term->amplitude[1] * std::sin(angle),
                1e-18);
  }
}

// A ramp of 1 K per time constant: F lags by 1 - exp(-t / tau) K.
TEST(Own, LagFollowsARamp) {
  Effect lag = Of(EffectKind::kHeat, Mt().tool_joint(), Component::kZ, 5e-3);
  lag.channel = "temp_C";
  lag.tau_s = 100.0;
  History ramp = Moving({0, 30, 100, 250, 600}, {0, 0, 0, 0, 0});
  for (size_t k = 0; k < ramp.size(); ++k) ramp.celsius["temp_C"][k] = 20.0 + ramp.time_s[k] / 100.0;
  const DrawnEffect drawn = Draw(lag, Form::kOwn, ramp);
  const std::vector<double> errors = drawn.Errors(ramp);
  for (size_t k = 0; k < ramp.size(); ++k) {
    const double t = ramp.time_s[k] / 100.0;
    EXPECT_NEAR(errors[k], drawn.factor * (t - (1.0 - std::exp(-t))), 1e-12);
  }
}

// Both forms settle in proportion to the temperature: 5 and 10 K, long after.
TEST(Both, HeatSettles) {
  Effect lag = Of(EffectKind::kHeat, Mt().tool_joint(), Component::kZ, 5e-3);
  lag.channel = "temp_C";
  lag.tau_s = 100.0;
  History steps = Moving({0, 1, 1e5, 1e5 + 1, 2e5}, {0, 0, 0, 0, 0});
  steps.celsius["temp_C"] = {20, 25, 25, 30, 30};
  for (const Form form : {Form::kOwn, Form::kIndependent}) {
    const std::vector<double> errors = Draw(lag, form, steps).Errors(steps);
    EXPECT_NEAR(errors[0], 0.0, 1e-15);
    EXPECT_NEAR(errors[4] / errors[2], 2.0, 1e-6);
    EXPECT_LT(std::abs(errors[1]), 0.1 * std::abs(errors[2]));  // it acts late
  }
}

TEST(Own, TimeSinceTheStartIsATermOfErrorsJson) {
  Effect start = Of(EffectKind::kHeat, Mt().tool_joint(), Component::kZ, 5e-3);
  start.channel = kTimeChannel;
  start.tau_s = 900.0;
  const DrawnEffect drawn = Draw(start, Form::kOwn, Plan());
  ASSERT_TRUE(drawn.term.has_value());
  EXPECT_EQ(machine::NameOf(Mt(), *drawn.term), "EZT:drift-exp");
}

TEST(Own, TemperatureTimesPosition) {
  Effect product = Of(EffectKind::kHeat, kX, Component::kX, 5e-3);
  product.channel = "temp_C";
  product.tau_s = 1e-3;  // at once; per metre
  History moving = Moving({0, 10, 20}, {100, 200, -300});
  moving.celsius["temp_C"] = {21, 22, 24};
  const DrawnEffect drawn = Draw(product, Form::kOwn, moving);
  const std::vector<double> errors = drawn.Errors(moving);
  EXPECT_NEAR(errors[1], drawn.factor * 2.0 * 0.2, 1e-4 * std::abs(errors[1]));
  EXPECT_NEAR(errors[2], drawn.factor * 4.0 * -0.3, 1e-4 * std::abs(errors[2]));
}

TEST(Own, WindUpTurnsOverAfterAReversal) {
  Effect wind_up = Of(EffectKind::kWindUp, kX, Component::kX, 5e-3);
  wind_up.length = 10.0;
  const History reversing = Moving({0, 1, 2, 3}, {0, 1000, 990, 0});
  const DrawnEffect drawn = Draw(wind_up, Form::kOwn, reversing);
  const std::vector<double> errors = drawn.Errors(reversing);
  EXPECT_NEAR(errors[1], drawn.factor, 1e-12);
  EXPECT_NEAR(errors[2], -drawn.factor * (1.0 - 2.0 / std::numbers::e), 1e-12);
  EXPECT_NEAR(errors[3], -drawn.factor, 1e-12);
}

// Elements that stick and slide remember where they turned: a closed loop ends where it began, and coming back along
// another way is another error.
TEST(Both, FrictionClosesItsLoops) {
  Effect friction = Of(EffectKind::kFriction, kX, Component::kX, 5e-3);
  friction.length = 20.0;
  std::vector<double> time_s, path;
  for (int k = 0; k <= 400; ++k) {
    time_s.push_back(k);
    path.push_back(100.0 * std::sin(2.0 * std::numbers::pi * k / 100.0));
  }
  const History loops = Moving(time_s, path);
  for (const Form form : {Form::kOwn, Form::kIndependent}) {
    const std::vector<double> errors = Draw(friction, form, loops).Errors(loops);
    EXPECT_NEAR(errors[300], errors[400], 1e-6);           // the same place of two loops
    EXPECT_GT(std::abs(errors[300] - errors[350]), 5e-3);  // the same position, the other way
  }
}

TEST(Both, LastMoveHasSignAndSize) {
  Effect last = Of(EffectKind::kLastMove, kX, Component::kX, 5e-3);
  last.length = 50.0;
  const History moves = Moving({0, 1, 2, 3, 4}, {0, 100, 90, 90, 190});
  for (const Form form : {Form::kOwn, Form::kIndependent}) {
    const DrawnEffect drawn = Draw(last, form, moves);
    const std::vector<double> errors = drawn.Errors(moves);
    EXPECT_EQ(errors[1], errors[4]);
    EXPECT_EQ(errors[2], errors[3]);  // at rest it stays
    EXPECT_LT(errors[2] * errors[1], 0.0);
    EXPECT_LT(std::abs(errors[2]), std::abs(errors[1]));
    const double small = form == Form::kOwn ? -1.0 - 0.5 * 10.0 / 50.0 : -(1.0 - std::exp(-10.0 / 50.0));
    EXPECT_NEAR(errors[2], drawn.factor * small, 1e-15);
  }
}

// At constant speed a servo is late by its delay in both forms.
TEST(Both, FollowingIsLateByTheDelay) {
  Effect following = Of(EffectKind::kFollowing, kX, Component::kX, 1.0);
  following.delay_s = 0.02;
  std::vector<double> time_s, path;
  for (int k = 0; k < 300; ++k) {
    time_s.push_back(0.25 * k);
    path.push_back(k < 100 ? 2.0 * k : k < 200 ? 200.0 + 4.0 * (k - 100) : 600.0 - 2.0 * (k - 200));
  }
  const History steady = Moving(time_s, path);
  for (const Form form : {Form::kOwn, Form::kIndependent}) {
    const DrawnEffect drawn = Draw(following, form, steady);
    const std::vector<double> errors = drawn.Errors(steady);
    EXPECT_NEAR(errors[50] / drawn.factor, -0.02 * 8.0, 1e-6);
    EXPECT_NEAR(errors[150] / drawn.factor, -0.02 * 16.0, 1e-6);
    EXPECT_NEAR(errors[280] / drawn.factor, 0.02 * 8.0, 1e-6);
  }
}

TEST(Both, AccelerationIsFelt) {
  Effect following = Of(EffectKind::kFollowing, kX, Component::kX, 1.0);
  following.delay_s = 0.05;
  following.is_of_speed = false;
  std::vector<double> time_s, path;
  for (int k = 0; k < 200; ++k) {
    const double t = 0.25 * k, later = std::max(0.0, t - 25.0);
    time_s.push_back(t);
    path.push_back(2.0 * t * t + later * later);  // 4, then 6 mm/s^2
  }
  const History speeding = Moving(time_s, path);
  for (const Form form : {Form::kOwn, Form::kIndependent}) {
    const DrawnEffect drawn = Draw(following, form, speeding);
    const std::vector<double> errors = drawn.Errors(speeding);
    EXPECT_NEAR(errors[60] / drawn.factor, -0.05 * 0.05 * 4.0, 1e-6);
    EXPECT_NEAR(errors[180] / drawn.factor, -0.05 * 0.05 * 6.0, 1e-6);
  }
}

// A head that B tilts hangs by its mass centre: the moment about y is g times the centre's x, once around per turn.
TEST(Own, GravityTurnsWithTheHead) {
  Effect gravity = Of(EffectKind::kGravity, kB, Component::kB, 30e-6);
  gravity.axis = -1;
  const History plan = Plan();
  const DrawnEffect drawn = Draw(gravity, Form::kOwn, plan);
  constexpr double kPi = std::numbers::pi;
  const std::vector<double> errors = drawn.Errors(Moving({0, 1, 2, 3}, {0.3, 0.3 + kPi, 0.3 + kPi / 2, 0.0}));
  EXPECT_NEAR(errors[0], -errors[1], 1e-12);
  EXPECT_NEAR(std::cos(0.3) * errors[0] - std::sin(0.3) * errors[2], errors[3], 1e-12);
  // Weightless, or with the axis along gravity, nothing bends.
  gravity.component = Component::kC;
  gravity.joint = kC;
  base::Random random(1);
  const auto refused = DrawEffect(Mt(), {}, gravity, Form::kOwn, plan, &random);
  EXPECT_THAT(std::string(refused.status().message()), HasSubstr("it is the same at all of the plan's readings"));
}

// Not a sum of one function of each axis.
TEST(Both, CrossedErrorsAreNoSum) {
  Effect crossed = Of(EffectKind::kCrossed, kX, Component::kZ, 3e-3);
  crossed.second_axis = kB;
  const History plan = Plan();
  for (const Form form : {Form::kOwn, Form::kIndependent}) {
    const DrawnEffect drawn = Draw(crossed, form, plan);
    const auto at = [&](double x, double b) {
      History one = Moving({0.0}, {0.0});
      one.positions[kX] = one.axis_states[kX].position = x;
      one.positions[kB] = one.axis_states[kB].position = b;
      return drawn.Errors(one)[0];
    };
    EXPECT_GT(std::abs(at(-150, -1) - at(-150, 1) - at(150, -1) + at(150, 1)), 1e-4);
  }
}

TEST(Effects, AreRefusedWhereThePlanCannotShowThem) {
  History resting = Moving({0, 1, 2}, {5, 5, 5});
  base::Random random(1);
  const auto message = [&](const Effect& effect) {
    return std::string(DrawEffect(Mt(), {}, effect, Form::kOwn, resting, &random).status().message());
  };
  EXPECT_EQ(message(Of(EffectKind::kCurve, kX, Component::kY, 1e-3)),
            "EYX:curve(X): axis X rests in all of the plan, expected one that moves");
  Effect thermal = Of(EffectKind::kHeat, Mt().tool_joint(), Component::kZ, 1e-3);
  thermal.tau_s = 100.0;
  thermal.channel = "T_SPINDLE_C";
  EXPECT_EQ(message(thermal), "EZT:thermal(T_SPINDLE_C): the plan has no temperature 'T_SPINDLE_C'");
  thermal.channel = "temp_C";
  EXPECT_THAT(message(thermal), HasSubstr("it is the same at all of the plan's readings"));
}

}  // namespace
}  // namespace axiscal::synthetic
