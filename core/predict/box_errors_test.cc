#include "core/predict/box_errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/machine/testing/machines.h"

namespace axiscal::predict {
namespace {

using instruments::MeasuringRun;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr double kUm = 1e-3;
constexpr double kDrawn = 0.05;  // of 400 poses, relative
constexpr int kX = 2;            // place of X among Z Y X B C

machine::KnownErrors Known(const std::string& text) {
  auto known = machine::ReadKnownErrors(text, machine::testing::MultiTasking());
  EXPECT_TRUE(known.ok()) << known.status();
  return *std::move(known);
}

// X over 500 mm, from -250 to 250; the others at rest.
MeasuringRun Measured() {
  constexpr int kReadings = 200;
  MeasuringRun run;
  run.tip_mm = {0, 0, -350};
  run.axis_count = 5;
  run.has_time = true;
  run.measured_mm.setZero(1, kReadings);
  for (int k = 0; k < kReadings; ++k) {
    const double x = -250.0 + 500.0 * k / (kReadings - 1);
    for (const double position : {-300.0, 10.0, x, 0.0, 0.0}) run.positions.push_back(position);
    run.time_s.push_back(k);
    run.temperature_celsius.push_back(20.0);
  }
  DeriveMotion(&run);
  return run;
}

// A scale error of X in um/m with its sigma.
std::string Scale(double amplitude, double sigma) {
  return R"({"terms": [{"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": )" +
         std::to_string(amplitude) + R"(}], "covariance": {"of": ["EXX:linear"], "sigma": [)" + std::to_string(sigma) +
         R"(], "correlation": [[]]}})";
}

Box Wide(double from, double to) {
  Box box = MeasuredBox({Measured()});
  box.low[kX] = from;
  box.high[kX] = to;
  return box;
}

// a um/m over positions spread evenly over 0.5 m, about their mean: lengths |a| |u|, u even in -0.25 .. 0.25 m, so rms
// 0.5 a / sqrt(12), median 0.125 a, 95 % 0.2375 a, at most 0.25 a.
TEST(BoxErrors, FiguresOfAScaleErrorAreThoseOfAnEvenSpread) {
  const auto errors =
      ErrorsOverBox(machine::testing::MultiTasking(), {Measured()}, std::nullopt, Known(Scale(100, 0.01)), {});
  ASSERT_TRUE(errors);
  const LengthFigures& machine = errors->uncorrected;
  EXPECT_NEAR(machine.rms.expected_mm, 100 * kUm * 0.5 / std::sqrt(12.0), kDrawn * 15 * kUm);
  EXPECT_NEAR(machine.median.expected_mm, 12.5 * kUm, 2 * kDrawn * 12.5 * kUm);
  EXPECT_NEAR(machine.p95.expected_mm, 23.75 * kUm, kDrawn * 24 * kUm);
  EXPECT_NEAR(machine.max.expected_mm, 25 * kUm, kDrawn * 25 * kUm);
  EXPECT_GT(std::abs(machine.largest_at[kX]), 240.0);
  EXPECT_EQ(errors->known_share, 1.0);
  EXPECT_FALSE(errors->before);
  EXPECT_FALSE(errors->after_where_known);
}

// After: |z| sigma times the same; 95 % of |z| are within 0.0313 .. 2.241, their mean is sqrt(2 / pi).
TEST(BoxErrors, AfterIsWhatTheUncertaintyLeaves) {
  const auto errors = ErrorsOverBox(machine::testing::MultiTasking(), {Measured()}, Known(Scale(97, 1)).model,
                                    Known(Scale(100, 2)), {});
  ASSERT_TRUE(errors);
  const double one_mm = kUm * 0.5 / std::sqrt(12.0);  // rms of one um/m
  EXPECT_NEAR(errors->after.rms.expected_mm, 2 * one_mm * std::sqrt(2.0 / M_PI), 0.1 * one_mm);
  EXPECT_NEAR(errors->after.rms.low_mm, 2 * one_mm * 0.0313, 0.06 * one_mm);
  EXPECT_NEAR(errors->after.rms.high_mm, 2 * one_mm * 2.241, 0.4 * one_mm);
  // Before: what the other calibration left, 3 um/m, and as much uncertainty.
  ASSERT_TRUE(errors->before);
  EXPECT_NEAR(errors->before->rms.high_mm, (3 + 1.96 * 2) * one_mm, 0.5 * one_mm);
  EXPECT_THAT(errors->weakest, ElementsAre("EXX:linear"));
}

// A part box twice as wide as what was measured: half of it is extrapolated, and there the error is twice as large.
TEST(BoxErrors, SaysWhereItExtrapolates) {
  const auto errors = ErrorsOverBox(machine::testing::MultiTasking(), {Measured()}, std::nullopt, Known(Scale(100, 2)),
                                    {}, Wide(-500, 500));
  ASSERT_TRUE(errors);
  EXPECT_NEAR(errors->known_share, 0.5, 0.08);
  ASSERT_TRUE(errors->after_where_known);
  EXPECT_NEAR(errors->after_where_known->max.expected_mm / errors->after.max.expected_mm, 0.5, 0.05);
  // Wholly beside it: nothing is known.
  const auto beside = ErrorsOverBox(machine::testing::MultiTasking(), {Measured()}, std::nullopt, Known(Scale(100, 2)),
                                    {}, Wide(300, 500));
  ASSERT_TRUE(beside);
  EXPECT_EQ(beside->known_share, 0.0);
  EXPECT_FALSE(beside->after_where_known);
}

TEST(BoxErrors, NothingWithoutUncertaintyOrMotion) {
  const machine::Machine machine = machine::testing::MultiTasking();
  EXPECT_FALSE(ErrorsOverBox(machine, {Measured()}, std::nullopt, Known(R"({"EB0C": 40})"), {}));
  EXPECT_FALSE(ErrorsOverBox(machine, {Measured()}, std::nullopt, Known(Scale(100, 2)), {}, Wide(7, 7)));
}

// EX0W is a shift of the table, which a work offset takes up; EB0C turns C's axis, and nothing turned.
TEST(BoxErrors, UnknownErrorsThatActAreNamed) {
  const auto errors = ErrorsOverBox(
      machine::testing::MultiTasking(), {Measured()}, std::nullopt,
      Known(R"({"EX0W": 1, "terms": [{"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 100},
             {"symbol": "EYX", "shape": "linear", "variable": "X", "amplitude": 1}],
             "covariance": {"of": ["EXX:linear"], "sigma": [2], "correlation": [[]]}})"),
      {"EX0W", "EYX:linear"});
  ASSERT_TRUE(errors);
  EXPECT_THAT(errors->unknown, ElementsAre("EYX:linear"));
}

}  // namespace
}  // namespace axiscal::predict
