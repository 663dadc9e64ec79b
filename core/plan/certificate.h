// What a plan will reach, before anything is measured: the identification of the readings that a machine without errors
// would give, set-ups in their nominal places, with the stated sigmas. So the certificate counts what an identification
// counts: set-ups that are fitted along, priors, stated facts (expansions, certified values) and what cannot be told
// apart. Readings are taken as independent; a machine that does not repeat as well as `sigma_um` says reaches less.
#ifndef AXISCAL_CORE_PLAN_CERTIFICATE_H_
#define AXISCAL_CORE_PLAN_CERTIFICATE_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/identify/result.h"
#include "core/predict/over_poses.h"
#include "core/session/session.h"

namespace axiscal::plan {

// What the uncertainties of the identified errors leave at the tool point over the box, table's frame, of a machine
// that is corrected for them.
struct LeftOver {
  predict::ChanceOver chance;                          // rms over the box and largest: exceeded in 5 of 100 cases
  std::vector<double> positions;                       // where it is least certain: of each axis, mm or rad
  Eigen::Vector3d sigma_mm = Eigen::Vector3d::Zero();  // there
  std::vector<std::string> by;  // errors whose uncertainties make most of it there, the largest first
};

// A combination of errors that no reading of the plan shows.
struct Unseen {
  std::string direction;  // "EX0B - EX0C"
  std::string of, unit;   // its first error, and that error's unit in files
  // How far the tool point moves where `of` is one unit (the others along the direction), at the pose where it does
  // most, mm: as programmed, and once work offset and tool data are set anew.
  double as_programmed_mm = 0.0, set_anew_mm = 0.0;
};

struct Certificate {
  std::vector<identify::Estimate> errors;        // no values; sigma NaN where the plan does not tell it
  std::vector<identify::Result::Stated> stated;  // what of sigma comes from facts that readings do not change
  int sessions = 0, readings = 0;
  double seconds = 0.0;  // with mounting, once per set-up
  int poses = 0;
  LeftOver as_programmed;
  LeftOver set_anew;  // less the work offset and the tool's length and centre that suit all poses best
  std::vector<Unseen> unseen;
};

// `plan`: sessions without readings. INVALID_ARGUMENT as PlannedRun, MakeProblem; FAILED_PRECONDITION where they have
// fewer readings than unknowns.
absl::StatusOr<Certificate> Certify(const machine::Machine& machine, const machine::ErrorModel& model,
                                    const std::vector<session::Session>& plan, const predict::Workspace& workspace);

}  // namespace axiscal::plan

#endif  // AXISCAL_CORE_PLAN_CERTIFICATE_H_
