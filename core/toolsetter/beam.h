// The laser beam of a tool setter, nearly parallel to machine X (Fang 2022, 2.23). Frame `photodiode`: origin at the
// beam's reference point, x along the beam, y = -sin a X + cos a Y, z = -cos a sin b X - sin a sin b Y + cos b Z
// (2.27). A tool is seen as its shadow in the photodiode's y and z; the trigger fires when half of the beam's disc is
// shaded.
#ifndef AXISCAL_CORE_TOOLSETTER_BEAM_H_
#define AXISCAL_CORE_TOOLSETTER_BEAM_H_

#include "core/base/status.h"

namespace axiscal::toolsetter {

struct Beam {
  double radius_mm = 0.2;
  double yaw_rad = 0.0;    // a: direction (cos b cos a, cos b sin a, sin b)
  double pitch_rad = 0.0;  // b
};

inline constexpr double kMaxBeamRadiusMm = 5.0;
inline constexpr double kMaxBeamTiltDeg = 20.0;  // beyond lies another unit or another axis of the beam

// INVALID_ARGUMENT naming field, value and rule.
absl::Status Validate(const Beam& beam);

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_BEAM_H_
