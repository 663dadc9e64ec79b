#include "core/predict/volumetric.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/base/units.h"
#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"

namespace axiscal::predict {
namespace {

using instruments::MeasuringRun;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

const Eigen::Vector3d kTip(0, 0, -350);
constexpr double kUm = 1e-3;

machine::KnownErrors Known(const std::string& text) {
  auto known = machine::ReadKnownErrors(text, machine::testing::MultiTasking());
  EXPECT_TRUE(known.ok()) << known.status();
  return *std::move(known);
}

// Z Y X B C of the test machine: X over 500 mm, C over 360 deg, the others at rest; a reading per second.
MeasuringRun Measured(int readings = 200) {
  MeasuringRun run;
  run.tip_mm = kTip;
  run.axis_count = 5;
  run.has_time = true;
  run.measured_mm.setZero(1, readings);
  for (int k = 0; k < readings; ++k) {
    const double share = static_cast<double>(k) / std::max(1, readings - 1);
    for (const double position : {-300.0, 10.0, -250.0 + 500.0 * share, 0.0, 2.0 * M_PI * share})
      run.positions.push_back(position);
    run.time_s.push_back(k);
    run.temperature_celsius.push_back(20.0 + 5.0 * share);
  }
  DeriveMotion(&run);
  return run;
}

VolumetricError Over(const std::string& before, const std::string& found,
                     const std::vector<std::string>& unknown = {}) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const std::vector<MeasuringRun> runs = {Measured()};
  const auto odds = BoxOdds::Over(machine, runs, Known(before).model, Known(found));
  EXPECT_NE(odds, nullptr);
  return odds ? odds->Figures(Known(found).model, unknown) : VolumetricError();
}

// A scale error of a um/m over positions that are spread evenly over 0.5 m: 0.5 a / sqrt(12) about its mean.
TEST(Volumetric, OfAScaleErrorIsThatOfAnEvenSpread) {
  constexpr double kSpread = 0.5 / 3.4641016;
  constexpr double kDrawn = 0.05;  // of 400 poses
  const VolumetricError error = Over("{}", R"({"terms": [{"symbol": "EXX", "shape": "linear", "variable": "X",
      "amplitude": 100}], "covariance": {"of": ["EXX:linear"], "sigma": [2], "correlation": [[]]}})");
  EXPECT_NEAR(error.uncorrected.expected_mm, 100 * kUm * kSpread, kDrawn * 100 * kUm * kSpread);
  EXPECT_EQ(error.before.expected_mm, error.uncorrected.expected_mm);
  const double after_mm = error.after.expected_mm;
  EXPECT_NEAR(after_mm / error.before.expected_mm, 2.0 / 100.0, 1e-5);  // (100^2 + 2^2 under the root)
  // |z| of a normal z is below 0.0313 in 2.5 % and below 2.241 in 97.5 % of draws.
  EXPECT_NEAR(error.after.low_mm / after_mm, 0.0313, 0.01);
  EXPECT_NEAR(error.after.high_mm / after_mm, 2.241, 0.1);
  EXPECT_NEAR(error.before.low_mm / error.before.expected_mm, 1.0 - 1.96 * 0.02, 0.003);
  EXPECT_NEAR(error.before.high_mm / error.before.expected_mm, 1.0 + 1.96 * 0.02, 0.003);
  EXPECT_TRUE(error.is_gain_held);
  EXPECT_THAT(error.weakest, ElementsAre("EXX:linear"));
}

// 0.3 urad at 250 mm are less than 2 um/m over 0.5 m.
TEST(Volumetric, TheWeakestNumberIsNamed) {
  const VolumetricError error = Over("{}", R"({"EB0C": 40, "EX0T": 9, "terms": [{"symbol": "EXX", "shape": "linear",
      "variable": "X", "amplitude": 100}], "covariance": {"of": ["EB0C", "EX0T", "EXX:linear"], "sigma": [0.3, 50, 2],
      "correlation": [[], [0], [0, 0]]}})");
  EXPECT_THAT(error.weakest, ElementsAre("EXX:linear"));
}

