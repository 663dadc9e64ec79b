// The errors of a machine's joints as transforms, for the chain at many states where they stay the same or nearly so: a
// transform is made again only where its joint's error has changed.
#ifndef AXISCAL_CORE_MACHINE_JOINT_TRANSFORMS_H_
#define AXISCAL_CORE_MACHINE_JOINT_TRANSFORMS_H_

#include <array>
#include <vector>

#include "core/machine/chain.h"

namespace axiscal::machine {

// The machine must outlive it. No joint has an error before the first Set().
class JointTransforms {
 public:
  explicit JointTransforms(const Machine& machine) : machine_(&machine) {}

  void Set(const JointErrors<double>& errors) {
    for (int joint = 0; joint < machine_->joint_count(); ++joint) Set(joint, errors[joint]);
  }
  void Set(int joint, const ErrorVector<double>& error) {
    if (error == errors_[joint]) return;
    errors_[joint] = error;
    has_error_[joint] = !error.isZero(0.0);
    if (has_error_[joint]) transforms_[joint] = ErrorTransform<double>(error, ErrorPoint(*machine_, joint));
  }

  const ErrorVector<double>& ErrorOf(int joint) const { return errors_[joint]; }
  // bed = bed * E of the joint, as AppendError() of its error.
  void Append(int joint, geometry::Rigid<double>* bed) const {
    if (has_error_[joint]) *bed = *bed * transforms_[joint];
  }

 private:
  const Machine* machine_;
  JointErrors<double> errors_;
  std::array<bool, kMaxJoints> has_error_ = {};
  std::array<geometry::Rigid<double>, kMaxJoints> transforms_;
};

// EvaluateChain() of chain.h with errors in this form; the same values (a test compares them).
template <typename T>
ChainPose<T> EvaluateChain(const Machine& machine, const T* positions, const JointTransforms& errors) {
  const auto branch = [&](const std::vector<int>& axes, int end_joint) {
    geometry::Rigid<T> bed_from_end;
    for (const int axis : axes) {
      errors.Append(axis, &bed_from_end);
      AppendMotion<T>(machine.axes[axis], positions[axis], &bed_from_end);
    }
    errors.Append(end_joint, &bed_from_end);
    return bed_from_end;
  };
  return {branch(machine.tool_branch, machine.tool_joint()), branch(machine.work_branch, machine.work_joint())};
}

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_JOINT_TRANSFORMS_H_
