// Where rotary axes stand so that the tool has a direction over the workpiece, on the nominal machine.
#ifndef AXISCAL_CORE_NC_TILTED_AXES_H_
#define AXISCAL_CORE_NC_TILTED_AXES_H_

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/machine/machine.h"

namespace axiscal::nc {

struct AxisAngles {
  std::array<double, machine::kMaxAxes> position_rad{};  // by machine.axes, within half a turn; rotary axes alone
  int free_axis = -1;  // turns the tool about itself there: its position is open, and 0 above
  // The axis nearest to the workpiece, and the sine of the angle between it and the tool: where that is 0 it is free.
  int outer_axis = -1;
  double lever = 0.0;
};

// Both ways, or the one, to bring the tool to `direction`, a unit vector from the spindle to the tool's tip in the
// table's frame. Empty: none, or the machine has no rotary axis or more than two.
std::vector<AxisAngles> ToolAlong(const machine::Machine& machine, const Eigen::Vector3d& direction);

// The rotary axis nearest to the tool: of those in front of the table alone the first that is not turned by another.
// -1: none.
int MasterAxis(const machine::Machine& machine);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_TILTED_AXES_H_