TEST(Volumetric, AGainWithinItsOwnUncertaintyIsNotHeld) {
  EXPECT_FALSE(Over("{}", R"({"terms": [{"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 1}],
      "covariance": {"of": ["EXX:linear"], "sigma": [2], "correlation": [[]]}})")
                   .is_gain_held);
  const std::string same = R"({"EB0C": 80, "covariance": {"of": ["EB0C"], "sigma": [0.1], "correlation": [[]]}})";
  const VolumetricError error = Over(same, same);  // nothing was added
  EXPECT_FALSE(error.is_gain_held);
  EXPECT_EQ(error.before.expected_mm, error.after.expected_mm);
  EXPECT_GT(error.uncorrected.expected_mm, 10 * kUm);  // 80 urad at up to 250 mm from the axis
}

// What no draw holds widens the intervals of what is left, and changes nothing of whether a gain is held.
TEST(Volumetric, FormsAndSigmasThatAreUnsureWidenTheIntervals) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const std::vector<MeasuringRun> runs = {Measured()};
  const machine::KnownErrors found = Known(R"({"terms": [{"symbol": "EXX", "shape": "linear", "variable": "X",
      "amplitude": 100}], "covariance": {"of": ["EXX:linear"], "sigma": [2], "correlation": [[]]}})");
  const auto odds = BoxOdds::Over(machine, runs, {}, found);
  const VolumetricError plain = odds->Figures(found.model), sure = odds->Figures(found.model, {}, Unsure{});
  EXPECT_EQ(sure.after.low_mm, plain.after.low_mm);
  EXPECT_EQ(sure.after.high_mm, plain.after.high_mm);

  const double form_mm = 25.0 * plain.after.expected_mm;
  const VolumetricError form = odds->Figures(found.model, {}, {form_mm, 0.0});
  EXPECT_DOUBLE_EQ(form.after.expected_mm, std::hypot(plain.after.expected_mm, form_mm));
  EXPECT_NEAR(form.after.high_mm / form_mm, 2.241, 0.1);  // |z| of a normal z is below that in 97.5 % of draws
  EXPECT_GE(form.after.low_mm, plain.after.low_mm);
  EXPECT_TRUE(form.is_gain_held);
  EXPECT_DOUBLE_EQ(form.before.expected_mm, std::hypot(plain.before.expected_mm, form_mm));

  // 100 um/m that are known to 2 %, before they are corrected: the sigma of their logarithm is all that there is.
  const VolumetricError sigma = odds->Figures(found.model, {}, {0.0, 0.3});
  EXPECT_EQ(sigma.before.expected_mm, plain.before.expected_mm);
  EXPECT_NEAR(std::log(sigma.before.high_mm / plain.before.expected_mm), 1.96 * 0.3, 0.04);
  EXPECT_NEAR(std::log(sigma.before.low_mm / plain.before.expected_mm), -1.96 * 0.3, 0.04);
  EXPECT_TRUE(sigma.is_gain_held);
}

// Another error that the readings like as much: half of the draws are those of a machine that has it.
TEST(Volumetric, WhatCannotBeToldIsInTheInterval) {
  const std::string found = R"({"terms": [{"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 100}],
      "covariance": {"of": ["EXX:linear"], "sigma": [2], "correlation": [[]]}})";
  const VolumetricError alone = Over("{}", found);
  const machine::ErrorModel as_found = Known(found).model;
  const machine::Machine machine = machine::testing::MultiTasking();
  const std::vector<MeasuringRun> runs = {Measured()};
  const auto over = [&](double odds) {
    return BoxOdds::Over(machine, runs, {}, Known(found),
                         {{"EXX:linear", as_found, {{machine::ErrorModel(), odds}}, {}}})
        ->Figures(as_found);
  };
  const VolumetricError as_good = over(1.0);
  // The rival is a machine without the error: corrected for what was found it is as far off as that.
  EXPECT_NEAR(as_good.after.high_mm, alone.uncorrected.high_mm, 0.02 * alone.uncorrected.high_mm);
  EXPECT_NEAR(as_good.after.expected_mm, std::sqrt(0.5) * alone.uncorrected.expected_mm,
              0.01 * alone.uncorrected.expected_mm);
  EXPECT_LT(as_good.before.low_mm, 0.1 * alone.before.low_mm);
  EXPECT_FALSE(as_good.is_gain_held);
  EXPECT_THAT(as_good.undecided, ElementsAre("EXX:linear"));
  const VolumetricError unlikely = over(0.01);
  EXPECT_TRUE(unlikely.is_gain_held);
  EXPECT_NEAR(unlikely.after.high_mm, alone.after.high_mm, 0.3 * alone.after.high_mm);
}

