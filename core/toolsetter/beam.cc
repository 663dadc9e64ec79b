#include "core/toolsetter/beam.h"

#include <cmath>

#include "core/base/units.h"

namespace axiscal::toolsetter {

absl::Status Validate(const Beam& beam) {
  if (!(beam.radius_mm > 0.0 && beam.radius_mm <= kMaxBeamRadiusMm)) {
    return absl::InvalidArgumentError(absl::StrFormat("beam: R_l = %g mm, expected a radius above 0 and at most %g mm",
                                                      beam.radius_mm, kMaxBeamRadiusMm));
  }
  const std::pair<const char*, double> angles[] = {{"yaw", beam.yaw_rad}, {"pitch", beam.pitch_rad}};
  for (const auto& [name, angle_rad] : angles) {
    if (std::abs(angle_rad) <= kMaxBeamTiltDeg * base::kRadPerDeg) continue;
    return absl::InvalidArgumentError(absl::StrFormat(
        "beam: %s = %g deg, expected within +-%g: the beam is nearly parallel to X, angles are in degrees", name,
        angle_rad * base::kDegPerRad, kMaxBeamTiltDeg));
  }
  if (!std::isfinite(beam.yaw_rad + beam.pitch_rad)) return absl::InvalidArgumentError("beam: an angle is no number");
  return absl::OkStatus();
}

}  // namespace axiscal::toolsetter
