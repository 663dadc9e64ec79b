// What a compensator holds, and what its parts share. Private to compensator.cc (made, asked), inverse.cc (the commands
// at one pose) and departure.cc (how far corrections bend along moves).
#ifndef AXISCAL_CORE_COMPENSATE_COMPENSATOR_IMPL_H_
#define AXISCAL_CORE_COMPENSATE_COMPENSATOR_IMPL_H_

#include <array>
#include <string>
#include <vector>

#include "core/compensate/compensator.h"
#include "core/compensate/error_polynomial.h"
#include "core/compensate/folded_chain.h"

namespace axiscal::compensate {

struct Compensator::Impl {
  machine::Machine machine;
  Options options;
  machine::ErrorModel carried;
  std::vector<std::string> not_carried;
  std::vector<int> linear_axes;
  std::array<bool, machine::kMaxAxes> uses_sense{};
  bool is_constant = true;  // all carried terms are, at the stated time and temperature
  FoldedChain nominal, actual;
  std::optional<ErrorPolynomial> polynomial;  // of constant errors, where the machine has one
  // For DepartureBound: sums of the magnitudes of the constant terms, and the terms that are not constant.
  double fixed_lever_mm = 0, translation_errors_mm = 0, angle_errors_rad = 0;
  std::vector<machine::ErrorTerm> varying;
  // The sum of the constant terms. The maps of joints with varying terms are not folded but made at every pose.
  machine::JointErrors<double> constant;
  std::vector<int> varying_joints;
  std::array<double, machine::kMaxAxes> smooth_travel{};

  // departure.cc
  // Sums of the errors and the travels over which they look straight, of `carried`.
  void MeasureErrors();
  // Twice the angle that a move turns (once for the errors, once for the inverse), its length, and its longest lever.
  struct Extent {
    double turn_rad = 0, travel_mm = 0, lever_mm = 0;
  };
  Extent ExtentOf(const AxisValues& from, const AxisValues& to) const;
  // How much the tool point's error changes per mm of change of the linear axes near a pose, at most.
  double ErrorSlope(const Pose& pose) const;

  // inverse.cc
  absl::Status RequireFinite(const Pose& pose) const;
  absl::Status Correct(const Pose& pose, const double* near_mm, Correction* correction) const;
  absl::Status CorrectTurned(const Pose& pose, const AxisValues& turned, const double* near_mm,
                             Correction* correction) const;
  void EvaluateNominal(const Pose& pose, const Turns& turns, AffineTip* wanted) const;
  void Aim(const Pose& commanded, TurnColumns* columns) const;
  // The maps of the joints with varying terms at a pose.
  void MapsAt(const Pose& pose, JointMaps* maps) const;

 private:
  absl::Status RankError(const Pose& pose) const;
  // Commands of the linear axes that move the tool point by `move_mm`; the shortest ones when there are more than three
  // axes.
  absl::Status Solve(const Pose& pose, const Eigen::Vector3d* tip_per_mm, const Eigen::Vector3d& move_mm,
                     double* change_mm) const;
  // One step with the errors at `commanded`: how far the tool point is off, and the step that would bring it there.
  absl::Status Step(const Pose& pose, const JointMaps& maps, const Turns& turns, const AffineTip& wanted,
                    Pose* commanded, Eigen::Vector3d* lacking_mm, double* change_mm, AffineTip* found) const;
  void Apply(const double* change_mm, AxisValues* positions) const {
    for (size_t k = 0; k < linear_axes.size(); ++k) (*positions)[linear_axes[k]] += change_mm[k];
  }
  void Finish(const AffineTip& wanted, const AffineTip& found, double after_mm, Correction* correction) const;
  // Correct by `polynomial`.
  absl::Status CorrectByPolynomial(const Pose& pose, Correction* correction) const;
  // The commands of the linear axes that bring the tool point to `wanted`, the rotary axes being at `pose`.
  absl::Status Reach(const Pose& pose, const Turns& turns, const AffineTip& wanted, const double* near_mm,
                     Correction* correction) const;
  // Errors that vary with the position act at the command that the machine gets. So the step is repeated until the last
  // change of the command can have changed the errors by less than the tolerance. Starts at `near_mm`.
  absl::Status Iterate(const Pose& pose, const Turns& turns, const AffineTip& wanted, const double* near_mm,
                       Correction* correction) const;
};

}  // namespace axiscal::compensate

#endif  // AXISCAL_CORE_COMPENSATE_COMPENSATOR_IMPL_H_
