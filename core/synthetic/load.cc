// Weights on a machine's joints, from the one chain without errors.
#include <Eigen/Geometry>
#include <algorithm>

#include "core/machine/chain.h"
#include "core/synthetic/forms.h"

namespace axiscal::synthetic {
namespace {

const std::vector<int>& BranchOf(const machine::Machine& machine, int joint) {
  const bool is_work =
      joint == machine.work_joint() ||
      std::find(machine.work_branch.begin(), machine.work_branch.end(), joint) != machine.work_branch.end();
  return is_work ? machine.work_branch : machine.tool_branch;
}

}  // namespace

int BodyOf(const machine::Machine& machine, const Effect& effect) {
  if (effect.body >= 0) return effect.body;
  return &BranchOf(machine, effect.joint) == &machine.work_branch ? machine.work_joint() : machine.tool_joint();
}

double Load(const machine::Machine& machine, const Surroundings& surroundings, const Effect& effect, int body,
            const Eigen::Vector3d& centre_mm, const double* positions) {
  geometry::Rigid<double> bed_from_here, bed_from_parent;
  for (const int axis : BranchOf(machine, effect.joint)) {
    if (axis == effect.joint) bed_from_parent = bed_from_here;
    machine::AppendMotion<double>(machine.axes[axis], positions[axis], &bed_from_here);
    if (axis == body) break;
  }
  if (effect.joint >= machine.axis_count()) bed_from_parent = bed_from_here;
  const Eigen::Vector3d along = bed_from_parent.rotation.col(static_cast<int>(effect.component) % 3);
  if (!machine::IsAngle(effect.component)) return along.dot(surroundings.gravity_direction);
  const Eigen::Vector3d origin_mm = bed_from_parent * machine::ErrorPoint(machine, effect.joint);
  const Eigen::Vector3d weight_mm = bed_from_here * centre_mm;
  return along.dot((weight_mm - origin_mm).cross(surroundings.gravity_direction));
}

}  // namespace axiscal::synthetic
