#include <cmath>

#include "core/instruments/run.h"

namespace axiscal::instruments {
namespace {

// The sense in which an axis starts: that of its first change, 0 if it never moves.
double FirstSense(const MeasuringRun& run, int axis) {
  for (int k = 1; k < run.reading_count(); ++k) {
    const double change = run.PositionsOf(k)[axis] - run.PositionsOf(k - 1)[axis];
    if (change != 0.0) return change > 0.0 ? 1.0 : -1.0;
  }
  return 0.0;
}

}  // namespace

void DeriveMotion(MeasuringRun* run) {
  const int axes = run->axis_count, readings = run->reading_count();
  run->axis_states.assign(static_cast<size_t>(axes) * readings, {});
  for (int axis = 0; axis < axes; ++axis) {
    shapes::AxisState state;
    state.sense = FirstSense(*run, axis);
    for (int k = 0; k < readings; ++k) {
      const double position = run->PositionsOf(k)[axis];
      const double change = k == 0 ? 0.0 : position - state.position;
      state.position = position;
      state.speed = 0.0;
      if (change != 0.0) {
        const double sense = change > 0.0 ? 1.0 : -1.0;
        // A reversal happened at the reading before: its travel is what has been covered since. Breaking away from rest
        // counts as one.
        const bool is_reversal = sense != state.sense || std::isinf(state.travel_since_reversal);
        state.travel_since_reversal = (is_reversal ? 0.0 : state.travel_since_reversal) + std::abs(change);
        state.sense = sense;
        const double elapsed_s = run->has_time ? run->time_s[k] - run->time_s[k - 1] : 0.0;
        if (elapsed_s > 0.0) state.speed = change / elapsed_s;
      }
      run->axis_states[static_cast<size_t>(k) * axes + axis] = state;
    }
    // As with the sense: the first position is taken to be approached at the speed of the first change.
    if (readings > 1) run->axis_states[axis].speed = run->axis_states[static_cast<size_t>(axes) + axis].speed;
  }
}

}  // namespace axiscal::instruments
