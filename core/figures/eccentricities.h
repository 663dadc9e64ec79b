// Eccentricities of ball-bar runs in which one rotary axis turns (Yao 2022, ch. 2): the centre of the polar trace with
// a free radius, per run and sense,  dL = r0 + e . p(q)  (instruments/eccentricity/eccentricity_path.h).
#ifndef AXISCAL_CORE_FIGURES_ECCENTRICITIES_H_
#define AXISCAL_CORE_FIGURES_ECCENTRICITIES_H_

#include <Eigen/Core>
#include <vector>

#include "core/base/status.h"
#include "core/figures/figures.h"
#include "core/instruments/eccentricity/eccentricity_path.h"
#include "core/session/session.h"

namespace axiscal::figures {

struct Eccentricity {
  int sense = 0;  // 1: the axis rose, -1: it fell
  int readings = 0;
  Eigen::Vector3d centre_mm, sigma_mm;  // NaN for what the axis does not show; readings taken as independent
  double radius_mm = 0.0;               // r0: beside the bar's length
};

struct RunEccentricities {
  eccentricity::Path path;
  std::vector<Eccentricity> by_sense;  // of senses with enough readings
};

// INVALID_ARGUMENT with the reason where the run is no such path, or neither sense has ten readings over 30 deg.
absl::StatusOr<RunEccentricities> EccentricitiesOf(const machine::Machine& machine,
                                                   const instruments::MeasuringRun& run);

// As figures, with what noise does to them.
MeasuredTest EccentricityTest(const machine::Machine& machine, const instruments::MeasuringRun& run,
                              const RunEccentricities& found);

// The session of instrument `eccentricity` (docs/formats.md) that the ball-bar sessions make: a run each, named after
// its session, a line for each sense; `name`: the session's own. INVALID_ARGUMENT where they have not one mounting
// (tool, ball, bar, stated set-up) or one of them is no such path.
absl::StatusOr<session::Session> EccentricitySession(const machine::Machine& machine,
                                                     const std::vector<session::Session>& sessions,
                                                     const std::string& name);

}  // namespace axiscal::figures

#endif  // AXISCAL_CORE_FIGURES_ECCENTRICITIES_H_
