// The rotary-axis commands whose predicted tool direction, on this machine, is the programmed one; the turn of the tool
// about itself is free. Together with Compensator::CorrectTurned, which brings the tool point along, this is the
// inverse of the chain in all axes.
//
// With J the tool direction's motion per rad of each rotary axis (table frame), e the missing direction plus J d,
// and s_k, u_k, v_k the singular values and vectors of J, the change of the commands is the fixed point of
//   d = sum over k of v_k d_k,   d_k = (u_k e) / s_k              where that is at most the bound
//                                d_k = s_k bound^2 / (u_k e)      where it is more: near a singular pose
// so it is exact (to kToleranceRad) wherever the bound allows, never larger than the bound, goes to zero towards the
// singular pose from both sides instead of swinging the axis round, and is continuous along moves. The commands stay on
// the programmed branch, within the bound of what was programmed. Axes that would leave their travel stop at its end,
// and the others turn the tool as far as they can. The rest is stated, with its reason.
#ifndef AXISCAL_CORE_COMPENSATE_ORIENTATION_H_
#define AXISCAL_CORE_COMPENSATE_ORIENTATION_H_

#include <Eigen/Core>
#include <array>
#include <string>

#include "core/compensate/compensator.h"

namespace axiscal::compensate {

inline constexpr double kDirectionToleranceRad = 1e-9;

// Why a direction was not reached.
enum class DirectionLimit {
  kNone,
  kNoAxis,  // no rotary axis turns the tool that way in this pose
  kBound,   // the pose is nearly singular: the change would be larger than the bound
  kTravel,  // a rotary axis would leave its travel
};

struct Turned {
  AxisValues position{};     // rotary commands, rad; linear axes near the answer, not exact
  double tilt_left_rad = 0;  // <= kDirectionToleranceRad unless there is a limit
  DirectionLimit limit = DirectionLimit::kNone;
  double least_turn = 0;  // the smallest s_k
  double needed_rad = 0;  // kBound: the change that would have reached it, to first order
};

// `bound_rad` > 0: largest change of a rotary command. `near`: commands minus programmed positions near the answer (mm,
// rad), where the iteration begins. Errors of Compensator::Correct.
absl::Status CorrectDirection(const Compensator& compensator, const Pose& pose, double bound_rad,
                              const AxisValues& near, Turned* turned);

// "a turn of 1.2 deg would be needed, the bound is 0.05 deg".
std::string ToString(const Turned& turned, double bound_rad);

}  // namespace axiscal::compensate

#endif  // AXISCAL_CORE_COMPENSATE_ORIENTATION_H_
