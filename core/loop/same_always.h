// Effects that are one effect by two names: they move the tool against the table alike in every state that the machine
// can take, but for where each session's ball is mounted, so that no measurement of any kind tells them: EZX:drift and
// EZZ:drift, or the first harmonics of EXC and EYC.
#ifndef AXISCAL_CORE_LOOP_SAME_ALWAYS_H_
#define AXISCAL_CORE_LOOP_SAME_ALWAYS_H_

#include <vector>

#include "core/machine/error_model.h"

namespace axiscal::loop {

// Entry i: the first term that is the same effect as term i; i itself where there is none before it. Tools of any
// length along the spindle that holds a tool point at `tip_mm` (machine frame at home); the table ball anywhere.
std::vector<int> FirstOfTheSame(const machine::Machine& machine, const Eigen::Vector3d& tip_mm,
                                const std::vector<machine::ErrorTerm>& terms);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_SAME_ALWAYS_H_
