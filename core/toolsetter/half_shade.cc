#include "core/toolsetter/half_shade.h"

#include <algorithm>

namespace axiscal::toolsetter {
namespace {

// An edge's crossing with the circle.
struct Crossing {
  double foot_mm = 0.0;
  double y_mm = 0.0, z_mm = 0.0;  // on the circle
};

// The crossing between the foot `inside_mm` of a point within the disc and the edge's end at `end_mm`, looked for from
// `start_mm`: Newton on y^2 + z^2 = R^2, kept in its bracket.
Crossing CrossingFrom(const ShadowEdge& edge, double radius_mm, double height_mm, double inside_mm, double end_mm,
                      double start_mm) {
  // Newton's next error is of the order of step^2 / R.
  const double small_mm = 1e-9 * radius_mm;
  Crossing crossing{start_mm, 0.0, 0.0};
  for (int i = 0; i < 60; ++i) {
    const FootPoint at = edge.AtFoot(crossing.foot_mm);
    const double z_mm = at.z_mm + height_mm, miss_mm2 = at.y_mm * at.y_mm + z_mm * z_mm - radius_mm * radius_mm;
    (miss_mm2 < 0.0 ? inside_mm : end_mm) = crossing.foot_mm;
    double step_mm = -0.5 * miss_mm2 / (at.y_per_foot * (at.y_mm + z_mm * at.slope));
    const double next_mm = crossing.foot_mm + step_mm;
    const bool is_done = std::abs(step_mm) < small_mm, is_between = (next_mm - inside_mm) * (next_mm - end_mm) < 0.0;
    if (!is_done && !is_between) step_mm = 0.5 * (inside_mm + end_mm) - crossing.foot_mm;
    crossing.foot_mm += step_mm;
    crossing.y_mm = at.y_mm + at.y_per_foot * step_mm;
    crossing.z_mm = z_mm + at.slope * at.y_per_foot * step_mm;
    if (is_done) break;
  }
  return crossing;
}

}  // namespace

double ClosedFormHeightMm(const ShadowEdge& edge, double foot_mm, double radius_mm) {
  const FootPoint at = edge.AtFoot(foot_mm);
  const double bend = edge.Bend(foot_mm) / at.y_per_foot;
  return -at.z_mm - bend * radius_mm * radius_mm / (6.0 * (1.0 + at.slope * at.slope));
}

std::optional<HalfShade> HalfShadeHeight(const ShadowEdge& edge, double radius_mm) {
  const double foot_mm = edge.FootMm(0.0);
  const FootPoint middle = edge.AtFoot(foot_mm);
  const double target_mm2 = HalfDiscMm2(radius_mm), radius_mm2 = radius_mm * radius_mm;
  // What rounding of z alone makes of the height.
  const double rounding_mm = 4e-16 * (std::abs(edge.level_mm) + edge.a * edge.rho_mm);
  // Along the edge's tangent.
  const double reach_mm = radius_mm / (std::sqrt(1.0 + middle.slope * middle.slope) * middle.y_per_foot);
  const auto from_middle = [&](double end_mm) {
    const double room_mm = 0.999 * std::abs(end_mm - foot_mm);
    return foot_mm + std::copysign(std::min(reach_mm, room_mm), end_mm);
  };
  Crossing left{from_middle(-edge.rho_mm), 0.0, 0.0}, right{from_middle(edge.rho_mm), 0.0, 0.0};
  double height_mm = ClosedFormHeightMm(edge, foot_mm, radius_mm);
  for (int i = 0; i < 30; ++i) {
    if (!(std::abs(middle.z_mm + height_mm) < radius_mm)) return std::nullopt;
    left = CrossingFrom(edge, radius_mm, height_mm, foot_mm, -edge.rho_mm, left.foot_mm);
    right = CrossingFrom(edge, radius_mm, height_mm, foot_mm, edge.rho_mm, right.foot_mm);
    const double arc_rad = 2.0 * std::numbers::pi + std::atan2(left.y_mm, -left.z_mm) -
                           std::atan2(right.y_mm, -right.z_mm);
    double under_mm2 = 0.0;
    ForEdgePoints(edge, left.foot_mm, right.foot_mm, [&](double, const FootPoint& at, double weight_mm) {
      under_mm2 += (at.z_mm + height_mm) * weight_mm;
    });
    const double area_mm2 =
        0.5 * (radius_mm2 * arc_rad - left.y_mm * left.z_mm + right.y_mm * right.z_mm) - under_mm2;
    const double width_mm = right.y_mm - left.y_mm, step_mm = (area_mm2 - target_mm2) / width_mm;
    if (!(std::abs(step_mm) > 1e-13 * radius_mm + rounding_mm))
      return HalfShade{height_mm, area_mm2, width_mm, arc_rad, left.foot_mm, right.foot_mm};
    height_mm += step_mm;
  }
  return std::nullopt;
}

}  // namespace axiscal::toolsetter
