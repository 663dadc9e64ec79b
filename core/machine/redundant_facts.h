// Facts that a machine's description holds and that an option or another field of it states again: where they
// contradict each other one of them is wrong, and a wrong sign doubles an error instead of removing it.
#ifndef AXISCAL_CORE_MACHINE_REDUNDANT_FACTS_H_
#define AXISCAL_CORE_MACHINE_REDUNDANT_FACTS_H_

#include <Eigen/Core>

#include "core/machine/machine.h"

namespace axiscal::machine {

// The tool point at home (machine frame, mm) as seen from the axis that swivels the tool: the outermost rotary axis of
// the tool branch that does not turn about the tool. INVALID_ARGUMENT naming both where it stands on the other side of
// that axis' point than `tool_direction` points to, within 30 deg of the opposite direction: the tool of an offset or
// angle head, or a ball on a long arm, may stand anywhere else. OK where nothing swivels the tool: nothing is known.
absl::Status CheckToolTip(const Machine& machine, const Eigen::Vector3d& tool_tip_mm);

// `structure` against the branches: w, the work branch from the workpiece to the bed, b, the tool branch from the bed,
// t; a ' behind an axis and an axis in parentheses (a spindle's own) say nothing here. INVALID_ARGUMENT naming both
// where the text has this form and the axes that both name stand in another order. OK for any other text.
absl::Status CheckStructure(const Machine& machine);

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_REDUNDANT_FACTS_H_
