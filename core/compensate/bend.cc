#include "core/compensate/bend.h"

#include <algorithm>
#include <cmath>

namespace axiscal::compensate {

using machine::ErrorTerm;

Bend BendOf(const ErrorTerm& term, const Pose& from, const Pose& to) {
  double amplitude = 0;
  for (int i = 0; i < shapes::BasisCount(term.shape); ++i) amplitude += std::abs(term.amplitude[i]);
  const auto along = [&](int axis, double* largest) {
    *largest = std::max(std::abs(from.position[axis]), std::abs(to.position[axis]));
    return std::abs(to.position[axis] - from.position[axis]);
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
  // Of the others only those are carried that stand still along a move: backlash, and time and temperature as stated.
  return {amplitude, 0, 0};
}

}  // namespace axiscal::compensate
