// The commands of the linear axes at one pose.
#include <Eigen/Dense>
#include <cmath>

#include "core/base/units.h"
#include "core/compensate/compensator_impl.h"
#include "core/compensate/pose_state.h"

namespace axiscal::compensate {
namespace {

using machine::ErrorTerm;
using machine::Machine;

constexpr int kMaxIterations = 50;
// Smallest ratio of singular values at which three directions count as reached: a degenerate machine has 1e-16, a
// squareness error of a tenth of a radian 0.9.
constexpr double kRankTolerance = 1e-6;

std::string PoseText(const Machine& machine, const Pose& pose) {
  std::string text;
  for (int i = 0; i < machine.axis_count(); ++i) {
    const bool is_rotary = machine.axes[i].kind == machine::AxisKind::kRotary;
    absl::StrAppendFormat(&text, "%s%s%.4f", text.empty() ? "" : " ", machine.axes[i].name,
                          pose.position[i] * (is_rotary ? base::kDegPerRad : 1.0));
  }
  return text;
}

}  // namespace

absl::Status Compensator::Impl::RequireFinite(const Pose& pose) const {
  double nothing = 0;  // not a number when a position is none, or infinite
  for (int i = 0; i < machine.axis_count(); ++i) nothing += 0.0 * pose.position[i];
  if (nothing == 0) return absl::OkStatus();
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (!std::isfinite(pose.position[i])) {
      return absl::InvalidArgumentError(
          absl::StrCat("axis ", machine.axes[i].name, " = ", pose.position[i], ", must be finite"));
    }
  }
  return absl::OkStatus();
}

absl::Status Compensator::Impl::RankError(const Pose& pose) const {
  std::string names;
  for (const int axis : linear_axes) absl::StrAppend(&names, names.empty() ? "" : ", ", machine.axes[axis].name);
  return absl::FailedPreconditionError(
      absl::StrCat("machine '", machine.id, "': its linear axes (", names.empty() ? "none" : names,
                   ") cannot move the tool in three directions at ", PoseText(machine, pose)));
}

absl::Status Compensator::Impl::Solve(const Pose& pose, const Eigen::Vector3d* tip_per_mm,
                                      const Eigen::Vector3d& move_mm, double* change_mm) const {
  const size_t count = linear_axes.size();
  if (count == 3) {
    const Eigen::Vector3d &a = tip_per_mm[0], &b = tip_per_mm[1], &c = tip_per_mm[2];
    const Eigen::Vector3d bc = b.cross(c);
    const double volume = a.dot(bc);  // columns are unit vectors: 1 where the axes are square
    if (!(std::abs(volume) > kRankTolerance)) return RankError(pose);
    const double per_volume = 1.0 / volume;
    change_mm[0] = move_mm.dot(bc) * per_volume;
    change_mm[1] = move_mm.dot(c.cross(a)) * per_volume;
    change_mm[2] = move_mm.dot(a.cross(b)) * per_volume;
    return absl::OkStatus();
  }
  Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
  for (size_t k = 0; k < count; ++k) gram += tip_per_mm[k] * tip_per_mm[k].transpose();
  if (!(std::abs(gram.determinant()) > kRankTolerance * kRankTolerance)) return RankError(pose);
  const Eigen::Vector3d weights = gram.inverse() * move_mm;
  for (size_t k = 0; k < count; ++k) change_mm[k] = tip_per_mm[k].dot(weights);
  return absl::OkStatus();
}

absl::Status Compensator::Impl::Step(const Pose& pose, const JointMaps& maps, const Turns& turns,
                                     const AffineTip& wanted, Pose* commanded, Eigen::Vector3d* lacking_mm,
                                     double* change_mm, AffineTip* found) const {
  double linear_mm[machine::kMaxAxes];
  for (size_t k = 0; k < linear_axes.size(); ++k) linear_mm[k] = commanded->position[linear_axes[k]];
  Evaluate(actual, maps, turns, linear_mm, options.tool_tip_mm, machine.tool_direction, true, found);
  *lacking_mm = wanted.tip_in_table_mm - found->tip_in_table_mm;
  return Solve(pose, found->tip_per_mm.of_axis.data(), *lacking_mm, change_mm);
}

