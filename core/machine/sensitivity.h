// How the six error components of every joint move the tool point against a point on the table: the exact derivative of
// chain.h at given errors, written out because it is needed for every reading (a test holds it against automatic
// derivatives of the chain).
#ifndef AXISCAL_CORE_MACHINE_SENSITIVITY_H_
#define AXISCAL_CORE_MACHINE_SENSITIVITY_H_

#include "core/machine/chain.h"

namespace axiscal::machine {

// The part of a joint's derivatives that depends on its angle errors alone.
struct ErrorTurn {
  Eigen::Vector3d angles_rad = Eigen::Vector3d::Zero();
  bool is_zero = true;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  // Columns: the axes about which a small change of EA, EB, EC turns what the joint carries, in the parent's frame.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
};
ErrorTurn TurnOf(const ErrorVector<double>& error);

// Where a joint's error acts, and the lever from there to the point that its branch carries; in the bed's axes.
struct JointPlace {
  double sign = 1.0;  // +1 on the tool's branch, -1 on the table's
  Eigen::Matrix3d bed_from_parent = Eigen::Matrix3d::Zero();
  // bed_from_parent * rotation of the joint's ErrorTurn, where that is not zero; kept between calls while both factors
  // stay the same, as they do up to the first axis that turns.
  Eigen::Matrix3d bed_from_turned;
  Eigen::Vector3d lever_mm;
};

struct RelativePoint {
  ChainPose<double> pose;
  Eigen::Vector3d tip_in_bed_mm;              // actual tool point
  Eigen::Vector3d ball_in_bed_mm;             // actual point on the table
  std::array<JointPlace, kMaxJoints> places;  // by joint
  std::array<ErrorTurn, kMaxJoints> turns;    // by joint; kept between calls while its angle errors stay the same
  // 3 x 6 joint_count; column 6 j + c: d(tip - ball) in the bed's axes per unit of component c of joint j (mm per mm,
  // mm per rad).
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kComponents * kMaxJoints> sensitivity;
};

// `tip_mm` and `ball_mm` at home in the machine frame. Fills `out` (its storage is reused between calls).
void EvaluateRelativePoint(const Machine& machine, const double* positions, const JointErrors<double>& errors,
                           const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& ball_mm, RelativePoint* out);

// The same without `sensitivity`, for readings that sense one direction only.
void EvaluatePlaces(const Machine& machine, const double* positions, const JointErrors<double>& errors,
                    const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& ball_mm, RelativePoint* out);
// Row 6 j + c: d(tip - ball) along `direction` (unit, bed's axes), from the places in `point`.
void SensitivityAlong(const Machine& machine, const RelativePoint& point, const Eigen::Vector3d& direction,
                      double* row);

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_SENSITIVITY_H_
