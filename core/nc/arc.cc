#include "core/nc/arc.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace axiscal::nc {
namespace {

constexpr double kFullTurn = 2.0 * std::numbers::pi;
constexpr double kSamePointMm = 1e-9;  // positions are multiples of 1e-10 mm

}  // namespace

Eigen::Vector2d Arc::At(double t) const {
  const double radius = start_radius_mm + t * (end_radius_mm - start_radius_mm);
  const double angle = start_rad + t * sweep_rad;
  return centre_mm + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

double RadiusToleranceMm(double radius_mm, double least_mm) { return std::clamp(1e-3 * radius_mm, least_mm, 0.05); }

absl::StatusOr<Arc> ArcAboutCentre(const Eigen::Vector2d& start_mm, const Eigen::Vector2d& end_mm,
                                   const Eigen::Vector2d& centre_mm, bool is_counterclockwise) {
  Arc arc;
  arc.centre_mm = centre_mm;
  const Eigen::Vector2d from = start_mm - centre_mm, to = end_mm - centre_mm;
  arc.start_radius_mm = from.norm();
  arc.end_radius_mm = to.norm();
  if (arc.start_radius_mm < kSamePointMm) return absl::InvalidArgumentError("the arc's radius is zero");
  const double apart_mm = std::abs(arc.start_radius_mm - arc.end_radius_mm);
  if (apart_mm > RadiusToleranceMm(arc.start_radius_mm)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("the arc's end is %.4f mm off the circle about its centre", apart_mm));
  }
  arc.start_rad = std::atan2(from.y(), from.x());
  if ((end_mm - start_mm).norm() < kSamePointMm) {
    arc.sweep_rad = is_counterclockwise ? kFullTurn : -kFullTurn;
    return arc;
  }
  // Of the angle between the two, so that a small one keeps its digits.
  double sweep = std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
  if (is_counterclockwise && sweep <= 0) sweep += kFullTurn;
  if (!is_counterclockwise && sweep >= 0) sweep -= kFullTurn;
  arc.sweep_rad = sweep;
  return arc;
}

absl::StatusOr<Arc> ArcOfRadius(const Eigen::Vector2d& start_mm, const Eigen::Vector2d& end_mm, double radius_mm,
                                bool is_counterclockwise) {
  const Eigen::Vector2d chord = end_mm - start_mm;
  const double length = chord.norm(), radius = std::abs(radius_mm);
  if (length < kSamePointMm) return absl::InvalidArgumentError("an arc with a radius word has equal ends");
  if (length > 2.0 * radius + RadiusToleranceMm(radius)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("the arc's ends are %.4f mm apart, more than twice its radius of %.4f mm", length, radius));
  }
  const double height = std::sqrt(std::max(0.0, radius * radius - 0.25 * length * length));
  const Eigen::Vector2d left = Eigen::Vector2d(-chord.y(), chord.x()) / length;
  const bool is_left = is_counterclockwise == (radius_mm > 0);
  return ArcAboutCentre(start_mm, end_mm, 0.5 * (start_mm + end_mm) + (is_left ? height : -height) * left,
                        is_counterclockwise);
}

Eigen::Vector2d FitCentre(const Eigen::Vector2d& start_mm, const Eigen::Vector2d& end_mm, bool is_full,
                          const Eigen::Matrix2Xd& points) {
  if (is_full) {
    // |p - s|^2 = 2 (p - s) (c - s) for every point of a circle through s: linear in the centre.
    const Eigen::Matrix2Xd from_start = points.colwise() - start_mm;
    const Eigen::Matrix2d normal = 4.0 * from_start * from_start.transpose();
    const Eigen::Vector2d right = 2.0 * from_start * from_start.colwise().squaredNorm().transpose();
    return start_mm + normal.ldlt().solve(right);
  }
  const Eigen::Vector2d middle = 0.5 * (start_mm + end_mm), chord = end_mm - start_mm;
  const Eigen::Vector2d across = Eigen::Vector2d(-chord.y(), chord.x()).normalized();
  double ab = 0, bb = 0;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector2d from_middle = points.col(i) - middle;
    const double a = from_middle.squaredNorm() - 0.25 * chord.squaredNorm(), b = from_middle.dot(across);
    ab += a * b;
    bb += b * b;
  }
  return middle + across * (ab / (2.0 * bb));
}

}  // namespace axiscal::nc
