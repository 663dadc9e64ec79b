// Where a machine's tool stands over its table, for many poses: the product of core/machine/chain.h, worked out once as
// far as it is the same at every pose. Made for core/nc/verify.h of transforms and shapes alone: it shares nothing
// with what core/compensate folds, and its test holds it to EvaluateChain and ErrorsAt.
//   leg   p_outer = rotation p_inner + at_mm + sum of ways_k q_k, then a rotary axis or an error that is not constant
// Joints between two rotary axes whose errors are constant are one leg. Lengths mm, angles rad.
#ifndef AXISCAL_CORE_NC_TOOL_CHAIN_H_
#define AXISCAL_CORE_NC_TOOL_CHAIN_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/machine/error_model.h"
#include "core/machine/machine.h"

namespace axiscal::nc {

// The tool in the table's frame: its point, and the unit direction from it to the spindle's side or away from it, as
// Machine::tool_direction says.
struct ToolPose {
  Eigen::Vector3d tip_mm, direction;
};

using AxisSenses = std::array<int8_t, machine::kMaxAxes>;  // of motion: +1, -1, 0 unknown

// Positions of all axes (mm, rad) with the sines and cosines of rotary ones.
struct AxesAt {
  std::array<double, machine::kMaxAxes> position{}, sine{}, cosine{};
};

class ToolChain {
 public:
  // Errors at one moment and temperature. `machine` must outlive it.
  ToolChain(const machine::Machine& machine, const machine::ErrorModel& errors, double time_s,
            double temperature_celsius);

  // `like`: of a pose whose rotary axes may stand at the same positions.
  static AxesAt Prepare(const machine::Machine& machine, const std::array<double, machine::kMaxAxes>& positions,
                        const AxesAt* like);
  // `tip_mm`: the nominal tool point at home, machine frame.
  ToolPose At(const AxesAt& axes, const AxisSenses& senses, const Eigen::Vector3d& tip_mm) const;

 private:
  struct Way {
    int axis;
    Eigen::Vector3d by_position;  // mm per mm
  };
  struct Leg {
    bool is_turned = false;  // `rotation` is not the identity
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Eigen::Vector3d at_mm = Eigen::Vector3d::Zero();
    std::vector<Way> ways;
    // What ends it, -1: nothing. Of the rotary axis `direction`; its point is in at_mm of this leg and the next one.
    int rotary = -1, varying_joint = -1;
    Eigen::Vector3d direction;
    int along = -1;  // of a rotary axis about a coordinate axis: which, 0 to 2
  };
  std::vector<Leg> MakeLegs(const std::vector<int>& axes, int end_joint) const;
  machine::JointErrors<double> VaryingAt(const AxesAt& axes, const AxisSenses& senses) const;

  const machine::Machine& machine_;
  double time_s_, temperature_celsius_;
  machine::JointErrors<double> constant_;  // of joints without a varying term: all of their errors
  machine::ErrorModel varying_;            // the terms that are not constant
  std::vector<Leg> tool_legs_, work_legs_;
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_TOOL_CHAIN_H_
