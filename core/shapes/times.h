// The position of an axis as a factor of a shape: q / reference. What warms up a scale or a screw moves a point in
// proportion to how far it is from the zero of the scale.
#ifndef AXISCAL_CORE_SHAPES_TIMES_H_
#define AXISCAL_CORE_SHAPES_TIMES_H_

#include "core/shapes/state.h"

namespace axiscal::shapes {

struct Times {
  static constexpr double kReferenceMm = 1000.0;  // amplitude per metre ...
  static constexpr double kReferenceRad = 1.0;    // ... or per radian

  int axis = -1;           // -1: none, and the factor is 1
  double reference = 1.0;  // mm or rad

  double FactorAt(const State& state) const { return axis < 0 ? 1.0 : state.axes[axis].position / reference; }
  bool operator==(const Times&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_TIMES_H_
