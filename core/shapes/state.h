// The state at one reading: all that the shape of an error term may depend on.
#ifndef AXISCAL_CORE_SHAPES_STATE_H_
#define AXISCAL_CORE_SHAPES_STATE_H_

#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace axiscal::shapes {

// Temperature at which thermal terms vanish: ISO 1 reference temperature.
inline constexpr double kReferenceTemperatureCelsius = 20.0;
// The channel of State::temperature_celsius.
inline constexpr char kTemperatureChannel[] = "temp_C";

inline constexpr int kMaxBasisCount = 48;  // amplitudes of one shape: of a crossed error (curve.h)

class Temperatures;

inline constexpr int kTurns = 3;  // that an axis remembers: loops within loops within loops

struct AxisState {
  double position = 0.0;  // commanded or latched, mm or rad
  double sense = 0.0;     // sense of motion: +1, -1, and 0 for an axis that does not move
  double travel_since_reversal =
      std::numeric_limits<double>::infinity();  // mm or rad; infinite before the first motion
  double speed = 0.0;                           // signed, mm/s or rad/s; 0 where the session has no times
  double acceleration = 0.0;                    // mm/s^2 or rad/s^2; 0 there too, and at a session's first and last row
  double last_move = 0.0;  // signed, mm or rad: the last one that was none of 0; 0 before the first
  // Where the axis turned, the newest first, NaN where it did not: those that it has not gone beyond since.
  std::array<double, kTurns> turned_at = {NAN, NAN, NAN};
};

// Of a touch: the unit direction in which the stylus went, in the spindle's frame (machine axes at home), its azimuth
// about the stylus and the sine of its angle to it.
struct Approach {
  bool is_touch = false;
  std::array<double, 3> direction = {0.0, 0.0, 0.0};
  double azimuth_rad = 0.0, across = 0.0;
};

struct State {
  std::span<const AxisState> axes;  // in the machine's order
  double time_s = 0.0;
  double temperature_celsius = kReferenceTemperatureCelsius;
  Approach approach = {};
  // What was recorded up to here, this state being one of its moments; null where nothing was.
  const Temperatures* temperatures = nullptr;
  int moment = 0;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_STATE_H_
