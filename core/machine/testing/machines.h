// Machines for tests: the three structures of the loop cases (tests/data/loop).
#ifndef AXISCAL_CORE_MACHINE_TESTING_MACHINES_H_
#define AXISCAL_CORE_MACHINE_TESTING_MACHINES_H_

#include <map>
#include <string>
#include <vector>

#include "core/machine/machine.h"

namespace axiscal::machine::testing {

inline Axis Linear(const std::string& name, const Eigen::Vector3d& direction) {
  return {name, AxisKind::kLinear, direction, Eigen::Vector3d::Zero(), {}, {}};
}

inline Axis Rotary(const std::string& name, const Eigen::Vector3d& direction, const Eigen::Vector3d& point_mm) {
  return {name, AxisKind::kRotary, direction, point_mm, {}, {}};
}

inline Machine Make(const std::string& id, const std::vector<Axis>& tool_branch, const std::vector<Axis>& work_branch,
                    const std::vector<std::string>& declared) {
  Machine machine;
  machine.id = id;
  for (const Axis& axis : tool_branch) {
    machine.tool_branch.push_back(machine.axis_count());
    machine.axes.push_back(axis);
  }
  for (const Axis& axis : work_branch) {
    machine.work_branch.push_back(machine.axis_count());
    machine.axes.push_back(axis);
  }
  for (const std::string& symbol : declared) machine.declared.push_back(*ParseErrorSymbol(symbol));
  return machine;
}

inline const Eigen::Vector3d kX(1, 0, 0), kY(0, 1, 0), kZ(0, 0, 1), kOrigin(0, 0, 0);

// w-C'bZYXB(C1)-t, multi-tasking (Yao 2022).
inline Machine MultiTasking() {
  return Make("mt", {Linear("Z", kZ), Linear("Y", kY), Linear("X", kX), Rotary("B", kY, kOrigin)},
              {Rotary("C", kZ, kOrigin)}, {"EA0B", "EC0B", "EB0B", "EX0C", "EY0C", "EA0C", "EB0C", "EX0T", "EZ0T"});
}

// w-C'A'Y'bXZ(C1)-t, tilting table.
inline Machine TiltingTable() {
  return Make("tt", {Linear("X", kX), Linear("Z", kZ)},
              {Linear("Y", -kY), Rotary("A", kX, {0, 0, -50}), Rotary("C", kZ, kOrigin)},
              {"EY0A", "EZ0A", "EB0A", "EC0A", "EX0C", "EY0C", "EA0C", "EB0C", "EC0Y", "EA0Z", "EB0Z"});
}

// w-C'Y'X'bZB(C1)-t, swivel head and rotary table.
inline Machine SwivelHead() {
  return Make("ht", {Linear("Z", kZ), Rotary("B", kY, kOrigin)},
              {Linear("X", -kX), Linear("Y", -kY), Rotary("C", kZ, kOrigin)},
              {"EZ0T", "EA0B", "EC0B", "EB0B", "EX0C", "EY0C", "EA0C", "EB0C", "EC0Y", "EA0Z", "EB0Z"});
}

}  // namespace axiscal::machine::testing

#endif  // AXISCAL_CORE_MACHINE_TESTING_MACHINES_H_
