// A machine tool (or any serial chain) as two branches of axes that start at the bed: docs/formats.md, machine.json.
// Frame `machine`: right-handed, fixed to the bed, as the description means it with all axes at zero.
#ifndef AXISCAL_CORE_MACHINE_MACHINE_H_
#define AXISCAL_CORE_MACHINE_MACHINE_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/machine/error_symbol.h"

namespace axiscal::machine {

enum class AxisKind { kLinear, kRotary };

// How a rotary axis counts, which says the way that an absolute word of a program takes it.
enum class RollOver {
  kUnstated,
  kNone,          // it counts on: 370 deg is a turn behind 10 deg, and the way is the difference of the numbers
  kShortest,      // it counts from 0 to 360 deg; the shorter way round
  kBySign,        // the same; the word's sign is the sense of rotation, its size the position
  kByDifference,  // the same; the difference of the two positions in 0 to 360 deg, never across 0
};

struct Axis {
  std::string name;
  AxisKind kind = AxisKind::kLinear;
  // Unit vector, machine frame at home: where the carried body moves for a positive command (linear), or the axis of
  // its right-handed rotation (rotary). So ISO 841's primed axes need no other convention.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  // A nominal point on a rotary axis, machine frame at home; its errors act about it. The origin for a linear axis.
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();
  // Travel limits of the command (mm or rad) where the description states them.
  std::optional<double> min_position, max_position;
  // Of a rotary axis. One with travel limits does not roll over.
  RollOver roll_over = RollOver::kUnstated;
};

inline constexpr int kMaxAxes = 14;

struct Machine {
  std::string id;
  std::string structure;               // ISO 10791-6 code, informative: w-C'bZYXB(C1)-t
  std::vector<Axis> axes;              // in the order of the bed outwards: tool branch first, then work branch
  std::vector<int> tool_branch;        // indices into `axes`, from the bed outwards
  std::vector<int> work_branch;
  Eigen::Vector3d tool_direction = Eigen::Vector3d(0, 0, -1);  // unit, from spindle nose to tip, machine frame at home
  std::vector<ErrorSymbol> declared;   // the constant errors that the model holds now

  int axis_count() const { return static_cast<int>(axes.size()); }
  // Joints are the axes, then T (spindle and tool), then W (table ball).
  int tool_joint() const { return axis_count(); }
  int work_joint() const { return axis_count() + 1; }
  int joint_count() const { return axis_count() + 2; }
};

// Index into `axes`, or -1.
int FindAxis(const Machine& machine, const std::string& name);
// Index of the joint (axis, T or W), or -1.
int FindJoint(const Machine& machine, const std::string& name);
// "X", "T" ... of a joint.
std::string JointName(const Machine& machine, int joint);

// INVALID_ARGUMENT that names field, value and rule: unit directions, finite numbers, every axis in exactly one branch,
// known axes in `declared`, at most kMaxAxes axes, an id of letters, digits, '-', '_' and '.'.
absl::Status Validate(const Machine& machine);

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_MACHINE_H_