// Where the error is not there at all, it is no other one either.
TEST(Volumetric, AChoiceThatRulesLeavesOthersNothingToChoose) {
  const std::string of = R"({"terms": [{"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": )",
                    more = R"(}], "covariance": {"of": ["EXX:linear"], "sigma": [0.01], "correlation": [[]]}})";
  const machine::KnownErrors found = Known(of + "100" + more);
  const machine::ErrorModel rival = Known(of + "40" + more).model;
  const machine::Machine machine = machine::testing::MultiTasking();
  const std::vector<MeasuringRun> runs = {Measured()};
  const auto after = [&](const std::vector<std::string>& overrules) {
    return BoxOdds::Over(machine, runs, {}, found,
                         {{"EXX:linear", found.model, {{rival, 3.0}}, {}}, {"", found.model, {{{}, 0.25}}, overrules}})
        ->Figures(found.model)
        .after;
  };
  const double whole = Over("{}", of + "100" + more).uncorrected.expected_mm;
  // In one of five it is not there: off by all of it; of the others three of four have 40 in its place.
  const predict::RootMeanSquare ruled = after({"EXX:linear"}), free = after({});
  EXPECT_NEAR(ruled.expected_mm, whole * std::sqrt(0.2 + 0.8 * 0.75 * 0.36), 1e-4 * whole);
  EXPECT_NEAR(ruled.high_mm, whole, 1e-3 * whole);
  EXPECT_NEAR(free.expected_mm, whole * std::sqrt(0.8 * 0.75 * 0.36 + 0.2 * 0.25 + 0.2 * 0.75 * 2.56), 1e-4 * whole);
  EXPECT_NEAR(free.high_mm, 1.6 * whole, 1e-3 * whole);
}

// Where the tool's point is and where the work stands is set anew for each part.
TEST(Volumetric, WorkOffsetAndToolCentreAreLeftOut) {
  const VolumetricError error = Over("{}", R"({"EZ0T": 500, "EX0T": 200,
      "covariance": {"of": ["EZ0T", "EX0T"], "sigma": [3, 3], "correlation": [[], [0]]}})");
  EXPECT_LT(error.uncorrected.expected_mm, 1e-6);
  EXPECT_LT(error.after.expected_mm, 1e-6);
}

TEST(Volumetric, NumbersThatNobodyKnowsAreNamedWhereTheyAct) {
  const VolumetricError error = Over(
      "{}", R"({"EX0C": 30, "EB0C": 0, "EZ0T": 0, "covariance": {"of": ["EX0C"], "sigma": [1], "correlation": [[]]}})",
      {"EB0C", "EZ0T"});
  EXPECT_THAT(error.unknown, ElementsAre("EB0C"));
}

TEST(Volumetric, WithoutACovarianceOrMotionThereIsNone) {
  const machine::Machine machine = machine::testing::MultiTasking();
  EXPECT_EQ(BoxOdds::Over(machine, {Measured()}, {}, Known(R"({"EX0C": 30})")), nullptr);
  const machine::KnownErrors known =
      Known(R"({"EX0C": 30, "covariance": {"of": ["EX0C"], "sigma": [1], "correlation": [[]]}})");
  EXPECT_EQ(BoxOdds::Over(machine, {Measured(1)}, {}, known), nullptr);
}

