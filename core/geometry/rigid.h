// Rigid transforms `target_from_source`: p_in_target = target_from_source * p_in_source; inner names must touch.
// Lengths in mm. Templated on the scalar so that one chain serves doubles and automatic derivatives.
#ifndef AXISCAL_CORE_GEOMETRY_RIGID_H_
#define AXISCAL_CORE_GEOMETRY_RIGID_H_

#include <Eigen/Core>
#include <cmath>
#include <type_traits>

namespace axiscal::geometry {

template <typename T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <typename T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;

template <typename T>
struct Rigid {
  Matrix3<T> rotation = Matrix3<T>::Identity();
  Vector3<T> translation_mm = Vector3<T>::Zero();

  Vector3<T> operator*(const Vector3<T>& point_mm) const { return rotation * point_mm + translation_mm; }
  Rigid operator*(const Rigid& inner) const {
    return {rotation * inner.rotation, rotation * inner.translation_mm + translation_mm};
  }
  Rigid Inverse() const {
    const Matrix3<T> transposed = rotation.transpose();
    return {transposed, -(transposed * translation_mm)};
  }
};

// Skew matrix of v: Skew(v) * u = v x u.
inline Matrix3<double> Skew(const Vector3<double>& v) {
  Matrix3<double> skew;
  skew << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return skew;
}

// Right-handed rotation by `angle_rad` about the unit vector `axis` (Rodrigues).
template <typename T>
Matrix3<T> AxisRotation(const Vector3<double>& axis, const T& angle_rad) {
  using std::cos;
  using std::sin;
  const T s = sin(angle_rad), c = cos(angle_rad);
  const T v = T(1.0) - c;
  Matrix3<T> rotation;
  rotation << c + v * (axis.x() * axis.x()), v * (axis.x() * axis.y()) - s * axis.z(),
      v * (axis.x() * axis.z()) + s * axis.y(), v * (axis.x() * axis.y()) + s * axis.z(), c + v * (axis.y() * axis.y()),
      v * (axis.y() * axis.z()) - s * axis.x(), v * (axis.x() * axis.z()) - s * axis.y(),
      v * (axis.y() * axis.z()) + s * axis.x(), c + v * (axis.z() * axis.z());
  return rotation;
}

// rotation = rotation * AxisRotation(axis, angle). About a coordinate axis, the usual case, only two columns change.
inline void TurnAbout(const Vector3<double>& axis, double angle_rad, Matrix3<double>* rotation) {
  if (angle_rad == 0.0) return;
  for (int k = 0; k < 3; ++k) {
    if (std::abs(axis[k]) != 1.0) continue;
    const double s = std::sin(angle_rad) * axis[k], c = std::cos(angle_rad);
    const Vector3<double> u = rotation->col((k + 1) % 3), v = rotation->col((k + 2) % 3);
    rotation->col((k + 1) % 3) = c * u + s * v;
    rotation->col((k + 2) % 3) = c * v - s * u;
    return;
  }
  *rotation = Matrix3<double>(*rotation * AxisRotation<double>(axis, angle_rad));
}

// Sine and cosine. Errors of machines are small angles: up to 0.01 rad the series below is exact but for the last bit
// of a double, at a tenth of the cost.
template <typename T>
void SineCosine(const T& angle_rad, T* sine, T* cosine) {
  using std::cos;
  using std::sin;
  if constexpr (std::is_same_v<T, double>) {
    constexpr double kSmallRad = 0.01;  // next terms: 1e-14 / 5040 and 1e-16 / 40320
    if (std::abs(angle_rad) < kSmallRad) {
      const double squared = angle_rad * angle_rad;
      *sine = angle_rad * (1.0 - squared / 6.0 * (1.0 - squared / 20.0));
      *cosine = 1.0 - squared / 2.0 * (1.0 - squared / 12.0 * (1.0 - squared / 30.0));
      return;
    }
  }
  *sine = sin(angle_rad);
  *cosine = cos(angle_rad);
}

// Rot_x(a) * Rot_y(b) * Rot_z(c), exact; the rotation of an error transform (docs/formats.md, machine.json).
template <typename T>
Matrix3<T> RotationXyz(const T& a_rad, const T& b_rad, const T& c_rad) {
  T ca, sa, cb, sb, cc, sc;
  SineCosine(a_rad, &sa, &ca);
  SineCosine(b_rad, &sb, &cb);
  SineCosine(c_rad, &sc, &cc);
  Matrix3<T> rotation;
  rotation << cb * cc, -cb * sc, sb,                             //
      ca * sc + sa * sb * cc, ca * cc - sa * sb * sc, -sa * cb,  //
      sa * sc - ca * sb * cc, sa * cc + ca * sb * sc, ca * cb;
  return rotation;
}

}  // namespace axiscal::geometry

#endif  // AXISCAL_CORE_GEOMETRY_RIGID_H_
