// Orientation of MoveCorrector: rotary commands that turn the tool as programmed, linear commands that follow them, and
// what differences of both mean for the tool.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/compensate/folded_chain.h"
#include "core/nc/move_corrector.h"

namespace axiscal::nc {

// The linear axes follow the rotary commands as words can say them: 0.0001 deg would else be 0.4 um at 500 mm.
absl::Status MoveCorrector::TurnAt(const compensate::AxisValues& near, const WordGrain& grain, Piece* piece) const {
  const compensate::Pose& pose = piece->pose;
  const AxisTicks nominal = piece->nominal;
  RETURN_IF_ERROR(compensate::CorrectDirection(*compensator_, pose, max_rotary_correction_rad_, near, &piece->turned));
  AxisTicks targets = nominal;
  compensate::AxisValues turned = pose.position;
  for (const int axis : corrected_) {
    if (compensator_->machine().axes[axis].kind == machine::AxisKind::kLinear) continue;
    targets[axis] += NearestTick((piece->turned.position[axis] - pose.position[axis]) / unit_per_tick_[axis]);
    targets[axis] = grain.Held(axis, targets[axis]);
    turned[axis] += static_cast<double>(targets[axis] - nominal[axis]) * unit_per_tick_[axis];
  }
  RETURN_IF_ERROR(compensator_->CorrectTurned(pose, turned, near, &piece->correction));
  if (piece->is_tool_point) {
    piece->targets = targets;
    return ToWords(turned, piece);
  }
  for (const int axis : compensator_->linear_axes()) {
    const double change_mm = piece->correction.corrected[axis] - pose.position[axis];
    if (!(std::abs(change_mm) < 1e5)) return absl::FailedPreconditionError("the correction is beyond any machine");
    targets[axis] += NearestTick(change_mm * kTicksPerUnit);
  }
  piece->targets = targets;
  return absl::OkStatus();
}

MoveCorrector::Change MoveCorrector::ChangeOf(const AxisTicks& to, const AxisTicks& from) const {
  Change change(static_cast<Eigen::Index>(corrected_.size()));
  for (size_t i = 0; i < corrected_.size(); ++i) {
    const int axis = corrected_[i];
    change[static_cast<Eigen::Index>(i)] = static_cast<double>(to[axis] - from[axis]) * unit_per_tick_[axis];
  }
  return change;
}

MoveCorrector::Effect MoveCorrector::EffectAt(const Piece& piece) const {
  if (piece.is_tool_point) return ToolPointEffectAt(piece);
  compensate::Pose commanded;
  for (int i = 0; i < axis_count_; ++i) {
    commanded.position[i] = static_cast<double>(piece.targets[i]) * unit_per_tick_[i];
    commanded.sense[i] = piece.pose.sense[i];
  }
  compensate::TurnColumns columns;
  compensator_->Aim(commanded, &columns);
  const size_t linear_count = compensator_->linear_axes().size();
  Effect effect = Effect::Zero(6, static_cast<Eigen::Index>(corrected_.size()));
  for (size_t i = 0; i < corrected_.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    if (i < linear_count) {
      effect.col(column).head<3>() = piece.correction.tip_per_mm[i];
    } else {
      effect.col(column).head<3>() = columns.tip_per_rad[corrected_[i]];
      effect.col(column).tail<3>() = columns.direction_per_rad[corrected_[i]] * mm_per_rad_;
    }
  }
  return effect;
}

double MoveCorrector::Weight(const Change& difference, const Effect& effect) const {
  if (!orientation_) return difference.norm();
  const Eigen::Matrix<double, 6, 1> moved = effect * difference;
  return std::max(moved.head<3>().norm(), moved.tail<3>().norm());
}

double MoveCorrector::Apart(const Piece& piece, const AxisTicks& commanded) const {
  if (orientation_) return Weight(ChangeOf(piece.targets, commanded), EffectAt(piece));
  double apart = 0;
  for (const int axis : compensator_->linear_axes()) {
    apart = std::max(apart, std::abs(static_cast<double>(piece.targets[axis] - commanded[axis])));
  }
  return apart / kTicksPerUnit * ScaleOf(piece.placed);
}

double MoveCorrector::TurnedDepartureBound(const compensate::AxisValues& from, const compensate::AxisValues& to,
                                           const Piece& end) const {
  // A correction that is, or along the move may be, held by the bound bends otherwise.
  for (const int axis : corrected_) {
    if (compensator_->machine().axes[axis].kind == machine::AxisKind::kLinear) continue;
    const double turn_rad = static_cast<double>(end.targets[axis] - end.nominal[axis]) * unit_per_tick_[axis];
    const bool is_far = std::abs(turn_rad) < 0.5 * max_rotary_correction_rad_;
    if (!is_far || end.turned.limit != compensate::DirectionLimit::kNone)
      return std::numeric_limits<double>::infinity();
  }
  double direction_rad = 0;
  const double point_mm = compensator_->TurnDepartureBound(from, to, end.turned.least_turn, &direction_rad);
  if (!(direction_rad < 0.5 * max_rotary_correction_rad_)) return std::numeric_limits<double>::infinity();
  return std::max(point_mm, direction_rad * mm_per_rad_);
}

}  // namespace axiscal::nc