// A slope of 10 +- s um/m that explains what 4 um/m of a gain would: worse where it is not half of that at least.
TEST(BoxOdds, HarmIsAsProbableAsTheErrorIsUncertain) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const std::vector<MeasuringRun> runs = {Measured()};
  const auto harm = [&](double sigma) {
    const machine::KnownErrors found =
        Known(absl::StrCat(R"({"terms": [{"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 10}],
        "covariance": {"of": ["EXX:linear"], "sigma": [)",
                           sigma, R"(], "correlation": [[]]}})"));
    const auto odds = BoxOdds::Over(machine, runs, {}, found);
    EXPECT_EQ(odds->ProbabilityOf({0.1, 0.0}, {}), 0.0);  // what was not corrected is not worse
    EXPECT_EQ(odds->ProbabilityWithout({0}, {0.1, 0.0}), 0.0);
    return odds->ProbabilityOf({0.1, 0.0}, found.model);
  };
  // |a - 10| > 1.1 |a|: a < 10 / 2.1 or a < -100.
  const auto below = [](double sigma) { return 0.5 * std::erfc((10.0 - 10.0 / 2.1) / sigma / std::sqrt(2.0)); };
  EXPECT_EQ(harm(1.0), 0.0);
  for (const double sigma : {3.0, 10.0}) EXPECT_NEAR(harm(sigma), below(sigma), 0.02);
}

// What is left of a fit when one of two errors is taken off takes over what both do.
TEST(BoxOdds, WithoutAnErrorTheOthersTakeItsPlace) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const std::vector<MeasuringRun> runs = {Measured()};
  // Only the sum of two slopes along X is known: 20 + 10 um/m.
  const machine::KnownErrors found = Known(R"json({"terms": [
      {"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 20},
      {"symbol": "EXY", "shape": "linear", "variable": "X", "amplitude": 10}],
      "covariance": {"of": ["EXX:linear", "EXY:linear(X)"], "sigma": [50, 50], "correlation": [[], [-0.9999]]}})json");
  const auto odds = BoxOdds::Over(machine, runs,
                                  Known(R"({"terms": [
      {"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 30}]})")
                                      .model,
                                  found);
  EXPECT_GT(odds->ProbabilityOf({0.1, 1e-6}, machine::ErrorModel({{found.model.terms[0]}})), 0.9);
  EXPECT_EQ(odds->ProbabilityWithout({1}, {0.1, 1e-6}), 0.0);  // as what was corrected before
}

TEST(BoxPoses, OfRunsStayWithinWhatWasMeasured) {
  const MeasuringRun measured = Measured();
  const std::vector<MeasuringRun> runs = {measured};
  const BoxPoses poses(runs, 300);
  EXPECT_THAT(poses.box().low, ElementsAre(-300.0, 10.0, -250.0, 0.0, 0.0));
  EXPECT_THAT(poses.box().high, ElementsAre(-300.0, 10.0, 250.0, 0.0, 2.0 * M_PI));
  double low = 1e9, high = -1e9, warmest = 0.0;
  for (int k = 0; k < poses.count(); ++k) {
    const shapes::State state = poses.At(k);
    ASSERT_EQ(state.axes.size(), 5u);
    low = std::min(low, state.axes[2].position);
    high = std::max(high, state.axes[2].position);
    EXPECT_LE(std::abs(state.axes[2].speed), 1.01 * 500.0 / 199.0);
    EXPECT_LE(state.time_s, 199.0);
    EXPECT_NEAR(state.temperature_celsius, 20.0 + 5.0 * state.time_s / 199.0, 1e-9);  // of one and the same reading
    warmest = std::max(warmest, state.temperature_celsius);
  }
  EXPECT_LT(low, -240.0);
  EXPECT_GT(high, 240.0);
  EXPECT_GT(warmest, 24.5);
}

}  // namespace
}  // namespace axiscal::predict
