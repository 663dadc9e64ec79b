// Figures of R-test sessions in which one rotary axis moves and the linear axes follow the ball: how far the tool point
// leaves the ball radially, tangentially and along the axis, and along the machine's axes. What ISO 10791-6 asks for of
// rotary axes by R-test; its text was not at hand: names and formulas are *assumed* (docs/figures.md).
//   e(k)          reading k (tool point - table ball, table's frame) less the mean of all: where the ball was mounted
//   radial        e . r, r from the axis to the ball or, of a head, to the tool point; tangential e . t, t the way it
//                 takes when the axis rises; axial e . a, a = r x t the axis
#ifndef AXISCAL_CORE_FIGURES_ROTARY_SESSIONS_H_
#define AXISCAL_CORE_FIGURES_ROTARY_SESSIONS_H_

#include "core/base/status.h"
#include "core/figures/figures.h"

namespace axiscal::figures {

// `axis` is the rotary one that moves. INVALID_ARGUMENT with the reason where the ball or tool point stands on it.
absl::StatusOr<MeasuredTest> RotaryTest(const machine::Machine& machine, const instruments::MeasuringRun& run,
                                        int axis);

}  // namespace axiscal::figures

#endif  // AXISCAL_CORE_FIGURES_ROTARY_SESSIONS_H_