void Compensator::Impl::Finish(const AffineTip& wanted, const AffineTip& found, double after_mm,
                               Correction* correction) const {
  correction->after_mm = after_mm;
  correction->tilt_left_rad = wanted.direction_in_table.cross(found.direction_in_table).norm();
  for (int k = 0; k < found.tip_per_mm.count; ++k) correction->tip_per_mm[k] = found.tip_per_mm.of_axis[k];
}

void Compensator::Impl::EvaluateNominal(const Pose& pose, const Turns& turns, AffineTip* wanted) const {
  double linear_mm[machine::kMaxAxes];
  for (size_t k = 0; k < linear_axes.size(); ++k) linear_mm[k] = pose.position[linear_axes[k]];
  Evaluate(nominal, JointMaps(), turns, linear_mm, options.tool_tip_mm, machine.tool_direction, false, wanted);
}

void Compensator::Impl::MapsAt(const Pose& pose, JointMaps* maps) const {
  if (is_constant) return;
  const PoseState at(machine, pose, options);
  machine::JointErrors<double> errors;
  for (const int joint : varying_joints) errors[joint] = constant[joint];
  for (const ErrorTerm& term : varying) machine::AddErrors(term, at.state(), &errors);
  for (const int joint : varying_joints) SetMap(machine, joint, errors[joint], maps);
}

void Compensator::Impl::Aim(const Pose& commanded, TurnColumns* columns) const {
  Turns turns;
  EvaluateTurns(machine, commanded.position.data(), &turns);
  double linear_mm[machine::kMaxAxes];
  for (size_t k = 0; k < linear_axes.size(); ++k) linear_mm[k] = commanded.position[linear_axes[k]];
  JointMaps maps;
  MapsAt(commanded, &maps);
  EvaluateTurnColumns(actual, maps, turns, linear_mm, options.tool_tip_mm, machine.tool_direction, columns);
}

absl::Status Compensator::Impl::Iterate(const Pose& pose, const Turns& turns, const AffineTip& wanted,
                                        const double* near_mm, Correction* correction) const {
  Pose commanded = pose;
  for (const int axis : linear_axes) commanded.position[axis] += near_mm[axis];
  const double slope = ErrorSlope(pose);
  JointMaps maps;
  AffineTip found;
  Eigen::Vector3d lacking_mm;
  double change_mm[machine::kMaxAxes];
  for (int iteration = 0; iteration <= kMaxIterations; ++iteration) {
    MapsAt(commanded, &maps);
    RETURN_IF_ERROR(Step(pose, maps, turns, wanted, &commanded, &lacking_mm, change_mm, &found));
    const double lacking = lacking_mm.norm();
    if (!(lacking < 1e6)) break;
    Apply(change_mm, &commanded.position);
    // The step leaves nothing but the errors' change over it, and rounding.
    double left = 0;
    for (size_t k = 0; k < linear_axes.size(); ++k) left += std::abs(change_mm[k]);
    left = left == 0 ? 0 : left * slope;
    if (left > 0.01 * kToleranceMm) continue;
    Eigen::Vector3d before_mm = Eigen::Vector3d::Zero();
    for (size_t k = 0; k < linear_axes.size(); ++k) {
      const int axis = linear_axes[k];
      before_mm += found.tip_per_mm.of_axis[k] * (commanded.position[axis] - pose.position[axis]);
    }
    correction->before_mm = before_mm.norm();
    correction->corrected = commanded.position;
    Finish(wanted, found, left, correction);
    return absl::OkStatus();
  }
  return absl::FailedPreconditionError(
      absl::StrFormat("no correction found at %s: %.3g um left after %d steps, the errors are too large",
                      PoseText(machine, pose), lacking_mm.norm() * base::kUmPerMm, kMaxIterations));
}

