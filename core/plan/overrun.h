// How far an axis goes beyond a target and comes back, so that the target is approached from the side that a plan
// states
// (`X_sense`): farther than backlash and windup reach (*assumed*; positioning tests usually state 1 to 2 mm).
#ifndef AXISCAL_CORE_PLAN_OVERRUN_H_
#define AXISCAL_CORE_PLAN_OVERRUN_H_

#include "core/base/units.h"
#include "core/machine/machine.h"

namespace axiscal::plan {

inline constexpr double kOverrunMm = 2.0, kOverrunDeg = 1.0;

// Of the axis, mm or rad.
inline double OverrunOf(const machine::Axis& axis) {
  return axis.kind == machine::AxisKind::kRotary ? kOverrunDeg * base::kRadPerDeg : kOverrunMm;
}

}  // namespace axiscal::plan

#endif  // AXISCAL_CORE_PLAN_OVERRUN_H_
