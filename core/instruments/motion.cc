#include "core/instruments/motion.h"

#include <cmath>

#include "core/instruments/run.h"

namespace axiscal::instruments {
namespace {

// 0 where nothing moves or no time has passed.
double SpeedOf(double change, const double* time_s, double last_time_s) {
  const double elapsed_s = time_s != nullptr ? *time_s - last_time_s : 0.0;
  return change != 0.0 && elapsed_s > 0.0 ? change / elapsed_s : 0.0;
}

}  // namespace

void FirstMotion::Add(const double* positions, const double* time_s) {
  for (size_t axis = 0; axis < starts_.size(); ++axis) {
    const double change = count_ == 0 ? 0.0 : positions[axis] - last_[axis];
    if (starts_[axis].sense == 0.0 && change != 0.0) starts_[axis].sense = change > 0.0 ? 1.0 : -1.0;
    if (count_ == 1) starts_[axis].speed = SpeedOf(change, time_s, last_time_s_);
    last_[axis] = positions[axis];
  }
  if (time_s != nullptr) last_time_s_ = *time_s;
  if (count_ < 2) ++count_;
}

Motion::Motion(const std::vector<FirstMotion::Start>& starts) : starts_(starts), now_(starts.size()) {
  for (size_t axis = 0; axis < now_.size(); ++axis) now_[axis].sense = starts_[axis].sense;
}

void Motion::Next(const double* positions, const double* time_s, shapes::AxisState* states) {
  for (size_t axis = 0; axis < now_.size(); ++axis) {
    shapes::AxisState& state = now_[axis];
    const double change = is_first_ ? 0.0 : positions[axis] - state.position;
    state.position = positions[axis];
    state.speed = is_first_ ? starts_[axis].speed : SpeedOf(change, time_s, last_time_s_);
    if (change != 0.0) {
      const double sense = change > 0.0 ? 1.0 : -1.0;
      // A reversal happened at the position before: its travel is what has been covered since. Breaking away from rest
      // counts as one.
      const bool is_reversal = sense != state.sense || std::isinf(state.travel_since_reversal);
      state.travel_since_reversal = (is_reversal ? 0.0 : state.travel_since_reversal) + std::abs(change);
      state.sense = sense;
    }
    states[axis] = state;
  }
  if (time_s != nullptr) last_time_s_ = *time_s;
  is_first_ = false;
}

void DeriveMotion(MeasuringRun* run) {
  const int axes = run->axis_count, readings = run->reading_count();
  run->axis_states.assign(static_cast<size_t>(axes) * readings, {});
  const auto time_of = [run](int k) { return run->has_time ? &run->time_s[k] : nullptr; };
  FirstMotion first(axes);
  for (int k = 0; k < readings; ++k) first.Add(run->PositionsOf(k), time_of(k));
  Motion motion(first.starts());
  for (int k = 0; k < readings; ++k)
    motion.Next(run->PositionsOf(k), time_of(k), &run->axis_states[static_cast<size_t>(k) * axes]);
}

}  // namespace axiscal::instruments
