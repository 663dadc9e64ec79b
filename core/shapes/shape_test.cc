#include "core/shapes/shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace axiscal::shapes {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Two axes: one at 125 mm moving backwards 2.5 mm after its reversal, one at 1.2 rad that has not moved.
class ShapeTest : public testing::Test {
 protected:
  ShapeTest() : axes_{{125.0, -1.0, 2.5, -4.0}, {1.2, 0.0, std::numeric_limits<double>::infinity(), 0.0}} {
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
  const std::vector<double> harmonic = At(Harmonic{1, 3.0});
  EXPECT_NEAR(harmonic[0], std::cos(3.6), 1e-15);  // 3 * 1.2 rounds
  EXPECT_NEAR(harmonic[1], std::sin(3.6), 1e-15);
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

TEST_F(ShapeTest, NamesAreThoseOfTheReport) {
  EXPECT_EQ(Name(DriftExp{}), "drift-exp");
  EXPECT_EQ(Name(Harmonic{}), "harmonic");
  EXPECT_EQ(VariableAxis(Harmonic{1, 2.0}), 1);
  EXPECT_EQ(VariableAxis(Thermal{}), std::nullopt);
}

}  // namespace
}  // namespace axiscal::shapes
