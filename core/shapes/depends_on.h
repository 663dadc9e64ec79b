// What a shape looks at beside axes: what must be known of a state where an error of this shape acts.
#ifndef AXISCAL_CORE_SHAPES_DEPENDS_ON_H_
#define AXISCAL_CORE_SHAPES_DEPENDS_ON_H_

#include "core/shapes/shape.h"

namespace axiscal::shapes {

// The clock, also for a speed.
inline bool DependsOnTime(const Shape& shape) {
  return std::holds_alternative<Drift>(shape) || std::holds_alternative<DriftExp>(shape) ||
         std::holds_alternative<Lag>(shape);
}
inline bool DependsOnTemperature(const Shape& shape) { return std::holds_alternative<Thermal>(shape); }

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_DEPENDS_ON_H_
