// Circular moves in axis positions: in the plane of two linear axes, every other axis goes along linearly (helices,
// rotary axes turning meanwhile).
//
//   first(t)  = centre + radius(t) cos(start angle + t sweep)
//   second(t) = centre + radius(t) sin(start angle + t sweep)      t from 0 to 1, sweep > 0 from first towards second
// The radius goes linearly from the start's to the end's distance from the centre: rounding makes them differ.
#ifndef AXISCAL_CORE_NC_ARC_H_
#define AXISCAL_CORE_NC_ARC_H_

#include <Eigen/Core>
#include <string>

#include "core/base/status.h"

namespace axiscal::nc {

struct Arc {
  int first = -1, second = -1;  // axes of the machine
  Eigen::Vector2d centre_mm = Eigen::Vector2d::Zero();
  double start_rad = 0, sweep_rad = 0;
  double start_radius_mm = 0, end_radius_mm = 0;

  Eigen::Vector2d At(double t) const;
  double radius_mm() const { return start_radius_mm; }
};

// How far start and end may differ in their distance from the centre: 0.1 % of the radius, and at least `least_mm`; a
// larger difference is no circle to controllers. Dialect::arc_radius_tolerance_mm says how little some of them take.
inline constexpr double kRadiusToleranceMm = 0.005;
double RadiusToleranceMm(double radius_mm, double least_mm = kRadiusToleranceMm);

// By its centre: equal ends are a full circle. INVALID_ARGUMENT when the radius is zero or the ends' radii differ by
// more than RadiusToleranceMm.
absl::StatusOr<Arc> ArcAboutCentre(const Eigen::Vector2d& start_mm, const Eigen::Vector2d& end_mm,
                                   const Eigen::Vector2d& centre_mm, bool is_counterclockwise);

// By its radius: > 0 turns by at most half a turn, < 0 by more. INVALID_ARGUMENT when the ends are equal or farther
// apart than two radii.
absl::StatusOr<Arc> ArcOfRadius(const Eigen::Vector2d& start_mm, const Eigen::Vector2d& end_mm, double radius_mm,
                                bool is_counterclockwise);

// The centre, at equal distance from both ends, of the circle that comes nearest to `points` (least squares).
// `is_full`: the ends are one point. At least one point must stand off the line through the ends.
Eigen::Vector2d FitCentre(const Eigen::Vector2d& start_mm, const Eigen::Vector2d& end_mm, bool is_full,
                          const Eigen::Matrix2Xd& points);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_ARC_H_
