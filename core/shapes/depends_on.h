// What a shape looks at beside axes: what must be known of a state where an error of this shape acts.
#ifndef AXISCAL_CORE_SHAPES_DEPENDS_ON_H_
#define AXISCAL_CORE_SHAPES_DEPENDS_ON_H_

#include "core/shapes/shape.h"

namespace axiscal::shapes {

// The clock, also for a speed.
inline bool DependsOnTime(const Shape& shape) {
  return std::holds_alternative<Drift>(shape) || std::holds_alternative<DriftExp>(shape) ||
         std::holds_alternative<Lag>(shape) || std::holds_alternative<Acceleration>(shape) ||
         std::holds_alternative<TimeCurve>(shape) ||
         (std::holds_alternative<ThermalLag>(shape) && std::get<ThermalLag>(shape).tau_s > 0.0);
}
// From which side an axis came to its position.
inline bool DependsOnSense(const Shape& shape) {
  return std::holds_alternative<Backlash>(shape) || std::holds_alternative<BacklashCurve>(shape) ||
         std::holds_alternative<Play>(shape) || std::holds_alternative<LastMove>(shape);
}
// One clock of all sessions: what lasts longer than one of them.
inline bool NeedsOneClock(const Shape& shape) {
  return std::holds_alternative<Drift>(shape) || std::holds_alternative<DriftExp>(shape) ||
         std::holds_alternative<TimeCurve>(shape);
}
// The channel of a temperature: "temp_C", "T_spindle_C".
inline std::optional<std::string> ChannelOf(const Shape& shape) {
  if (std::holds_alternative<Thermal>(shape)) return kTemperatureChannel;
  if (const auto* lag = std::get_if<ThermalLag>(&shape)) return lag->channel;
  return std::nullopt;
}

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_DEPENDS_ON_H_
