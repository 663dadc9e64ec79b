#include "core/instruments/motion.h"

#include <algorithm>
#include <cmath>

#include "core/instruments/run.h"

namespace axiscal::instruments {
namespace {

// Moments closer than that are one moment: no clock of an instrument or a control tells them apart, and speeds between
// them would be without bound.
constexpr double kOneMomentS = 1e-6;

// An axis goes the other way from a position on.
void Turn(double position, shapes::AxisState* state) {
  std::copy_backward(state->turned_at.begin(), state->turned_at.end() - 1, state->turned_at.end());
  state->turned_at.front() = position;
}

// A loop that is closed is forgotten: where the axis turned into it and out of it.
void GoBeyondTurns(shapes::AxisState* state) {
  std::array<double, shapes::kTurns>& turns = state->turned_at;
  while (state->sense * (state->position - turns[1]) >= 0.0) {
    std::copy(turns.begin() + 2, turns.end(), turns.begin());
    std::fill(turns.end() - 2, turns.end(), NAN);
  }
}

}  // namespace

double SpeedOf(double change, double elapsed_s) {
  return change != 0.0 && elapsed_s > kOneMomentS ? change / elapsed_s : 0.0;
}

void FirstMotion::Add(const double* positions, const double* time_s) {
  const double elapsed_s = time_s != nullptr ? *time_s - last_time_s_ : 0.0;
  still_ = 0;
  for (size_t axis = 0; axis < starts_.size(); ++axis) {
    const double change = count_ == 0 ? 0.0 : positions[axis] - last_[axis];
    if (starts_[axis].sense == 0.0 && change != 0.0) starts_[axis].sense = change > 0.0 ? 1.0 : -1.0;
    if (starts_[axis].sense == 0.0) ++still_;
    if (count_ == 1) starts_[axis].speed = SpeedOf(change, elapsed_s);
    last_[axis] = positions[axis];
  }
  if (time_s != nullptr) last_time_s_ = *time_s;
  if (count_ < 2) ++count_;
}

Motion::Motion(const std::vector<FirstMotion::Start>& starts) : starts_(starts), now_(starts.size()) {
  for (size_t axis = 0; axis < now_.size(); ++axis) now_[axis].sense = starts_[axis].sense;
}

void Motion::Next(const Moment& now, const Moment& after, shapes::AxisState* states) {
  const double elapsed_s = now.time_s != nullptr ? *now.time_s - last_time_s_ : 0.0;
  const double to_next_s = after.time_s != nullptr && now.time_s != nullptr ? *after.time_s - *now.time_s : 0.0;
  for (size_t axis = 0; axis < now_.size(); ++axis) {
    shapes::AxisState state = now_[axis];
    const double change = is_first_ ? 0.0 : now.positions[axis] - state.position;
    state.position = now.positions[axis];
    state.speed = is_first_ ? starts_[axis].speed : SpeedOf(change, elapsed_s);
    state.acceleration = 0.0;
    if (!is_first_ && after.positions != nullptr && elapsed_s > kOneMomentS && to_next_s > kOneMomentS) {
      const double next_speed = (after.positions[axis] - now.positions[axis]) / to_next_s;
      state.acceleration = 2.0 * (next_speed - state.speed) / (elapsed_s + to_next_s);
      state.speed = (state.speed * to_next_s + next_speed * elapsed_s) / (elapsed_s + to_next_s);
    }
    if (change != 0.0) {
      const double sense = change > 0.0 ? 1.0 : -1.0;
      // A reversal happened at the position before: its travel is what has been covered since. Breaking away from rest
      // counts as one.
      const bool is_reversal = sense != state.sense || std::isinf(state.travel_since_reversal);
      state.travel_since_reversal = (is_reversal ? 0.0 : state.travel_since_reversal) + std::abs(change);
      if (sense != state.sense) Turn(now_[axis].position, &state);
      state.sense = sense;
      state.last_move = change;
      GoBeyondTurns(&state);
    }
    const double stated = now.senses != nullptr ? now.senses[axis] : 0.0;
    if (stated != 0.0 && stated != state.sense) {
      state.sense = stated;
      state.travel_since_reversal = 0.0;
      Turn(state.position, &state);
    }
    now_[axis] = state;
    states[axis] = state;
  }
  if (now.time_s != nullptr) last_time_s_ = *now.time_s;
  is_first_ = false;
}

void DeriveMotion(MeasuringRun* run) {
  const int axes = run->axis_count, readings = run->reading_count();
  std::vector<shapes::AxisState> states(static_cast<size_t>(axes) * readings);
  const auto moment = [&](int k) {
    if (k >= readings) return Moment();
    const double* const senses =
        run->stated_senses.empty() ? nullptr : &run->stated_senses[static_cast<size_t>(k) * axes];
    return Moment{run->PositionsOf(k), run->has_time ? &run->time_s[k] : nullptr, senses};
  };
  FirstMotion first(axes);
  for (int k = 0; k < readings && !first.is_known(); ++k) first.Add(run->PositionsOf(k), moment(k).time_s);
  Motion motion(first.starts());
  for (int k = 0; k < readings; ++k) motion.Next(moment(k), moment(k + 1), &states[static_cast<size_t>(k) * axes]);
  run->axis_states = std::move(states);
}

}  // namespace axiscal::instruments
