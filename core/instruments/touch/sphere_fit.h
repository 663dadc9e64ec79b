// The sphere through the stylus centres of touches of one ball.
#ifndef AXISCAL_CORE_INSTRUMENTS_TOUCH_SPHERE_FIT_H_
#define AXISCAL_CORE_INSTRUMENTS_TOUCH_SPHERE_FIT_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace axiscal::touch {

struct Sphere {
  Eigen::Vector3d centre_mm;
  double radius_mm = 0.0;             // of the touched ball plus the stylus
  double rms_mm = 0.0, max_mm = 0.0;  // distances of the points from the sphere; rms over all points
};

// Least squares of the distances. Nothing when the points, at least five, do not fix centre and radius: flatter caps
// than some 0.1 of the radius.
std::optional<Sphere> FitSphere(const std::vector<Eigen::Vector3d>& points_mm);

}  // namespace axiscal::touch

#endif  // AXISCAL_CORE_INSTRUMENTS_TOUCH_SPHERE_FIT_H_