absl::Status Compensator::Impl::Reach(const Pose& pose, const Turns& turns, const AffineTip& wanted,
                                      const double* near_mm, Correction* correction) const {
  AffineTip found;
  double linear_mm[machine::kMaxAxes];
  for (size_t k = 0; k < linear_axes.size(); ++k) linear_mm[k] = pose.position[linear_axes[k]];
  Eigen::Vector3d lacking_mm;
  double change_mm[machine::kMaxAxes];
  if (is_constant) {
    // The tool point is affine in the linear axes: one step is the answer.
    Evaluate(actual, JointMaps(), turns, linear_mm, options.tool_tip_mm, machine.tool_direction, true, &found);
    lacking_mm = wanted.tip_in_table_mm - found.tip_in_table_mm;
    RETURN_IF_ERROR(Solve(pose, found.tip_per_mm.of_axis.data(), lacking_mm, change_mm));
    correction->corrected = pose.position;
    Apply(change_mm, &correction->corrected);
    correction->before_mm = lacking_mm.norm();
    for (int k = 0; k < found.tip_per_mm.count; ++k) lacking_mm -= found.tip_per_mm.of_axis[k] * change_mm[k];
    Finish(wanted, found, lacking_mm.norm(), correction);
    return absl::OkStatus();
  }
  return Iterate(pose, turns, wanted, near_mm, correction);
}

absl::Status Compensator::Impl::CorrectByPolynomial(const Pose& pose, Correction* correction) const {
  Turns turns;
  EvaluateTurns(machine, pose.position.data(), &turns);
  ToolErrors errors;
  polynomial->Evaluate(turns, &errors);
  Eigen::Vector3d lacking_mm = -errors.tip_error_mm;
  for (int k = 0; k < 3; ++k) {
    lacking_mm -= errors.error_per_mm[k] * pose.position[linear_axes[static_cast<size_t>(k)]];
    correction->tip_per_mm[static_cast<size_t>(k)] = errors.tip_per_mm[k];
  }
  double change_mm[3];
  RETURN_IF_ERROR(Solve(pose, errors.tip_per_mm, lacking_mm, change_mm));
  correction->corrected = pose.position;
  Apply(change_mm, &correction->corrected);
  correction->before_mm = lacking_mm.norm();
  for (int k = 0; k < 3; ++k) lacking_mm -= errors.tip_per_mm[k] * change_mm[k];
  correction->after_mm = lacking_mm.norm();
  // The sine of the angle between two unit vectors from their difference.
  const double chord_squared = errors.direction_error.squaredNorm();
  correction->tilt_left_rad = std::sqrt(chord_squared * (1.0 - 0.25 * chord_squared));
  return absl::OkStatus();
}

absl::Status Compensator::Impl::Correct(const Pose& pose, const double* near_mm, Correction* correction) const {
  if (polynomial) return CorrectByPolynomial(pose, correction);
  Turns turns;
  EvaluateTurns(machine, pose.position.data(), &turns);
  AffineTip wanted;
  EvaluateNominal(pose, turns, &wanted);
  return Reach(pose, turns, wanted, near_mm, correction);
}

absl::Status Compensator::Impl::CorrectTurned(const Pose& pose, const AxisValues& turned, const double* near_mm,
                                              Correction* correction) const {
  Turns turns;
  EvaluateTurns(machine, pose.position.data(), &turns);
  AffineTip wanted;
  EvaluateNominal(pose, turns, &wanted);
  JointMaps maps;
  MapsAt(pose, &maps);
  AffineTip found;
  double linear_mm[machine::kMaxAxes];
  for (size_t k = 0; k < linear_axes.size(); ++k) linear_mm[k] = pose.position[linear_axes[k]];
  Evaluate(actual, maps, turns, linear_mm, options.tool_tip_mm, machine.tool_direction, false, &found);
  const double before_mm = (wanted.tip_in_table_mm - found.tip_in_table_mm).norm();
  const double tilt_before_rad = wanted.direction_in_table.cross(found.direction_in_table).norm();
  Pose start = pose;
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (machine.axes[i].kind == machine::AxisKind::kRotary) start.position[i] = turned[i];
  }
  EvaluateTurns(machine, start.position.data(), &turns);
  RETURN_IF_ERROR(Reach(start, turns, wanted, near_mm, correction));
  correction->before_mm = before_mm;
  correction->tilt_before_rad = tilt_before_rad;
  return absl::OkStatus();
}

}  // namespace axiscal::compensate
