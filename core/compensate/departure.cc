// How far corrections bend along moves, at most.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/units.h"
#include "core/compensate/bend.h"
#include "core/compensate/carried.h"
#include "core/compensate/compensator_impl.h"

namespace axiscal::compensate {
namespace {

using machine::ErrorTerm;

constexpr double kSmoothTurnRad = 15.0 * base::kRadPerDeg;
constexpr double kSmoothTravelMm = 250.0;  // a quadratic shows in any three samples

}  // namespace

void Compensator::Impl::MeasureErrors() {
  fixed_lever_mm = options.tool_tip_mm.norm();
  for (int i = 0; i < machine.axis_count(); ++i) {
    const machine::Axis& axis = machine.axes[i];
    fixed_lever_mm += 2.0 * axis.point_mm.norm();
    smooth_travel[i] = axis.kind == machine::AxisKind::kRotary ? kSmoothTurnRad : kSmoothTravelMm;
  }
  for (const ErrorTerm& one : carried.terms) {
    const ErrorTerm term = AsStated(one, options);
    if (std::holds_alternative<shapes::Constant>(term.shape)) {
      (machine::IsAngle(term.component) ? angle_errors_rad : translation_errors_mm) += std::abs(term.amplitude[0]);
      constant[term.joint][static_cast<int>(term.component)] += term.amplitude[0];
    } else {
      is_constant = false;
      varying.push_back(term);
      if (std::find(varying_joints.begin(), varying_joints.end(), term.joint) == varying_joints.end())
        varying_joints.push_back(term.joint);
    }
    if (const auto* bump = std::get_if<shapes::Bump>(&term.shape))
      smooth_travel[bump->axis] = std::min(smooth_travel[bump->axis], 0.5 * bump->width);
    if (const auto* map = std::get_if<shapes::Tabulated>(&term.shape)) {
      constexpr double kShareOfGap = 0.25;  // a map is linear between nodes: what bends is near them
      smooth_travel[map->axis] = std::min(smooth_travel[map->axis], kShareOfGap * GapOf(*map, map->axis));
      if (map->second_axis >= 0)
        smooth_travel[map->second_axis] =
            std::min(smooth_travel[map->second_axis], kShareOfGap * GapOf(*map, map->second_axis));
    }
    const auto keep_smooth = [&](int axis, const shapes::Span& span, int order) {
      smooth_travel[axis] = std::min(smooth_travel[axis], SmoothTravel(span, order));
    };
    if (const auto* curve = shapes::CurveOf(term.shape))
      keep_smooth(curve->axis, curve->span, curve->span.OrderOf(curve->functions - 1, shapes::Curve::kFirst));
    if (const auto* crossed = std::get_if<shapes::Crossed>(&term.shape)) {
      const int last = crossed->each - 1;
      keep_smooth(crossed->axis, crossed->span, crossed->span.OrderOf(last, shapes::Crossed::kFirst));
      keep_smooth(crossed->second_axis, crossed->second, crossed->second.OrderOf(last, shapes::Crossed::kFirst));
    }
    if (const auto* harmonic = std::get_if<shapes::Harmonic>(&term.shape)) {
      const double eighth = 0.25 * std::numbers::pi / std::max(std::abs(harmonic->frequency), 1e-9);
      smooth_travel[harmonic->axis] = std::min(smooth_travel[harmonic->axis], eighth);
    }
  }
}

Compensator::Impl::Extent Compensator::Impl::ExtentOf(const AxisValues& from, const AxisValues& to) const {
  Extent extent{0, 0, fixed_lever_mm};
  for (int i = 0; i < machine.axis_count(); ++i) {
    const double change = std::abs(to[i] - from[i]);
    if (machine.axes[i].kind == machine::AxisKind::kRotary) {
      extent.turn_rad += 2.0 * change;
    } else {
      extent.travel_mm += change;
      extent.lever_mm += std::max(std::abs(from[i]), std::abs(to[i]));
    }
  }
  return extent;
}

double Compensator::Impl::ErrorSlope(const Pose& pose) const {
  double lever_mm = fixed_lever_mm, slope = 0;
  for (const int axis : linear_axes) lever_mm += std::abs(pose.position[axis]);
  for (const ErrorTerm& term : varying) {
    double amplitude = 0;
    for (int i = 0; i < shapes::BasisCount(term.shape); ++i) amplitude += std::abs(term.amplitude[i]);
    if (machine::IsAngle(term.component)) amplitude *= lever_mm;
    if (const auto* map = std::get_if<shapes::Tabulated>(&term.shape)) {
      for (const int axis : {map->axis, map->second_axis}) {
        if (axis < 0 || machine.axes[axis].kind == machine::AxisKind::kRotary) continue;
        slope += (map->is_tied ? 2.0 : 1.0) * amplitude / GapOf(*map, axis);
      }
      continue;
    }
    if (shapes::IsFree(term.shape)) {
      constexpr double kNearMm = 1.0;
      AxisValues near = pose.position;
      for (const std::optional<int>& of : {shapes::VariableAxis(term.shape), shapes::SecondAxis(term.shape)})
        if (of && machine.axes[*of].kind == machine::AxisKind::kLinear) near[*of] += kNearMm;
      slope += BendOf(term, pose.position, near).slope * (machine::IsAngle(term.component) ? lever_mm : 1.0) / kNearMm;
      continue;
    }
    const std::optional<int> axis = shapes::VariableAxis(term.shape);
    if (!axis || machine.axes[*axis].kind == machine::AxisKind::kRotary) continue;  // these stand still
    if (const auto* linear = std::get_if<shapes::Linear>(&term.shape)) {
      slope += amplitude / linear->reference;
    } else if (const auto* quadratic = std::get_if<shapes::Quadratic>(&term.shape)) {
      slope += 2.0 * amplitude * (std::abs(pose.position[*axis]) + 1.0) / (quadratic->reference * quadratic->reference);
    } else if (const auto* harmonic = std::get_if<shapes::Harmonic>(&term.shape)) {
      slope += amplitude * std::abs(harmonic->frequency);
    } else if (const auto* bump = std::get_if<shapes::Bump>(&term.shape)) {
      slope += 0.858 * amplitude / bump->width;
    }
  }
  return slope;
}

// The correction is a product of at most two turns per rotary axis (the errors' and the inverse's), linear in the
// linear axes: the second derivative along a move is bounded by the product rule, and a chord departs by at most an
// eighth.
double Compensator::DepartureBound(const AxisValues& from, const AxisValues& to) const {
  constexpr double kSecondOrder = 2.0;  // products of errors, axes out of square
  const auto [turn_rad, travel_mm, lever_mm] = impl_->ExtentOf(from, to);
  const double largest_mm = impl_->translation_errors_mm + impl_->angle_errors_rad * lever_mm;
  double curvature_mm = turn_rad * (turn_rad * largest_mm + 2.0 * impl_->angle_errors_rad * travel_mm);
  for (const ErrorTerm& term : impl_->varying) {
    const Bend bend = BendOf(term, from, to);
    const bool is_angle = machine::IsAngle(term.component);
    const double lever = is_angle ? lever_mm : 1.0, lever_slope = is_angle ? travel_mm : 0.0;
    curvature_mm += bend.curvature * lever + 2.0 * bend.slope * (turn_rad * lever + lever_slope) +
                    bend.size * turn_rad * (turn_rad * lever + 2.0 * lever_slope);
  }
  return kSecondOrder / 8.0 * curvature_mm;
}

// With e the error of direction and T the turn: |e| <= E, |e'| <= E1, |e''| <= E2, for constant errors E, E T, E T^2,
// for varying ones by the product rule; and J the motion of the direction by the rotary axes, the change of the
// commands is d = -J^-1 e. From |J^-1| <= 1/s, |(J^-1)'| <= T/s^2 and |(J^-1)''| <= T^2 (1/s^2 + 2/s^3) follow d' and
// d''. The linear axes follow on their lever.
double Compensator::TurnDepartureBound(const AxisValues& from, const AxisValues& to, double least_turn,
                                       double* direction_rad) const {
  constexpr double kSecondOrder = 2.0;
  *direction_rad = std::numeric_limits<double>::infinity();
  const auto [turn_rad, travel_mm, lever_mm] = impl_->ExtentOf(from, to);
  double error_rad = impl_->angle_errors_rad, error_slope_rad = error_rad * turn_rad;
  double error_curvature_rad = error_slope_rad * turn_rad;
  bool bends = turn_rad != 0;
  for (const ErrorTerm& term : impl_->varying) {
    if (!machine::IsAngle(term.component)) continue;
    const Bend bend = BendOf(term, from, to);
    bends |= bend.slope != 0 || bend.curvature != 0;
    error_rad += bend.size;
    error_slope_rad += bend.slope + bend.size * turn_rad;
    error_curvature_rad += bend.curvature + 2.0 * bend.slope * turn_rad + bend.size * turn_rad * turn_rad;
  }
  if (!bends) {
    *direction_rad = 0;
    return DepartureBound(from, to);
  }
  if (!(least_turn > turn_rad)) return std::numeric_limits<double>::infinity();
  const double least = least_turn - turn_rad, inverse = 1.0 / least;
  const double inverse_slope = turn_rad * inverse * inverse;
  const double inverse_curvature = turn_rad * turn_rad * inverse * inverse * (1.0 + 2.0 * inverse);
  const double change_rad = error_rad * inverse;
  const double slope_rad = error_rad * inverse_slope + error_slope_rad * inverse;
  const double curvature_rad =
      error_rad * inverse_curvature + 2.0 * error_slope_rad * inverse_slope + error_curvature_rad * inverse;
  // The lever turns and grows meanwhile.
  const double lever_slope_mm = turn_rad * lever_mm + travel_mm;
  const double lever_curvature_mm = turn_rad * (turn_rad * lever_mm + 2.0 * travel_mm);
  const double follow_mm =
      lever_mm * curvature_rad + 2.0 * lever_slope_mm * slope_rad + lever_curvature_mm * change_rad;
  *direction_rad = kSecondOrder / 8.0 * curvature_rad;
  return DepartureBound(from, to) + kSecondOrder / 8.0 * follow_mm;
}

}  // namespace axiscal::compensate
