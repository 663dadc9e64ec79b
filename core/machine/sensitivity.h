// How the six error components of every joint move the tool point against a point on the table: the exact derivative of
// chain.h at given errors, written out because it is needed for every reading (a test holds it against automatic
// derivatives of the chain).
#ifndef AXISCAL_CORE_MACHINE_SENSITIVITY_H_
#define AXISCAL_CORE_MACHINE_SENSITIVITY_H_

#include "core/machine/chain.h"

namespace axiscal::machine {

// What depends on a joint's angle errors alone.
struct ErrorTurn {
  Eigen::Vector3d angles_rad = Eigen::Vector3d::Zero();
  bool is_zero = true;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  // Columns: the axes about which a small change of EA, EB, EC turns what the joint carries, in the parent's frame.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
};
ErrorTurn TurnOf(const ErrorVector<double>& error);

struct RelativePoint {
  ChainPose<double> pose;
  Eigen::Vector3d tip_in_bed_mm;   // actual tool point
  Eigen::Vector3d ball_in_bed_mm;  // actual point on the table
  // 3 x 6 joint_count; column 6 j + c: d(tip - ball) in the bed's axes per unit of component c of joint j (mm per mm,
  // mm per rad).
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kComponents * kMaxJoints> sensitivity;
  std::array<ErrorTurn, kMaxJoints> turns;  // of each joint; kept between calls while its angle errors stay the same
};

// `tip_mm` and `ball_mm` at home in the machine frame. Fills `out` (its storage is reused between calls).
void EvaluateRelativePoint(const Machine& machine, const double* positions, const JointErrors<double>& errors,
                           const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& ball_mm, RelativePoint* out);

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_SENSITIVITY_H_
