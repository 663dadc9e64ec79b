// Where a positive command of each axis takes the tool as seen from the workpiece: what a technician compares with the
// machine in front of him to find a wrong sign before it costs a spindle. Derived from the chain at home (all axes at
// zero), never from names.
#ifndef AXISCAL_CORE_MACHINE_EXPLAIN_H_
#define AXISCAL_CORE_MACHINE_EXPLAIN_H_

#include <string>
#include <vector>

#include "core/machine/machine.h"

namespace axiscal::machine {

struct AxisMotion {
  std::string axis;
  AxisKind kind = AxisKind::kLinear;
  bool carries_workpiece = false;  // on the work branch
  // Table frame at home, unit. Linear: where the tool goes. Rotary: axis of the right-handed turn of the tool.
  Eigen::Vector3d tool_motion = Eigen::Vector3d::Zero();
  // Rotary on the tool branch: where a tip 100 mm along the tool from the last pivot goes, unit; zero where it stays.
  Eigen::Vector3d tip_motion = Eigen::Vector3d::Zero();
  // ISO 841: axes X Y Z move the tool to +X +Y +Z of the workpiece, A B C turn it right-handed about them. Other names:
  // true.
  bool follows_iso_841 = true;
};

// One entry per axis, in the machine's order. The machine must be valid.
std::vector<AxisMotion> ExplainMotions(const Machine& machine);

// "X+ moves the tool to +X" or "C+ turns the tool clockwise, looking from +Z to -Z". No line end.
std::string ToText(const AxisMotion& motion);

// The whole explanation, one line per axis, for a terminal.
std::string Explain(const Machine& machine);

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_EXPLAIN_H_
