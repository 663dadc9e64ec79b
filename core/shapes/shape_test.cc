#include "core/shapes/shape.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <limits>
#include <vector>

namespace axiscal::shapes {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Two axes: one at 125 mm moving backwards 2.5 mm after its reversal, one at 1.2 rad that has not moved.
class ShapeTest : public testing::Test {
 protected:
  ShapeTest() : axes_{{125.0, -1.0, 2.5, -4.0, 0.25}, {1.2, 0.0, std::numeric_limits<double>::infinity(), 0.0}} {
    state_.axes = axes_;
    state_.time_s = 900.0;
    state_.temperature_celsius = 23.5;
  }

  std::vector<double> At(const Shape& shape) const {
    std::vector<double> basis(BasisCount(shape), kNan);
    Basis(shape, state_, basis.data());
    return basis;
  }

  std::vector<AxisState> axes_;
  State state_;
};

TEST_F(ShapeTest, BasesAreTheFormulasOfTheirHeaders) {
  EXPECT_EQ(At(Constant{}), std::vector<double>{1.0});
  EXPECT_EQ(At(Linear{0, Linear::kReferenceMm}), std::vector<double>{0.125});
  EXPECT_EQ(At(Quadratic{0, Quadratic::kReferenceMm}), std::vector<double>{0.25});
  EXPECT_EQ(At(Backlash{0}), std::vector<double>{-0.5});
  EXPECT_EQ(At(Drift{}), std::vector<double>{0.25});
  EXPECT_EQ(At(Thermal{}), std::vector<double>{3.5});
  EXPECT_EQ(At(Lag{0}), std::vector<double>{-4.0});
  EXPECT_DOUBLE_EQ(At(Reversal{0, 5.0})[0], -std::exp(-0.5));
  EXPECT_DOUBLE_EQ(At(DriftExp{1800.0})[0], 1.0 - std::exp(-0.5));
  // Axis 0 stands at 125 mm.
  const Times times{0, Times::kReferenceMm};
  EXPECT_DOUBLE_EQ(At(DriftExp{1800.0, times})[0], 0.125 * (1.0 - std::exp(-0.5)));
  EXPECT_DOUBLE_EQ(At(ThermalLag{kTemperatureChannel, 0.0, times})[0], 0.125 * 3.5);
  const std::vector<double> plain = At(TimeCurve{{0.0, 2000.0}, 3}), scale = At(TimeCurve{{0.0, 2000.0}, 3, times});
  for (int i = 0; i < 3; ++i) EXPECT_DOUBLE_EQ(scale[i], 0.125 * plain[i]);
  EXPECT_EQ(At(Acceleration{0}), std::vector<double>{0.25});
  const Curve curve{0, {0.0, 500.0}, 3};
  for (int i = 0; i < 3; ++i) EXPECT_DOUBLE_EQ(At(BacklashCurve{curve})[i], -At(curve)[i]);
  const std::vector<double> harmonic = At(Harmonic{1, 3.0});
  EXPECT_NEAR(harmonic[0], std::cos(3.6), 1e-15);  // 3 * 1.2 rounds
  EXPECT_NEAR(harmonic[1], std::sin(3.6), 1e-15);
}

// With r = 2: up from far to 10, down to 4, up to 7, down to 6.5.
TEST_F(ShapeTest, AnElementOfFrictionRemembersWhereTheAxisTurned) {
  const auto play_at = [&](double position, double sense, std::array<double, kTurns> turned_at) {
    axes_[0].position = position;
    axes_[0].sense = sense;
    axes_[0].turned_at = turned_at;
    return At(Play{0, 2.0})[0];
  };
  EXPECT_EQ(play_at(10.0, 1.0, {kNan, kNan, kNan}), 1.0);
  EXPECT_EQ(play_at(9.0, -1.0, {10.0, kNan, kNan}), 0.5);   // p = 8
  EXPECT_EQ(play_at(4.0, -1.0, {10.0, kNan, kNan}), -1.0);  // p = 6
  EXPECT_EQ(play_at(7.0, 1.0, {4.0, 10.0, kNan}), 0.5);     // p = 6
  EXPECT_EQ(play_at(6.5, -1.0, {7.0, 4.0, 10.0}), 0.25);
  double slope = kNan;
  BasisSlope(Play{0, 2.0}, state_, &slope);
  const auto with = [&](double r) { return At(Play{0, r})[0]; };
  EXPECT_NEAR(slope, (with(2.0 + 1e-6) - with(2.0 - 1e-6)) / 2e-6, 1e-6);
}

TEST_F(ShapeTest, AShortMoveLeavesAPartOfWhatALongOneLeaves) {
  EXPECT_EQ(At(LastMove{0, 3.0}), std::vector<double>{-1.0});  // none is known: its sense
  axes_[0].last_move = -6.0;
  EXPECT_DOUBLE_EQ(At(LastMove{0, 3.0})[0], -(1.0 - std::exp(-2.0)));
}

TEST_F(ShapeTest, ANodeOfAMapIsOneAtItsPlaceAndNothingAtItsNeighbours) {
  // Axis 0 stands at 125 mm, axis 1 at 1.2 rad.
  EXPECT_EQ(At(Tabulated{0, {125.0, 50.0, 50.0}, false, {}, -1, {}})[0], 1.0);
  EXPECT_EQ(At(Tabulated{0, {100.0, 50.0, 50.0}, false, {}, -1, {}})[0], 0.5);
  EXPECT_EQ(At(Tabulated{0, {75.0, 50.0, 50.0}, false, {}, -1, {}})[0], 0.0);
  EXPECT_EQ(At(Tabulated{0, {100.0, 50.0}, false, {}, -1, {}})[0], 1.0);  // the last one keeps its value
  EXPECT_NEAR(At(Tabulated{0, {100.0, 50.0, 50.0}, false, {}, 1, {1.0, 0.5, 0.5}})[0], 0.5 * 0.6, 1e-15);
  EXPECT_NEAR(At(Tabulated{1, {7.0, 1.0, 1.0, 2.0 * M_PI}, false, {}, -1, {}})[0], 1.0 - (1.2 + 2.0 * M_PI - 7.0),
              1e-12);
  // Tied to the last node: the values of a row sum to zero.
  EXPECT_EQ(At(Tabulated{0, {75.0, 50.0, 50.0}, true, {125.0, 50.0, 50.0}, -1, {}})[0], -1.0);
}

TEST_F(ShapeTest, PreTravelNeedsATouch) {
  EXPECT_EQ(At(PreTravel{}), std::vector<double>{0.0});
  EXPECT_EQ(At(Lobe{3}), (std::vector<double>{0.0, 0.0}));
  state_.approach = {true, {0.6, 0.0, -0.8}, 0.2, 0.6};
  EXPECT_EQ(At(PreTravel{}), std::vector<double>{1.0});
  EXPECT_DOUBLE_EQ(At(Lobe{3})[0], 0.6 * std::cos(0.6));
  EXPECT_DOUBLE_EQ(At(Lobe{3})[1], 0.6 * std::sin(0.6));
}

TEST_F(ShapeTest, AnAxisThatNeverMovedHasNoBacklashAndNoSpike) {
  EXPECT_EQ(At(Backlash{1}), std::vector<double>{0.0});
  EXPECT_EQ(At(Reversal{1, 5.0}), std::vector<double>{0.0});
}

TEST_F(ShapeTest, SlopesOfNonlinearParametersAgreeWithDifferences) {
  constexpr double kStep = 1e-4, kTolerance = 1e-8;  // central difference: third derivative * step^2
  for (Shape shape : {Shape(Reversal{0, 5.0}), Shape(DriftExp{1800.0})}) {
    double slope = kNan;
    BasisSlope(shape, state_, &slope);
    double* parameter = NonlinearParameter(shape);
    ASSERT_NE(parameter, nullptr);
    const double at = *parameter;
    *parameter = at + kStep;
    const double above = At(shape)[0];
    *parameter = at - kStep;
    const double below = At(shape)[0];
    EXPECT_NEAR(slope, (above - below) / (2 * kStep), kTolerance) << Name(shape);
    EXPECT_NE(slope, 0.0);
  }
}

// T rises by r per second from its first value: F = T0 + r (t - tau (1 - exp(-t / tau))), whatever the moments are.
TEST_F(ShapeTest, LateWarmthFollowsARampAsTheFormulaHasIt) {
  const std::vector<double> time_s = {0.0, 10.0, 11.0, 11.0, 700.0, 5000.0};
  std::vector<double> celsius;
  for (const double t : time_s) celsius.push_back(21.0 + 0.001 * t);
  const Temperatures history(time_s, {{"temp_C", std::vector<double>(time_s.size(), 20.0)}, {"T_spindle_C", celsius}});
  ThermalLag lag{"T_spindle_C", 600.0};
  state_.temperatures = &history;
  for (size_t k = 0; k < time_s.size(); ++k) {
    state_.moment = static_cast<int>(k);
    const double late = 1.0 + 0.001 * (time_s[k] - 600.0 * -std::expm1(-time_s[k] / 600.0));
    EXPECT_NEAR(At(lag)[0], late, 1e-12) << k;
    EXPECT_EQ(At(ThermalLag{"temp_C", 600.0})[0], 0.0);
    EXPECT_NEAR(At(ThermalLag{"T_spindle_C", 600.0, 0, 1000.0})[0], 0.125 * late, 1e-12);
    EXPECT_NEAR(At(ThermalLag{"T_spindle_C", 0.0})[0], celsius[k] - 20.0, 1e-12);
  }
  // Beyond what the readings saw it keeps the nearest that they saw.
  lag.from_celsius = 20.5;
  lag.to_celsius = 22.0;
  EXPECT_EQ(At(lag)[0], 2.0);
  EXPECT_NEAR(lag.BeyondSeen(state_), 21.0 + 0.001 * (5000.0 - 600.0 * -std::expm1(-5000.0 / 600.0)) - 22.0, 1e-9);
  // A state without a history has lasted.
  state_.temperatures = nullptr;
  EXPECT_EQ(At(ThermalLag{"temp_C", 600.0})[0], 3.5);
  EXPECT_EQ(At(lag)[0], 0.5);  // 20 deg C, which is below what was seen
}

TEST_F(ShapeTest, TheSlopeOfALagByItsTimeConstantIsThatOfDifferences) {
  const std::vector<double> time_s = {0.0, 30.0, 200.0, 900.0, 1000.0}, celsius = {20.0, 24.0, 23.0, 27.0, 26.0};
  const Temperatures history(time_s, {{"temp_C", celsius}});
  state_.temperatures = &history;
  for (size_t k = 0; k < time_s.size(); ++k) {
    state_.moment = static_cast<int>(k);
    Shape shape = ThermalLag{"temp_C", 300.0};
    double slope = kNan;
    BasisSlope(shape, state_, &slope);
    constexpr double kStep = 0.1, kTolerance = 1e-8;
    *NonlinearParameter(shape) += kStep;
    const double above = At(shape)[0];
    *NonlinearParameter(shape) -= 2.0 * kStep;
    EXPECT_NEAR(slope, (above - At(shape)[0]) / (2.0 * kStep), kTolerance) << k;
    EXPECT_EQ(slope == 0.0, k == 0);
  }
  const Shape at_once = ThermalLag{"temp_C", 0.0};
  EXPECT_EQ(NonlinearParameter(at_once), nullptr);
}

// Means of products of the functions over the span; of an open one with a constant and a line too.
TEST_F(ShapeTest, FunctionsOfASpanAreOrthonormalAndLeaveOutConstantAndLine) {
  constexpr int kPoints = 20000, kFunctions = 16;
  for (const bool is_turn : {false, true}) {
    const Span span = is_turn ? Span{.is_turn = true} : Span{-120.0, 280.0};
    std::vector<std::vector<double>> sums(kFunctions + 2, std::vector<double>(kFunctions, 0.0));
    for (int k = 0; k < kPoints; ++k) {
      const double share = (k + 0.5) / kPoints, q = is_turn ? 2.0 * M_PI * share : -120.0 + 400.0 * share;
      double values[kFunctions + 2];
      span.Values(q, 2, kFunctions, values);
      values[kFunctions] = 1.0;
      values[kFunctions + 1] = is_turn ? 0.0 : share;
      for (int i = 0; i < kFunctions + 2; ++i)
        for (int j = 0; j < kFunctions; ++j) sums[i][j] += values[i] * values[j] / kPoints;
    }
    constexpr double kTolerance = 1e-4;  // of the sum in place of the integral, at the steep ends
    for (int i = 0; i < kFunctions + 2; ++i)
      for (int j = 0; j < kFunctions; ++j) EXPECT_NEAR(sums[i][j], i == j ? 1.0 : 0.0, kTolerance) << i << " " << j;
  }
}

TEST_F(ShapeTest, AFreeCurveFadesBeyondItsSpanAndATimeCurveEnds) {
  const Curve curve{0, {-100.0, 100.0}, 3};
  state_.axes = axes_;
  axes_[0].position = 100.0;
  const std::vector<double> end = At(curve);
  EXPECT_DOUBLE_EQ(end[0], std::sqrt(3.0));
  EXPECT_EQ(KeptAt(curve, state_), 1.0);
  axes_[0].position = 125.0;  // a quarter of half the span
  EXPECT_DOUBLE_EQ(At(curve)[0], std::exp(-1.0) * end[0]);
  EXPECT_DOUBLE_EQ(KeptAt(curve, state_), std::exp(-1.0));
  const TimeCurve drift{{0.0, 900.0}, 2};
  EXPECT_DOUBLE_EQ(At(drift)[0], std::sqrt(3.0));
  state_.time_s = 900.5;
  EXPECT_EQ(At(drift), (std::vector<double>{0.0, 0.0}));
  EXPECT_EQ(KeptAt(drift, state_), 0.0);
  axes_[0].position = 40.0;
  const Crossed without{0, 1, {-100.0, 100.0}, {.is_turn = true}, 2, false};
  const std::vector<double> products = At(without);
  ASSERT_EQ(products.size(), 4u);
  EXPECT_NEAR(products[1], std::sqrt(3.0) * 0.4 * std::sqrt(2.0) * std::sin(1.2), 1e-12);
  const Crossed crossed{0, 1, {-100.0, 100.0}, {.is_turn = true}, 2};
  const std::vector<double> all = At(crossed);
  ASSERT_EQ(all.size(), 8u);
  EXPECT_NEAR(all[1], std::sqrt(2.0) * std::sin(1.2), 1e-12);  // of the second axis alone
  EXPECT_NEAR(all[2], std::sqrt(3.0) * 0.4, 1e-12);            // of the first
  EXPECT_NEAR(all[4], products[1], 1e-12);
  for (const Shape& shape :
       {Shape(curve), Shape(drift), Shape(crossed), Shape(without), Shape(Curve{1, {.is_turn = true}})}) {
    double sum = 0.0;
    for (int i = 0; i < BasisCount(shape); ++i) sum += PriorRoot(shape, i) * PriorRoot(shape, i);
    EXPECT_TRUE(IsFree(shape));
    EXPECT_NEAR(sum, 1.0, 1e-12);
  }
  EXPECT_FALSE(IsFree(Harmonic{}));
}

// A ram droops by (z - z0) (y - y0), about a place that nobody knows: with the products of one function and the
// constant a crossed error is that but for a constant, without them it is not.
TEST_F(ShapeTest, ACrossedErrorIsAboutAnyPlace) {
  state_.axes = axes_;
  for (const bool has_singles : {true, false}) {
    const Crossed crossed{0, 1, {-100.0, 100.0}, {0.0, 300.0}, 2, has_singles};
    const int count = BasisCount(crossed);
    constexpr int kPoses = 200;
    Eigen::MatrixXd columns(kPoses, count + 1);
    Eigen::VectorXd droop(kPoses);
    for (int k = 0; k < kPoses; ++k) {
      const double z = axes_[0].position = -100.0 + 17.0 * (k % 12);
      const double y = axes_[1].position = 1.5 * k;
      const std::vector<double> basis = At(crossed);
      for (int i = 0; i < count; ++i) columns(k, i) = basis[i];
      columns(k, count) = 1.0;
      droop[k] = (z - 60.0) * (y - 10.0) * 1e-6;
    }
    const double left = (droop - columns * columns.colPivHouseholderQr().solve(droop)).norm() / droop.norm();
    if (has_singles) {
      EXPECT_LT(left, 1e-9);
    } else {
      EXPECT_GT(left, 0.5);
    }
  }
}

TEST_F(ShapeTest, NamesAreThoseOfTheReport) {
  EXPECT_EQ(Name(DriftExp{}), "drift-exp");
  EXPECT_EQ(Name(Harmonic{}), "harmonic");
  EXPECT_EQ(VariableAxis(Harmonic{1, 2.0}), 1);
  EXPECT_EQ(VariableAxis(Thermal{}), std::nullopt);
  EXPECT_EQ(VariableAxis(DriftExp{600.0}), std::nullopt);
  EXPECT_EQ(VariableAxis(DriftExp{600.0, {1, Times::kReferenceRad}}), 1);
}

}  // namespace
}  // namespace axiscal::shapes
