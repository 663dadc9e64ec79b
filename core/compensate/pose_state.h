// A pose as the state on which error terms depend.
#ifndef AXISCAL_CORE_COMPENSATE_POSE_STATE_H_
#define AXISCAL_CORE_COMPENSATE_POSE_STATE_H_

#include <array>

#include "core/compensate/compensator.h"
#include "core/shapes/state.h"

namespace axiscal::compensate {

class PoseState {
 public:
  // Moment and temperature are those of the options, or the shapes' references.
  PoseState(const machine::Machine& machine, const Pose& pose, const Options& options) {
    for (int i = 0; i < machine.axis_count(); ++i) {
      axes_[i].position = pose.position[i];
      axes_[i].sense = pose.sense[i];
    }
    state_.axes = {axes_.data(), static_cast<size_t>(machine.axis_count())};
    if (options.time_s) state_.time_s = *options.time_s;
    if (options.temperature_celsius) state_.temperature_celsius = *options.temperature_celsius;
  }
  // The state points into its axes.
  PoseState(const PoseState&) = delete;
  PoseState& operator=(const PoseState&) = delete;

  const shapes::State& state() const { return state_; }

 private:
  std::array<shapes::AxisState, machine::kMaxAxes> axes_;
  shapes::State state_;
};

}  // namespace axiscal::compensate

#endif  // AXISCAL_CORE_COMPENSATE_POSE_STATE_H_
