// Compensation as Yao 2022 publishes it. The rule that alone reproduces the compensated program of Fig 4.30,
//   X - b Z, Y, Z + b X      X, Y, Z as commanded, about the machine's origin; b = bXB of Table 4.5, as printed
// and equation 3.13, which as printed corrects twice. What both lack: b has the other sign in the model (Table 2.6),
// and its lever is the tool point from B's pivot, not the command from the machine's origin.
#ifndef AXISCAL_CORE_PUBLISHED_YAO_COMPENSATION_H_
#define AXISCAL_CORE_PUBLISHED_YAO_COMPENSATION_H_

#include <Eigen/Core>

namespace axiscal::published {

inline constexpr double kTimesOfYao313 = 2.0;

// The rule; `times` of equation 3.13 or 1. With the tool point from the pivot for `command_mm` and the model's b it is
// the correction to first order.
Eigen::Vector3d YaoRule(const Eigen::Vector3d& command_mm, double b_rad, double times = 1.0);

}  // namespace axiscal::published

#endif  // AXISCAL_CORE_PUBLISHED_YAO_COMPENSATION_H_
