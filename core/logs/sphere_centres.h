// Centres of a sphere from the touches of a log, for sessions of `centres` (instruments/centres/centres_model.h): the
// touches at one rotary pose give the centre that a controller's cycle would report there.
#ifndef AXISCAL_CORE_LOGS_SPHERE_CENTRES_H_
#define AXISCAL_CORE_LOGS_SPHERE_CENTRES_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/machine/machine.h"

namespace axiscal::logs {

// One touch as latched: per axis of the machine, mm or rad, and its line of the log.
struct LatchedTouch {
  std::vector<double> positions;
  size_t line = 0;
};

// The touches at one pose.
struct TouchedPose {
  std::vector<LatchedTouch> touches;
};

struct CentreOptions {
  Eigen::Vector3d tip_mm, ball_mm;  // stylus centre and the sphere's centre at home, machine frame
  double contact_mm = 0.0;          // sphere + stylus radius; 0: not stated
  double gate_mm = 0.020;     // how far a touch may stand off the sphere of the others, and the radius off contact_mm
  double off_ball_mm = 25.0;  // how far a centre may stand off where ball_mm is on the nominal machine
};

struct SphereCentre {
  Eigen::Vector3d centre_mm;  // nominal tool point, bed's axes, as reported
  double radius_mm = 0.0;     // of the sphere plus the stylus, fitted
  std::string why_not;        // not empty: the pose has no centre, and why
};

struct SphereCentres {
  std::vector<SphereCentre> poses;
  double touch_sigma_mm = 0.0;      // scatter of the touches about their spheres
  Eigen::Vector3d centre_sigma_mm;  // one sigma of a centre that this scatter makes, bed's axes, rms over the poses
};

// A free radius is fitted with each centre: a stylus radius that is wrong, and a probe that triggers late, leave the
// centre where it is. A pose has no centre where fewer than five touches fix none, where a touch stands more than
// gate_mm off the sphere of the others, or where fewer than half of the other poses have its radius within the gate (a
// wrong touch along the tool shows by that alone: the four others fix no sphere). INVALID_ARGUMENT, naming the touches
// by `log_name` and line, when this is so of too many poses (touch::AreTooMany), when the median radius misses
// contact_mm by more than the gate (another stylus or sphere), or when a centre is more than off_ball_mm off ball_mm.
absl::StatusOr<SphereCentres> CentresOf(const machine::Machine& machine, const std::vector<TouchedPose>& poses,
                                        const CentreOptions& options, const std::string& log_name);

}  // namespace axiscal::logs

#endif  // AXISCAL_CORE_LOGS_SPHERE_CENTRES_H_
