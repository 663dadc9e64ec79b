// A corner between two moves of a plane, rounded or chamfered. Lengths in mm.
#ifndef AXISCAL_CORE_NC_CORNER_GEOMETRY_H_
#define AXISCAL_CORE_NC_CORNER_GEOMETRY_H_

#include <Eigen/Core>

#include "core/base/status.h"
#include "core/nc/arc.h"

namespace axiscal::nc {

// A straight move, or one along a circle (`arc`).
struct CornerMove {
  Eigen::Vector2d start_mm = Eigen::Vector2d::Zero(), end_mm = Eigen::Vector2d::Zero();
  bool is_arc = false;
  Arc arc;
};

// What stands in place of the corner.
struct CornerPath {
  bool is_none = false;  // so small that it is nothing
  Eigen::Vector2d from_mm = Eigen::Vector2d::Zero(), to_mm = Eigen::Vector2d::Zero();
  bool is_arc = false;  // about `centre_mm`
  Eigen::Vector2d centre_mm = Eigen::Vector2d::Zero();
  bool is_counterclockwise = false;
  // By how much points of it move for each rad that one move turns to the other, at most, mm.
  double reach_mm = 0;
  // What is left of both moves, mm.
  double left_of_from_mm = 0, left_of_to_mm = 0;
};

// By how much the contour turns at the corner, rad, to the left > 0.
double TurnAtCorner(const CornerMove& from, const CornerMove& to);

// An arc of `radius_mm` that touches both moves. INVALID_ARGUMENT where it does not fit, with lengths.
absl::StatusOr<CornerPath> RoundCorner(const CornerMove& from, const CornerMove& to, double radius_mm);
// A straight line between points that stand `leg_mm` in front of the corner and behind it; with `is_length` that is its
// own length. INVALID_ARGUMENT likewise, and beside arcs: controls differ there.
absl::StatusOr<CornerPath> ChamferCorner(const CornerMove& from, const CornerMove& to, double size_mm, bool is_length);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_CORNER_GEOMETRY_H_
