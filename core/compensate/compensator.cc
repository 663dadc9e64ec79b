#include "core/compensate/compensator.h"

#include <limits>

#include "core/compensate/carried.h"
#include "core/compensate/compensator_impl.h"
#include "core/machine/redundant_facts.h"
#include "core/shapes/depends_on.h"

namespace axiscal::compensate {

using machine::ErrorModel;
using machine::ErrorTerm;
using machine::Machine;

Compensator::Compensator(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Compensator::Compensator(Compensator&&) noexcept = default;
Compensator& Compensator::operator=(Compensator&&) noexcept = default;
Compensator::~Compensator() = default;

absl::StatusOr<Compensator> Compensator::Create(const Machine& machine, const ErrorModel& errors,
                                                const Options& options) {
  RETURN_IF_ERROR(machine::Validate(machine));
  if (!options.tool_tip_mm.allFinite() || options.tool_tip_mm.cwiseAbs().maxCoeff() > 1e6) {
    return absl::InvalidArgumentError("tool tip: every component must be finite, at most 1e6 mm");
  }
  RETURN_IF_ERROR(machine::CheckToolTip(machine, options.tool_tip_mm));
  auto impl = std::make_unique<Impl>();
  impl->machine = machine;
  impl->options = options;
  RETURN_IF_ERROR(SelectCarried(machine, errors, options, &impl->carried, &impl->not_carried));
  for (const ErrorTerm& term : impl->carried.terms) {
    if (shapes::DependsOnSense(term.shape)) impl->uses_sense[*shapes::VariableAxis(term.shape)] = true;
  }
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (machine.axes[i].kind == machine::AxisKind::kLinear) impl->linear_axes.push_back(i);
  }
  impl->MeasureErrors();
  Fold(impl->machine, impl->linear_axes, JointMaps(), {}, &impl->nominal);
  JointMaps constant_maps;
  for (int joint = 0; joint < machine.joint_count(); ++joint)
    SetMap(impl->machine, joint, impl->constant[joint], &constant_maps);
  Fold(impl->machine, impl->linear_axes, constant_maps, impl->varying_joints, &impl->actual);
  if (impl->is_constant) {
    impl->polynomial =
        ErrorPolynomial::Create(impl->nominal, impl->actual, options.tool_tip_mm, impl->machine.tool_direction);
  }
  return Compensator(std::move(impl));
}

absl::StatusOr<Correction> Compensator::Correct(const Pose& pose) const {
  Correction correction;
  RETURN_IF_ERROR(Correct(pose, &correction));
  return correction;
}

absl::Status Compensator::Correct(const Pose& pose, Correction* correction) const {
  static constexpr AxisValues kNothing{};
  return Correct(pose, kNothing, correction);
}

absl::Status Compensator::Correct(const Pose& pose, const AxisValues& near_mm, Correction* correction) const {
  absl::Status status = impl_->Correct(pose, near_mm.data(), correction);
  // A position that is not finite leaves no finite error behind: it need not be looked for before.
  if (!status.ok() || !(correction->before_mm <= std::numeric_limits<double>::max())) [[unlikely]]
    RETURN_IF_ERROR(impl_->RequireFinite(pose));
  return status;
}

absl::Status Compensator::CorrectTurned(const Pose& pose, const AxisValues& turned, const AxisValues& near_mm,
                                        Correction* correction) const {
  RETURN_IF_ERROR(impl_->RequireFinite(pose));
  return impl_->CorrectTurned(pose, turned, near_mm.data(), correction);
}

Eigen::Vector3d Compensator::NominalDirection(const Pose& pose) const {
  Turns turns;
  EvaluateTurns(impl_->machine, pose.position.data(), &turns);
  AffineTip wanted;
  impl_->EvaluateNominal(pose, turns, &wanted);
  return wanted.direction_in_table;
}

void Compensator::Aim(const Pose& commanded, TurnColumns* columns) const { impl_->Aim(commanded, columns); }

absl::StatusOr<Compensator> Compensator::WithLongerTool(double length_mm) const {
  Options longer = impl_->options;
  longer.tool_tip_mm += length_mm * impl_->machine.tool_direction;
  return Create(impl_->machine, impl_->carried, longer);
}

double Compensator::smooth_travel(int axis) const { return impl_->smooth_travel[axis]; }
const Options& Compensator::options() const { return impl_->options; }
const Eigen::Vector3d& Compensator::tool_tip_mm() const { return impl_->options.tool_tip_mm; }
const Machine& Compensator::machine() const { return impl_->machine; }
const std::vector<int>& Compensator::linear_axes() const { return impl_->linear_axes; }
bool Compensator::is_constant() const { return impl_->is_constant; }
bool Compensator::is_null() const { return impl_->carried.terms.empty(); }
bool Compensator::uses_sense(int axis) const { return impl_->uses_sense[axis]; }
const ErrorModel& Compensator::carried() const { return impl_->carried; }
const std::vector<std::string>& Compensator::not_carried() const { return impl_->not_carried; }

}  // namespace axiscal::compensate
