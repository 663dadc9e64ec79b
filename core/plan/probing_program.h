// The program that probes a sphere at each pose of a `centres` session (the kind of Yao 2022, Fig. 5.12): five touches
// with G31, one along the tool and four 60 degrees from it, each printed with DPRNT. Axis positions, as program.h.
#ifndef AXISCAL_CORE_PLAN_PROBING_PROGRAM_H_
#define AXISCAL_CORE_PLAN_PROBING_PROGRAM_H_

#include <string>

#include "core/machine/machine.h"
#include "core/session/session.h"

namespace axiscal::plan {

struct ProbingOptions {
  double sphere_radius_mm = 12.5;
  double stylus_radius_mm = 3.0;
  double clearance_mm = 8.0;   // between stylus and sphere where a touch begins
  double retract_mm = 100.0;   // further along the tool while rotary axes turn
  double feed_mm_min = 100.0;  // of a touch
};

// Body of the program: its blocks for Fanuc, Mazak and Haas controllers. FAILED_PRECONDITION when the linear axes do
// not reach a touch; INVALID_ARGUMENT on a number out of range or a session that is none of centres.
absl::StatusOr<std::string> ProbingBlocks(const machine::Machine& machine, const session::Session& session,
                                          const ProbingOptions& options);

}  // namespace axiscal::plan

#endif  // AXISCAL_CORE_PLAN_PROBING_PROGRAM_H_
