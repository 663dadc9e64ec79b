#include "core/compensate/bend.h"

#include <algorithm>
#include <cmath>

namespace axiscal::compensate {

using machine::ErrorTerm;

double GapOf(const shapes::Tabulated& map, int axis) {
  const shapes::Node& node = axis == map.second_axis ? map.second : map.node;
  double gap = std::min(node.before, node.after);
  if (axis == map.axis && map.is_tied) gap = std::min({gap, map.tied_to.before, map.tied_to.after});
  return gap;
}

Bend BendOf(const ErrorTerm& term, const AxisValues& from, const AxisValues& to) {
  double amplitude = 0;
  for (int i = 0; i < shapes::BasisCount(term.shape); ++i) amplitude += std::abs(term.amplitude[i]);
  const auto along = [&](int axis, double* largest) {
    *largest = std::max(std::abs(from[axis]), std::abs(to[axis]));
    return std::abs(to[axis] - from[axis]);
  };
  double largest = 0;
  if (const auto* linear = std::get_if<shapes::Linear>(&term.shape)) {
    const double travel = along(linear->axis, &largest) / linear->reference;
    return {amplitude * largest / linear->reference, amplitude * travel, 0};
  }
  if (const auto* quadratic = std::get_if<shapes::Quadratic>(&term.shape)) {
    const double travel = along(quadratic->axis, &largest) / quadratic->reference;
    largest /= quadratic->reference;
    return {amplitude * largest * largest, 2 * amplitude * largest * travel, 2 * amplitude * travel * travel};
  }
  if (const auto* harmonic = std::get_if<shapes::Harmonic>(&term.shape)) {
    const double turn = along(harmonic->axis, &largest) * std::abs(harmonic->frequency);
    return {amplitude, amplitude * turn, amplitude * turn * turn};
  }
  if (const auto* bump = std::get_if<shapes::Bump>(&term.shape)) {
    // exp(-u^2) has slopes up to sqrt(2 / e) and curvatures up to 2; six widths away nothing is left of it.
    const double low = std::min(from[bump->axis], to[bump->axis]) - bump->at;
    const double high = std::max(from[bump->axis], to[bump->axis]) - bump->at;
    if (std::min(std::abs(low), std::abs(high)) > 6.0 * bump->width && low * high > 0) return {0, 0, 0};
    const double travel = along(bump->axis, &largest) / bump->width;
    return {amplitude, 0.858 * amplitude * travel, 2.0 * amplitude * travel * travel};
  }
  if (const auto* map = std::get_if<shapes::Tabulated>(&term.shape)) {
    // Linear between nodes, with corners at them: the departure from a straight line is at most the whole change, and a
    // curvature of eight times the change has that departure.
    double travel = along(map->axis, &largest) / GapOf(*map, map->axis);
    if (map->second_axis >= 0) travel += along(map->second_axis, &largest) / GapOf(*map, map->second_axis);
    const double size = (map->is_tied ? 2.0 : 1.0) * amplitude, change = std::min(size * travel, 2.0 * size);
    return {size, change, 8.0 * change};
  }
  // The other carried terms do not change along a move: backlash, and terms of a stated time or temperature.
  return {amplitude, 0, 0};
}

}  // namespace axiscal::compensate
