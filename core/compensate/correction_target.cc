#include "core/compensate/correction_target.h"

#include <algorithm>
#include <cmath>

#include "core/compensate/pose_state.h"
#include "core/machine/chain.h"

namespace axiscal::compensate {
namespace {

using machine::ErrorModel;
using machine::ErrorTerm;
using machine::Machine;

// Whether the term turns its axis about itself. Only axes along a coordinate have one component that does.
bool IsOwnTurn(const Machine& machine, const ErrorTerm& term) {
  if (term.joint >= machine.axis_count() || !machine::IsAngle(term.component)) return false;
  const machine::Axis& axis = machine.axes[term.joint];
  const int k = static_cast<int>(term.component) - static_cast<int>(machine::Component::kA);
  return axis.kind == machine::AxisKind::kRotary && std::abs(axis.direction[k]) == 1.0;
}

}  // namespace

CorrectionTarget::CorrectionTarget(Compensator compensator, const Pose& reference)
    : compensator_(std::move(compensator)), reference_(reference) {
  reference_.sense.fill(0.0);
}

absl::StatusOr<CorrectionTarget> CorrectionTarget::Create(const Machine& machine, const ErrorModel& errors,
                                                          const Options& options, const Pose& reference,
                                                          const std::array<bool, machine::kMaxAxes>& corrected_rotary) {
  // The compensator decides which terms can be carried at all.
  ASSIGN_OR_RETURN(const Compensator whole, Compensator::Create(machine, errors, options));
  ErrorModel linear, turns;
  for (const ErrorTerm& term : whole.carried().terms) {
    const bool is_turn = IsOwnTurn(machine, term) && corrected_rotary[term.joint];
    (is_turn ? turns : linear).terms.push_back(term);
  }
  ASSIGN_OR_RETURN(Compensator compensator, Compensator::Create(machine, linear, options));
  CorrectionTarget target(std::move(compensator), reference);
  target.turns_ = std::move(turns);
  target.options_ = options;
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (corrected_rotary[i]) target.turned_.push_back(i);
  }
  ASSIGN_OR_RETURN(target.constant_, target.Whole(target.reference_));
  return target;
}

absl::StatusOr<Positions> CorrectionTarget::Whole(const Pose& pose) const {
  const Machine& machine = compensator_.machine();
  ASSIGN_OR_RETURN(const Correction correction, compensator_.Correct(pose));
  Positions change{};
  for (const int axis : compensator_.linear_axes()) change[axis] = correction.corrected[axis] - pose.position[axis];
  if (turned_.empty()) return change;
  const PoseState at(machine, pose, options_);
  const machine::JointErrors<double> errors = machine::ErrorsAt(machine, turns_, at.state());
  for (const int axis : turned_) change[axis] = -machine.axes[axis].direction.dot(errors[axis].tail<3>());
  return change;
}

absl::StatusOr<Positions> CorrectionTarget::At(const Pose& pose) const {
  ASSIGN_OR_RETURN(Positions change, Whole(pose));
  for (size_t i = 0; i < change.size(); ++i) change[i] -= constant_[i];
  return change;
}

absl::StatusOr<Positions> CorrectionTarget::Along(int axis, double position, double sense) const {
  Pose pose = reference_;
  pose.position[axis] = position;
  pose.sense[axis] = sense;
  return At(pose);
}

}  // namespace axiscal::compensate
