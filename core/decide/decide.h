// Closing the loop by one objective: linearise at a fit, search the set of effects of least objective, fit it in full,
// judge the noise again, and once more from there until the set stays.
#ifndef AXISCAL_CORE_DECIDE_DECIDE_H_
#define AXISCAL_CORE_DECIDE_DECIDE_H_

#include <vector>

#include "core/loop/close_loop.h"
#include "core/objective/policy.h"

namespace axiscal::decide {

// The report and errors of loop::CloseLoop.
absl::StatusOr<loop::Report> Decide(const machine::Machine& machine, std::vector<instruments::MeasuringRun> fit,
                                    std::vector<instruments::MeasuringRun> check, const loop::Options& options = {},
                                    const objective::Policy& policy = {});

}  // namespace axiscal::decide

#endif  // AXISCAL_CORE_DECIDE_DECIDE_H_
