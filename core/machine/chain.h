// The one kinematic chain: two branches of joints that start at the bed.
//   bed_from_tool  = product over the tool branch of E_i J_i(q_i), then E_T     carries the tool point (given at home)
//   bed_from_table = product over the work branch of E_i J_i(q_i), then E_W     carries the table ball (given at home)
//   J_i: motion of axis i by its command
//   E_i = Trans(p) Trans(EX, EY, EZ) Rot_x(EA) Rot_y(EB) Rot_z(EC) Trans(-p): its error, actual - nominal
// E_i stands before J_i, on the side of the bed; p is the axis' point (the machine's origin for linear axes, T and W).
// At home every frame coincides with the machine frame, so nominal points at home are written in machine coordinates.
// Lengths mm, angles rad. Templated on the scalar: simulation, identification, the loop, compensation and verification
// all evaluate this. Sources: ISO 230-1; Yao 2022 (2.1-2.17); Ibaraki. Conventions: docs/formats.md, machine.json.
#ifndef AXISCAL_CORE_MACHINE_CHAIN_H_
#define AXISCAL_CORE_MACHINE_CHAIN_H_

#include <array>
#include <type_traits>

#include "core/geometry/rigid.h"
#include "core/machine/machine.h"

namespace axiscal::machine {

template <typename T>
using ErrorVector = Eigen::Matrix<T, kComponents, 1>;  // EX EY EZ [mm], EA EB EC [rad]

inline constexpr int kMaxJoints = kMaxAxes + 2;

// One error vector per joint; zero unless set.
template <typename T>
struct JointErrors {
  std::array<ErrorVector<T>, kMaxJoints> of_joint;

  JointErrors() { of_joint.fill(ErrorVector<T>::Zero()); }
  ErrorVector<T>& operator[](int joint) { return of_joint[joint]; }
  const ErrorVector<T>& operator[](int joint) const { return of_joint[joint]; }
};

// E: small displacement about `point_mm`; exact, not linearised.
template <typename T>
geometry::Rigid<T> ErrorTransform(const ErrorVector<T>& error, const Eigen::Vector3d& point_mm) {
  geometry::Rigid<T> transform;
  transform.rotation = geometry::RotationXyz<T>(error[3], error[4], error[5]);
  const geometry::Vector3<T> point = point_mm.cast<T>();
  transform.translation_mm = error.template head<3>() + point - transform.rotation * point;
  return transform;
}

// J: motion of one axis by its command (mm or rad).
template <typename T>
geometry::Rigid<T> MotionTransform(const Axis& axis, const T& position) {
  geometry::Rigid<T> transform;
  if (axis.kind == AxisKind::kLinear) {
    transform.translation_mm = axis.direction.cast<T>() * position;
  } else {
    transform.rotation = geometry::AxisRotation<T>(axis.direction, position);
    const geometry::Vector3<T> point = axis.point_mm.cast<T>();
    transform.translation_mm = point - transform.rotation * point;
  }
  return transform;
}

inline const Eigen::Vector3d& ErrorPoint(const Machine& machine, int joint) {
  static const Eigen::Vector3d kOrigin = Eigen::Vector3d::Zero();
  if (joint >= machine.axis_count() || machine.axes[joint].kind == AxisKind::kLinear) return kOrigin;
  return machine.axes[joint].point_mm;
}

template <typename T>
struct ChainPose {
  geometry::Rigid<T> bed_from_tool;   // with E_T
  geometry::Rigid<T> bed_from_table;  // with E_W
};

// bed = bed * E. An error of zero is no step, except to a derivative.
template <typename T>
void AppendError(const ErrorVector<T>& error, const Eigen::Vector3d& point_mm, geometry::Rigid<T>* bed) {
  if constexpr (std::is_same_v<T, double>) {
    if (error.isZero(0.0)) return;
  }
  *bed = *bed * ErrorTransform<T>(error, point_mm);
}

// bed = bed * J.
template <typename T>
void AppendMotion(const Axis& axis, const T& position, geometry::Rigid<T>* bed) {
  if (axis.kind == AxisKind::kLinear) {
    bed->translation_mm += bed->rotation * (axis.direction.cast<T>() * position);
    return;
  }
  const geometry::Vector3<T> point = axis.point_mm.cast<T>();
  bed->translation_mm += bed->rotation * point;
  if constexpr (std::is_same_v<T, double>) {
    geometry::TurnAbout(axis.direction, position, &bed->rotation);
  } else {
    bed->rotation = geometry::Matrix3<T>(bed->rotation * geometry::AxisRotation<T>(axis.direction, position));
  }
  bed->translation_mm -= bed->rotation * point;
}

// `positions` per axis of the machine, mm or rad.
template <typename T>
ChainPose<T> EvaluateChain(const Machine& machine, const T* positions, const JointErrors<T>& errors) {
  const auto branch = [&](const std::vector<int>& axes, int end_joint) {
    geometry::Rigid<T> bed_from_end;
    for (const int axis : axes) {
      AppendError<T>(errors[axis], ErrorPoint(machine, axis), &bed_from_end);
      AppendMotion<T>(machine.axes[axis], positions[axis], &bed_from_end);
    }
    AppendError<T>(errors[end_joint], ErrorPoint(machine, end_joint), &bed_from_end);
    return bed_from_end;
  };
  return {branch(machine.tool_branch, machine.tool_joint()), branch(machine.work_branch, machine.work_joint())};
}

// The point of the tool as the table sees it: what the workpiece gets. `tip_mm` is the nominal tool point at home,
// machine frame.
template <typename T>
geometry::Vector3<T> TipInTable(const ChainPose<T>& pose, const Eigen::Vector3d& tip_mm) {
  const geometry::Vector3<T> tip_in_bed_mm = pose.bed_from_tool * geometry::Vector3<T>(tip_mm.cast<T>());
  return pose.bed_from_table.Inverse() * tip_in_bed_mm;
}

// Direction of the tool as the table sees it, unit.
template <typename T>
geometry::Vector3<T> ToolDirectionInTable(const Machine& machine, const ChainPose<T>& pose) {
  return pose.bed_from_table.rotation.transpose() * (pose.bed_from_tool.rotation * machine.tool_direction.cast<T>());
}

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_CHAIN_H_
