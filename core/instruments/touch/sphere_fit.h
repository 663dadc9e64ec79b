// The sphere through the stylus centres of touches of one ball.
#ifndef AXISCAL_CORE_INSTRUMENTS_TOUCH_SPHERE_FIT_H_
#define AXISCAL_CORE_INSTRUMENTS_TOUCH_SPHERE_FIT_H_

#include <Eigen/Core>
#include <cstddef>
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

// A point that is not on the sphere of the others, by its index.
struct OffSphere {
  size_t point = 0;
  double off_mm = 0.0;  // distance from that sphere, >= 0
};

struct SphereOfMost {
  std::optional<Sphere> sphere;  // of the points that agree; nothing where they fix none
  std::vector<OffSphere> off;    // the others, each once; the first is farthest off, or was seen to be off first
  int fits = 0;                  // spheres that were fitted: the cost, each linear in its points
};

// The sphere of the points that agree within `gate_mm` > 0. A point is taken to be off when it stands farther than that
// from the sphere of the others; at most a third of the points and one more are, as more say that something is wrong
// with all. Fits at most kMostSphereFits spheres, all but a few of at most 64 points, whatever the points are.
inline constexpr int kMostSphereFits = 240;
SphereOfMost FitSphereOfMost(const std::vector<Eigen::Vector3d>& points_mm, double gate_mm);

}  // namespace axiscal::touch

#endif  // AXISCAL_CORE_INSTRUMENTS_TOUCH_SPHERE_FIT_H_
