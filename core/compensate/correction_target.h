// What a table of corrections should hold: the exact correction of every axis as a function of the axis positions,
// less the correction at a reference pose (tables are zero there; a constant shift belongs into a work offset).
//
// Linear axes: compensator.h, the exact inverse of the chain. Rotary axes that are corrected: minus the joint's own
// angle error about the axis (EAA, EBB, ECC of axes A, B, C), and the linear axes are corrected for what that leaves.
#ifndef AXISCAL_CORE_COMPENSATE_CORRECTION_TARGET_H_
#define AXISCAL_CORE_COMPENSATE_CORRECTION_TARGET_H_

#include <array>
#include <vector>

#include "core/compensate/compensator.h"
#include "core/compensate/table.h"

namespace axiscal::compensate {

class CorrectionTarget {
 public:
  // `corrected_rotary`: per axis, whether a table turns it. The senses of `reference` are not used. Errors of
  // Compensator::Create and Correct.
  static absl::StatusOr<CorrectionTarget> Create(const machine::Machine& machine, const machine::ErrorModel& errors,
                                                 const Options& options, const Pose& reference,
                                                 const std::array<bool, machine::kMaxAxes>& corrected_rotary);

  // Of every axis, mm or rad.
  absl::StatusOr<Positions> At(const Pose& pose) const;
  // The same with one axis at `position`, moving in `sense` (0: the mean of both), the others at the reference.
  absl::StatusOr<Positions> Along(int axis, double position, double sense) const;

  const Pose& reference() const { return reference_; }
  // The correction at the reference pose, which the above leave out.
  const Positions& constant() const { return constant_; }

 private:
  CorrectionTarget(Compensator compensator, const Pose& reference);
  absl::StatusOr<Positions> Whole(const Pose& pose) const;

  Compensator compensator_;
  Pose reference_;
  machine::ErrorModel turns_;  // the terms that corrected rotary axes take away
  std::vector<int> turned_;
  Options options_;
  Positions constant_{};
};

}  // namespace axiscal::compensate

#endif  // AXISCAL_CORE_COMPENSATE_CORRECTION_TARGET_H_
