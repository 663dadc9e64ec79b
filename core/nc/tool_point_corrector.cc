// Moves of MoveCorrector whose words stand in the workpiece's frame.
//
// With q the nominal commands of the axes for the words and q' the corrected ones, the control must be told the words
// that its nominal chain makes q' of: words' = words + d words / d axes (q' - q), exact while rotary commands stay.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/compensate/folded_chain.h"
#include "core/nc/move_corrector.h"

namespace axiscal::nc {
namespace {

constexpr int kTravelParts = 8;  // of a move, to see how far the axes travel along it
constexpr double kMostMm = 1e5;  // a larger correction is no machine's

}  // namespace

absl::Status MoveCorrector::CorrectWords(const WordGrain& grain, Piece* piece) const {
  compensate::Pose& pose = piece->pose;
  for (int i = 0; i < axis_count_; ++i) {
    pose.position[i] = static_cast<double>(piece->nominal[i]) * unit_per_tick_[i];
    piece->targets[i] = piece->nominal[i];
  }
  ToolPointFrame::Map map;
  if (!frame_.At(pose.position.data(), length_mm_, piece->placed, &map))
    return absl::FailedPreconditionError("X, Y and Z do not reach three directions at this pose");
  const std::array<int, 3>& xyz = frame_.xyz();
  const Eigen::Vector3d words_mm(pose.position[xyz[0]], pose.position[xyz[1]], pose.position[xyz[2]]);
  const Eigen::Vector3d axes_mm = map.axes_of_words * (words_mm - map.at_zero_mm);
  for (int k = 0; k < 3; ++k) {
    const int axis = xyz[static_cast<size_t>(k)];
    pose.position[axis] = axes_mm[k];
    pose.sense[axis] = 0;  // inside the move they turn back
  }
  compensate::AxisValues near{};
  if (begins_near_) near = piece->axis_change;
  if (orientation_) {
    RETURN_IF_ERROR(TurnAt(near, grain, piece));
  } else {
    RETURN_IF_ERROR(compensator_->Correct(pose, near, &piece->correction));
    Eigen::Vector3d change_mm;
    for (int k = 0; k < 3; ++k) {
      const int axis = xyz[static_cast<size_t>(k)];
      change_mm[k] = piece->correction.corrected[axis] - pose.position[axis];
    }
    const Eigen::Vector3d change_of_words_mm = map.words_of_axes * change_mm;
    for (int k = 0; k < 3; ++k) {
      if (!(std::abs(change_of_words_mm[k]) < kMostMm))
        return absl::FailedPreconditionError("the correction is beyond any machine");
      piece->targets[xyz[static_cast<size_t>(k)]] += NearestTick(change_of_words_mm[k] * kTicksPerUnit);
    }
  }
  const std::vector<int>& linear = compensator_->linear_axes();
  const auto index_of = [&](int k) {
    return std::find(linear.begin(), linear.end(), xyz[static_cast<size_t>(k)]) - linear.begin();
  };
  for (const int axis : linear) piece->axis_change[axis] = piece->correction.corrected[axis] - pose.position[axis];
  if (piece->placed == nullptr) {
    for (int k = 0; k < 3; ++k) piece->correction.tip_per_mm[static_cast<size_t>(index_of(k))] = frame_.InTable(k);
    return absl::OkStatus();
  }
  std::array<Eigen::Vector3d, 3> of_axis;
  for (int k = 0; k < 3; ++k)
    of_axis[static_cast<size_t>(k)] = piece->correction.tip_per_mm[static_cast<size_t>(index_of(k))];
  for (int k = 0; k < 3; ++k) {
    piece->correction.tip_per_mm[static_cast<size_t>(index_of(k))] = of_axis[0] * map.axes_of_words(0, k) +
                                                                     of_axis[1] * map.axes_of_words(1, k) +
                                                                     of_axis[2] * map.axes_of_words(2, k);
  }
  return absl::OkStatus();
}

absl::Status MoveCorrector::ToWords(const compensate::AxisValues& turned, Piece* piece) const {
  compensate::AxisValues before = piece->pose.position, after = turned;
  for (const int axis : frame_.xyz()) after[axis] = piece->correction.corrected[axis];
  for (int i = 0; i < axis_count_; ++i) {
    if (compensator_->machine().axes[i].kind == machine::AxisKind::kRotary)
      piece->axis_change[i] = turned[i] - piece->pose.position[i];
  }
  if (!frame_.ToWords(length_mm_, piece->placed, before.data()) ||
      !frame_.ToWords(length_mm_, piece->placed, after.data()))
    return absl::FailedPreconditionError("X, Y and Z do not reach three directions at this pose");
  for (const int axis : frame_.xyz()) {
    const double change_mm = after[axis] - before[axis];
    if (!(std::abs(change_mm) < kMostMm)) return absl::FailedPreconditionError("the correction is beyond any machine");
    piece->targets[axis] = piece->nominal[axis] + NearestTick(change_mm * kTicksPerUnit);
  }
  return absl::OkStatus();
}

// The tool point stays where the words say while rotary commands turn: to first order they move the direction alone.
MoveCorrector::Effect MoveCorrector::ToolPointEffectAt(const Piece& piece) const {
  compensate::Pose commanded;
  commanded.sense = piece.pose.sense;
  commanded.position = piece.correction.corrected;
  for (const int axis : corrected_) {
    if (compensator_->machine().axes[axis].kind == machine::AxisKind::kRotary)
      commanded.position[axis] = static_cast<double>(piece.targets[axis]) * unit_per_tick_[axis];
  }
  compensate::TurnColumns columns;
  compensator_->Aim(commanded, &columns);
  Effect effect = Effect::Zero(6, static_cast<Eigen::Index>(corrected_.size()));
  const size_t linear_count = compensator_->linear_axes().size();
  for (size_t i = 0; i < corrected_.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    if (i < linear_count) {
      effect.col(column).head<3>() = piece.correction.tip_per_mm[i];
    } else {
      effect.col(column).tail<3>() = columns.direction_per_rad[corrected_[i]] * mm_per_rad_;
    }
  }
  return effect;
}

compensate::AxisValues MoveCorrector::AxisTravels(const Step& step) const {
  compensate::AxisValues travels{}, last{};
  for (int part = 0; part <= kTravelParts; ++part) {
    const AxisTicks words = Between(step, static_cast<double>(part) / kTravelParts);
    compensate::AxisValues at{};
    for (int i = 0; i < axis_count_; ++i) at[i] = static_cast<double>(words[i]) * unit_per_tick_[i];
    if (!frame_.ToAxes(length_mm_, step.placed.get(), at.data())) continue;  // Correct says why
    for (int i = 0; i < axis_count_ && part > 0; ++i) travels[i] += std::abs(at[i] - last[i]);
    last = at;
  }
  return travels;
}

// In the workpiece's frame an error of a joint is turned by each rotary axis twice at most, and its lever is linear in
// the words: the bound of moves in axis positions holds with the words in their place, while no error depends on where
// the linear axes stand. Where no rotary axis turns, the axes move along a line too.
double MoveCorrector::ToolPointDepartureBound(const Step& step) const {
  if (orientation_) return std::numeric_limits<double>::infinity();
  compensate::AxisValues from{}, to{};
  bool turns = false;
  for (int i = 0; i < axis_count_; ++i) {
    from[i] = static_cast<double>(step.start.ticks[i]) * unit_per_tick_[i];
    to[i] = static_cast<double>(step.end.ticks[i]) * unit_per_tick_[i];
    turns |= compensator_->machine().axes[i].kind == machine::AxisKind::kRotary && from[i] != to[i];
  }
  if (compensator_->is_constant() && step.placed == nullptr) return compensator_->DepartureBound(from, to);
  if (turns || !frame_.ToAxes(length_mm_, step.placed.get(), from.data()) ||
      !frame_.ToAxes(length_mm_, step.placed.get(), to.data()))
    return std::numeric_limits<double>::infinity();
  return compensator_->DepartureBound(from, to);
}

}  // namespace axiscal::nc
