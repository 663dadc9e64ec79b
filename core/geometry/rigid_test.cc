#include "core/geometry/rigid.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

namespace axiscal::geometry {
namespace {

constexpr double kTolerance = 1e-15;  // rounding of a handful of products of numbers near one

TEST(Rigid, RotationXyzIsTheProductOfThreeAxisRotations) {
  for (const double scale : {0.0, 1e-4, 1.3}) {
    const double a = 0.7 * scale, b = -1.1 * scale, c = 0.4 * scale;
    const Matrix3<double> product = AxisRotation<double>(Eigen::Vector3d::UnitX(), a) *
                                    AxisRotation<double>(Eigen::Vector3d::UnitY(), b) *
                                    AxisRotation<double>(Eigen::Vector3d::UnitZ(), c);
    EXPECT_LT((RotationXyz(a, b, c) - product).cwiseAbs().maxCoeff(), kTolerance);
  }
}

TEST(Rigid, AxisRotationIsRightHandedAndAgreesWithEigen) {
  const Vector3<double> turned = AxisRotation<double>(Eigen::Vector3d::UnitZ(), M_PI / 2) * Eigen::Vector3d::UnitX();
  EXPECT_NEAR(turned.y(), 1.0, kTolerance);
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 3).normalized();
  const Matrix3<double> reference = Eigen::AngleAxisd(0.83, axis).toRotationMatrix();
  EXPECT_LT((AxisRotation<double>(axis, 0.83) - reference).cwiseAbs().maxCoeff(), kTolerance);
}

TEST(Rigid, InverseUndoesTheTransform) {
  const Rigid<double> b_from_a{RotationXyz(0.3, -0.2, 2.0), Vector3<double>(10, -20, 300)};
  const Vector3<double> p(1, 2, 3);
  EXPECT_LT(((b_from_a.Inverse() * (b_from_a * p)) - p).norm(), 1e-12);  // 300 mm times 1e-16, a few times
}

TEST(Rigid, SmallSinesAndCosinesAreExactToTheLastBit) {
  for (double angle = -0.012; angle <= 0.012; angle += 1.7e-5) {
    double sine = std::numeric_limits<double>::quiet_NaN(), cosine = sine;
    SineCosine(angle, &sine, &cosine);
    EXPECT_NEAR(sine, std::sin(angle), 3.6e-18);    // two units in the last place of 0.01, 1.7e-18 each
    EXPECT_NEAR(cosine, std::cos(angle), 2.3e-16);  // one unit in the last place of 1
  }
}

TEST(Rigid, DerivativesOfTheSmallRotationAtZeroAreTheSkewMatrices) {
  using Jet = ceres::Jet<double, 3>;
  const Matrix3<Jet> rotation = RotationXyz(Jet(0.0, 0), Jet(0.0, 1), Jet(0.0, 2));
  const Vector3<double> p(5, -7, 11);
  for (int k = 0; k < 3; ++k) {
    Matrix3<double> derivative = Matrix3<double>::Constant(std::numeric_limits<double>::quiet_NaN());
    for (int i = 0; i < 9; ++i) derivative(i / 3, i % 3) = rotation(i / 3, i % 3).v[k];
    EXPECT_LT((derivative * p - Skew(Vector3<double>::Unit(k)) * p).norm(), kTolerance);
  }
}

TEST(TurnAbout, EqualsTheProductWithTheAxisRotation) {
  const Matrix3<double> start = RotationXyz(0.3, -0.7, 1.1);
  constexpr double kRounding = 1e-15;
  for (const Vector3<double>& axis :
       {Vector3<double>(1, 0, 0), Vector3<double>(0, -1, 0), Vector3<double>(0, 0, 1), Vector3<double>(0, 0.6, 0.8)}) {
    for (const double angle_rad : {0.0, 0.4, -2.5}) {
      Matrix3<double> turned = start;
      TurnAbout(axis, angle_rad, &turned);
      EXPECT_LT((turned - start * AxisRotation(axis, angle_rad)).cwiseAbs().maxCoeff(), kRounding);
    }
  }
}

}  // namespace
}  // namespace axiscal::geometry
