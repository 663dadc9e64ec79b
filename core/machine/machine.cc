#include "core/machine/machine.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/machine/machine_limits.h"

namespace axiscal::machine {
namespace {

constexpr double kUnitTolerance = 1e-6;  // a direction written with six decimals

absl::Status Refuse(const Machine& machine, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("machine '", machine.id, "': ", what));
}

std::string Text(const Eigen::Vector3d& v) { return absl::StrFormat("[%g, %g, %g]", v.x(), v.y(), v.z()); }

absl::Status ValidateAxis(const Machine& machine, const Axis& axis) {
  if (!IsAxisName(axis.name)) {
    return Refuse(machine, absl::StrCat("axis name '", axis.name,
                                        "', expected a capital letter other than T and W, and optional digits"));
  }
  const auto same_name = [&axis](const Axis& other) { return other.name == axis.name; };
  if (std::count_if(machine.axes.begin(), machine.axes.end(), same_name) != 1) {
    return Refuse(machine, absl::StrCat("axis ", axis.name, " is there more than once"));
  }
  if (!(std::abs(axis.direction.norm() - 1.0) <= kUnitTolerance)) {
    return Refuse(machine,
                  absl::StrCat("axis ", axis.name, ": direction ", Text(axis.direction), " must have length 1"));
  }
  if (!axis.point_mm.allFinite() || axis.point_mm.cwiseAbs().maxCoeff() > kFarthestPointMm) {
    return Refuse(machine, absl::StrCat("axis ", axis.name, ": point_mm ", Text(axis.point_mm),
                                        " must be finite, at most 1e6 mm"));
  }
  if (axis.min_position && axis.max_position && !(*axis.min_position < *axis.max_position)) {
    return Refuse(machine, absl::StrCat("axis ", axis.name, ": the lower travel limit must be below the upper one"));
  }
  if (axis.kind == AxisKind::kLinear && axis.roll_over != RollOver::kUnstated) {
    return Refuse(machine, absl::StrCat("axis ", axis.name, ": only rotary axes may roll over"));
  }
  const bool rolls_over = axis.roll_over != RollOver::kUnstated && axis.roll_over != RollOver::kNone;
  if (rolls_over && (axis.min_position || axis.max_position)) {
    return Refuse(machine, absl::StrCat("axis ", axis.name, ": an axis that rolls over has no travel limits"));
  }
  return absl::OkStatus();
}

}  // namespace

bool IsMachineId(const std::string& id) {
  return !id.empty() && id.size() <= 100 && std::all_of(id.begin(), id.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '-' || c == '_' || c == '.';
  });
}

int FindAxis(const Machine& machine, const std::string& name) {
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (machine.axes[i].name == name) return i;
  }
  return -1;
}

int FindJoint(const Machine& machine, const std::string& name) {
  if (name == kToolName) return machine.tool_joint();
  if (name == kWorkName) return machine.work_joint();
  return FindAxis(machine, name);
}

std::string JointName(const Machine& machine, int joint) {
  if (joint == machine.tool_joint()) return kToolName;
  if (joint == machine.work_joint()) return kWorkName;
  return machine.axes[joint].name;
}

absl::Status Validate(const Machine& machine) {
  if (!IsMachineId(machine.id)) return Refuse(machine, kMachineIdRule);
  if (machine.axes.empty() || machine.axis_count() > kMaxAxes) {
    return Refuse(machine, absl::StrCat(machine.axis_count(), " axes, expected 1 to ", kMaxAxes));
  }
  for (const Axis& axis : machine.axes) RETURN_IF_ERROR(ValidateAxis(machine, axis));
  std::vector<int> uses(machine.axes.size(), 0);
  for (const auto* branch : {&machine.tool_branch, &machine.work_branch}) {
    for (const int axis : *branch) {
      if (axis < 0 || axis >= machine.axis_count()) return Refuse(machine, absl::StrCat("a branch names axis ", axis));
      ++uses[axis];
    }
  }
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (uses[i] != 1) {
      return Refuse(machine, absl::StrCat("axis ", machine.axes[i].name, " is in ", uses[i],
                                          " places of the branches, expected one"));
    }
  }
  if (!(std::abs(machine.tool_direction.norm() - 1.0) <= kUnitTolerance)) {
    return Refuse(machine, absl::StrCat("tool_direction ", Text(machine.tool_direction), " must have length 1"));
  }
  for (size_t i = 0; i < machine.declared.size(); ++i) {
    const ErrorSymbol& symbol = machine.declared[i];
    if (FindJoint(machine, symbol.axis) < 0) {
      return Refuse(machine,
                    absl::StrCat("declared error ", ToString(symbol), ": the machine has no axis ", symbol.axis));
    }
    if (!symbol.is_constant) {
      return Refuse(machine, absl::StrCat("declared error ", ToString(symbol), " must be constant (E",
                                          std::string(1, Letter(symbol.component)), "0", symbol.axis, ")"));
    }
    if (std::count(machine.declared.begin(), machine.declared.end(), symbol) != 1) {
      return Refuse(machine, absl::StrCat("declared error ", ToString(symbol), " is there more than once"));
    }
  }
  return absl::OkStatus();
}

}  // namespace axiscal::machine
