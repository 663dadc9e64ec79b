// A `tool-setter` session (docs/formats.md) in core units: the beam, the rods and their readouts. Optional keys state
// how well beam and rods are known, 1 sigma: `beam_sigma: R_l yaw pitch`, `rod_sigma NAME: R_r R_f phi tau L_r`, mm and
// deg.
#ifndef AXISCAL_CORE_TOOLSETTER_ROD_SESSION_H_
#define AXISCAL_CORE_TOOLSETTER_ROD_SESSION_H_

#include <string>
#include <vector>

#include "core/session/session.h"
#include "core/toolsetter/rod.h"

namespace axiscal::toolsetter {

// One sigma of what is stated of the beam and a rod.
struct BeamSigma {
  double radius_mm = 0.0, yaw_rad = 0.0, pitch_rad = 0.0;
};
struct RodSigma {
  double radius_mm = 0.0, fillet_mm = 0.0, face_rad = 0.0, azimuth_rad = 0.0, length_mm = 0.0;
};

struct MeasuredRod {
  std::string name;  // "rod-2", or "rod-2@30": the same rod with its holder turned
  Rod rod;
  RodSigma sigma;
  std::vector<double> readouts_mm;  // spindle Z at the trigger; none: the rod was not measured

  // What stands before the '@': rods of one body share the errors of their length and face.
  std::string body() const { return name.substr(0, name.find('@')); }
};

struct RodSession {
  std::string session;
  double sigma_mm = 0.0;          // of one readout
  double spindle_at_home_mm = 0;  // z of the spindle's reference point at home (`tool_tip_mm`)
  Beam beam;
  BeamSigma beam_sigma;
  std::vector<MeasuredRod> rods;
};

// INVALID_ARGUMENT naming session, key and rule.
absl::StatusOr<RodSession> ReadRodSession(const session::Session& session);

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_ROD_SESSION_H_
