#include "core/machine/sensitivity.h"

#include <Eigen/Geometry>

namespace axiscal::machine {
namespace {

using geometry::Rigid;

struct JointStep {
  int joint;
  Rigid<double> error, motion;
};

// Walks one branch: transforms on the way out, then the point back in, so that each joint knows its prefix and where
// the point stands beyond it. With E = Trans(p + e) R Trans(-p):  dE x/de = I,  dE x/d(angle k) = w_k x R (x - p),  w =
// ex, Rx ey, Rx Ry ez.
void AddBranch(const Machine& machine, const std::vector<int>& axes, int end_joint, const double* positions,
               const JointErrors<double>& errors, double sign, const Eigen::Vector3d& point_at_home_mm,
               Rigid<double>* bed_from_end, Eigen::Vector3d* point_in_bed_mm, RelativePoint* out) {
  std::array<JointStep, kMaxJoints> steps;
  int count = 0;
  for (const int axis : axes) {
    steps[count++] = {axis, ErrorTransform<double>(errors[axis], ErrorPoint(machine, axis)),
                      MotionTransform<double>(machine.axes[axis], positions[axis])};
  }
  steps[count++] = {end_joint, ErrorTransform<double>(errors[end_joint], ErrorPoint(machine, end_joint)), {}};

  std::array<Eigen::Vector3d, kMaxJoints> beyond_mm;  // the point in the frame just beyond each joint's error transform
  Eigen::Vector3d point_mm = point_at_home_mm;
  for (int i = count - 1; i >= 0; --i) {
    beyond_mm[i] = steps[i].motion * point_mm;
    point_mm = steps[i].error * beyond_mm[i];
  }
  *point_in_bed_mm = point_mm;

  Rigid<double> bed_from_joint;
  for (int i = 0; i < count; ++i) {
    const JointStep& step = steps[i];
    const ErrorVector<double>& error = errors[step.joint];
    auto block = out->sensitivity.middleCols<kComponents>(kComponents * step.joint);
    block.leftCols<3>() = sign * bed_from_joint.rotation;
    const Eigen::Vector3d lever_mm = step.error.rotation * (beyond_mm[i] - ErrorPoint(machine, step.joint));
    const double ca = std::cos(error[3]), sa = std::sin(error[3]), cb = std::cos(error[4]), sb = std::sin(error[4]);
    const Eigen::Vector3d turn_b(0, ca, sa), turn_c(sb, -sa * cb, ca * cb);
    block.col(3) = sign * (bed_from_joint.rotation * Eigen::Vector3d(0, -lever_mm.z(), lever_mm.y()));
    block.col(4) = sign * (bed_from_joint.rotation * turn_b.cross(lever_mm));
    block.col(5) = sign * (bed_from_joint.rotation * turn_c.cross(lever_mm));
    bed_from_joint = bed_from_joint * step.error * step.motion;
  }
  *bed_from_end = bed_from_joint;
}

}  // namespace

void EvaluateRelativePoint(const Machine& machine, const double* positions, const JointErrors<double>& errors,
                           const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& ball_mm, RelativePoint* out) {
  out->sensitivity.resize(3, kComponents * machine.joint_count());
  AddBranch(machine, machine.tool_branch, machine.tool_joint(), positions, errors, 1.0, tip_mm,
            &out->pose.bed_from_tool, &out->tip_in_bed_mm, out);
  AddBranch(machine, machine.work_branch, machine.work_joint(), positions, errors, -1.0, ball_mm,
            &out->pose.bed_from_table, &out->ball_in_bed_mm, out);
}

}  // namespace axiscal::machine
