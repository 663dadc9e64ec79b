// Programs that probe (the kind of Yao 2022, Fig. 5.12), in axis positions as program.h: a sphere at each pose of a
// `centres` session by five touches, one along the tool and four 60 degrees from it; or each line of a `touch` session
// as one touch, begun and left along the tool.
#ifndef AXISCAL_CORE_PLAN_PROBING_PROGRAM_H_
#define AXISCAL_CORE_PLAN_PROBING_PROGRAM_H_

#include <string>

#include "core/machine/machine.h"
#include "core/plan/probe_writer.h"
#include "core/session/session.h"

namespace axiscal::plan {

struct ProbingOptions {
  double sphere_radius_mm = 12.5;
  double stylus_radius_mm = 3.0;
  double clearance_mm = 8.0;   // between stylus and feature where a touch begins
  double overtravel_mm = 5.0;  // beyond a plane or the side of a sphere, where a touch session's touch gives up
  double retract_mm = 100.0;   // further along the tool while rotary axes turn
  double feed_mm_min = 100.0;  // of a touch
};

inline constexpr int kTouchesPerCentre = 5;

// Body of the program: its blocks. FAILED_PRECONDITION when the linear axes do not reach a touch; INVALID_ARGUMENT on a
// number out of range or a session of another instrument.
absl::StatusOr<std::string> ProbingBlocks(const machine::Machine& machine, const session::Session& session,
                                          const ProbingOptions& options, const ProbeDialect& dialect);
absl::StatusOr<std::string> TouchBlocks(const machine::Machine& machine, const session::Session& session,
                                        const ProbingOptions& options, const ProbeDialect& dialect);

}  // namespace axiscal::plan

#endif  // AXISCAL_CORE_PLAN_PROBING_PROGRAM_H_
