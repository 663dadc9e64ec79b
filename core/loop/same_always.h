// Effects that are one effect by two names: they move the tool against the table alike in every state that the machine
// can take, but for where each session's ball is mounted and for what declared errors take up, so that no measurement
// of any kind tells them: EZX:drift and EZZ:drift, the first harmonics of EXC and EYC, or, under a turntable whose axis
// position is declared, those of EYA and EZA.
#ifndef AXISCAL_CORE_LOOP_SAME_ALWAYS_H_
#define AXISCAL_CORE_LOOP_SAME_ALWAYS_H_

#include <vector>

#include "core/machine/error_model.h"

namespace axiscal::loop {

// Entry i: the first term that is the same effect as term i; i itself where there is none before it. Tools of any
// length along the spindle that holds a tool point at `tip_mm` (machine frame at home); the table ball anywhere.
std::vector<int> FirstOfTheSame(const machine::Machine& machine, const Eigen::Vector3d& tip_mm,
                                const std::vector<machine::ErrorTerm>& terms);

// Those of `others` that are `effect` by another name.
std::vector<machine::ErrorTerm> SameAlways(const machine::Machine& machine, const Eigen::Vector3d& tip_mm,
                                           const machine::ErrorTerm& effect,
                                           const std::vector<machine::ErrorTerm>& others);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_SAME_ALWAYS_H_
