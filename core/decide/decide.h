// Closing the loop by one objective: linearise at a fit, search the set of effects of least objective, fit it in full,
// judge the noise again, and once more from there until the set stays.
#ifndef AXISCAL_CORE_DECIDE_DECIDE_H_
#define AXISCAL_CORE_DECIDE_DECIDE_H_

#include <vector>

#include "core/decide/close_loop.h"

namespace axiscal::decide {

// CloseLoop without its questions to the sessions before and its simulation afterwards.
absl::StatusOr<loop::Report> Decide(const machine::Machine& machine, std::vector<instruments::MeasuringRun> fit,
                                    std::vector<instruments::MeasuringRun> check, const Options& options = {});

}  // namespace axiscal::decide

#endif  // AXISCAL_CORE_DECIDE_DECIDE_H_
