#include "core/machine/sensitivity.h"

#include <Eigen/Geometry>

namespace axiscal::machine {
namespace {

using geometry::Rigid;

// Walks one branch outwards. With E = Trans(p + e) R Trans(-p) about the error's point p:
//   E x = (p + e) + R (x - p),   dE x / de = 1,   dE x / d(angle k) = axis_k x R (x - p),
// and R (x - p), the lever, leads from the error's centre p + e to the carried point, whatever is between.
// Most errors are zero and most motions are shifts: both leave the rotation alone.
void AddBranch(const Machine& machine, const std::vector<int>& axes, int end_joint, const double* positions,
               const JointErrors<double>& errors, double sign, const Eigen::Vector3d& point_at_home_mm,
               Rigid<double>* bed_from_end, Eigen::Vector3d* point_in_bed_mm, RelativePoint* out) {
  std::array<int, kMaxJoints> joints;
  int count = 0;
  Rigid<double>& bed = *bed_from_end;
  bed = {};
  const auto add_error = [&](int joint) -> const Eigen::Vector3d& {
    const ErrorVector<double>& error = errors[joint];
    ErrorTurn& turn = out->turns[joint];
    JointPlace& place = out->places[joint];
    bool has_moved = place.bed_from_parent != bed.rotation;
    if (has_moved) place.bed_from_parent = bed.rotation;
    if (error.tail<3>() != turn.angles_rad) {
      turn = TurnOf(error);
      has_moved = true;
    }
    joints[count++] = joint;
    place.sign = sign;
    const Eigen::Vector3d& point_mm = ErrorPoint(machine, joint);
    const Eigen::Vector3d centre_mm = point_mm + error.head<3>();
    if (!centre_mm.isZero(0.0)) bed.translation_mm += bed.rotation * centre_mm;
    place.lever_mm = bed.translation_mm;  // the error's centre, until the point is known
    if (turn.is_zero) return point_mm;
    if (has_moved) place.bed_from_turned.noalias() = place.bed_from_parent * turn.rotation;
    bed.rotation = place.bed_from_turned;
    return point_mm;
  };
  for (const int joint : axes) {
    const Axis& axis = machine.axes[joint];
    const Eigen::Vector3d& point_mm = add_error(joint);
    if (axis.kind == AxisKind::kLinear) {
      bed.translation_mm += bed.rotation * (axis.direction * positions[joint]);
      continue;
    }
    geometry::TurnAbout(axis.direction, positions[joint], &bed.rotation);
    if (!point_mm.isZero(0.0)) bed.translation_mm -= bed.rotation * point_mm;
  }
  add_error(end_joint);
  *point_in_bed_mm = bed * point_at_home_mm;

  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d& lever_mm = out->places[joints[i]].lever_mm;
    lever_mm = *point_in_bed_mm - lever_mm;
  }
}

}  // namespace

ErrorTurn TurnOf(const ErrorVector<double>& error) {
  ErrorTurn turn;
  turn.angles_rad = error.tail<3>();
  turn.is_zero = turn.angles_rad.isZero(0.0);
  if (turn.is_zero) return turn;
  turn.rotation = geometry::RotationXyz<double>(error[3], error[4], error[5]);
  double ca, sa, cb, sb;
  geometry::SineCosine(error[3], &sa, &ca);
  geometry::SineCosine(error[4], &sb, &cb);
  turn.axes << 1.0, 0.0, sb, 0.0, ca, -sa * cb, 0.0, sa, ca * cb;
  return turn;
}

void EvaluatePlaces(const Machine& machine, const double* positions, const JointErrors<double>& errors,
                    const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& ball_mm, RelativePoint* out) {
  AddBranch(machine, machine.tool_branch, machine.tool_joint(), positions, errors, 1.0, tip_mm,
            &out->pose.bed_from_tool, &out->tip_in_bed_mm, out);
  AddBranch(machine, machine.work_branch, machine.work_joint(), positions, errors, -1.0, ball_mm,
            &out->pose.bed_from_table, &out->ball_in_bed_mm, out);
}

void SensitivityAlong(const Machine& machine, const RelativePoint& point, const Eigen::Vector3d& direction,
                      double* row) {
  for (int joint = 0; joint < machine.joint_count(); ++joint, row += kComponents) {
    const JointPlace& place = point.places[joint];
    const ErrorTurn& turn = point.turns[joint];
    const Eigen::Vector3d along = place.sign * direction;
    // (axis x lever) . direction = axis . (lever x direction)
    const Eigen::Vector3d moment_mm = place.bed_from_parent.transpose() * place.lever_mm.cross(along);
    Eigen::Map<Eigen::Vector3d> by_shift(row), by_angle(row + 3);
    by_shift = place.bed_from_parent.transpose() * along;
    by_angle = moment_mm;
    if (!turn.is_zero) by_angle = turn.axes.transpose() * moment_mm;
  }
}

void EvaluateRelativePoint(const Machine& machine, const double* positions, const JointErrors<double>& errors,
                           const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& ball_mm, RelativePoint* out) {
  EvaluatePlaces(machine, positions, errors, tip_mm, ball_mm, out);
  out->sensitivity.resize(3, kComponents * machine.joint_count());
  for (int joint = 0; joint < machine.joint_count(); ++joint) {
    const JointPlace& place = out->places[joint];
    const ErrorTurn& turn = out->turns[joint];
    auto block = out->sensitivity.middleCols<kComponents>(kComponents * joint);
    const Eigen::Matrix3d signed_parent = place.sign * place.bed_from_parent;
    block.leftCols<3>() = signed_parent;
    const Eigen::Matrix3d turning_axes = turn.is_zero ? signed_parent : Eigen::Matrix3d(signed_parent * turn.axes);
    for (int k = 0; k < 3; ++k) block.col(3 + k) = turning_axes.col(k).cross(place.lever_mm);
  }
}

}  // namespace axiscal::machine
