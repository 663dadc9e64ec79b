// From a nominal move to commanded positions: the correction at its end, and where the move must be split because the
// correction along it departs from linear by more than the tolerance.
#ifndef AXISCAL_CORE_NC_MOVE_CORRECTOR_H_
#define AXISCAL_CORE_NC_MOVE_CORRECTOR_H_

#include <vector>

#include "core/base/status.h"
#include "core/compensate/compensator.h"
#include "core/nc/interpreter.h"

namespace axiscal::nc {

// One straight piece of the written move.
struct Piece {
  double end_fraction = 1.0;  // of the nominal move
  AxisTicks nominal{};        // axis positions at its end
  compensate::Correction correction;
  AxisTicks targets{};  // corrected, exact; rotary axes as nominal
};

class MoveCorrector {
 public:
  MoveCorrector(const compensate::Compensator& compensator, const RewriteOptions& options);

  // The corrected end of a move whose positions are known. Fills `piece`. Errors of Compensator::Correct.
  absl::Status CorrectEnd(const Step& step, Piece* piece) const;

  // How far the correction along the move departs from the straight line between its ends: an upper bound where that is
  // below the tolerance, sampled otherwise. The move's start must be known.
  absl::StatusOr<double> Departure(const Step& step) const;

  // As few pieces as samples of the correction allow, the last one ending the move, each within the tolerance.
  // Positions between the pieces are rounded to `grain`, per axis. FAILED_PRECONDITION
  // when more than kMaxPieces would be needed.
  absl::StatusOr<std::vector<Piece>> Split(const Step& step, const AxisTicks& grain) const;

  static constexpr int kMaxPieces = 1000;

 private:
  // Corrections of the linear axes, mm.
  using Change = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, machine::kMaxAxes, 1>;

  static double ChordDeparture(const std::vector<Change>& samples, int first, int last);
  void PoseAt(const AxisTicks& nominal, const Step& step, compensate::Pose* pose) const;
  AxisTicks Between(const Step& step, double fraction) const;
  absl::Status CorrectAt(const AxisTicks& nominal, const Step& step, Piece* piece) const;
  // At equidistant points of the move, both ends included.
  absl::Status Sample(const Step& step, int intervals, std::vector<Change>* corrections) const;
  int SampleIntervals(const Step& step) const;

  const compensate::Compensator* compensator_;
  double tolerance_mm_;
  int axis_count_;
  std::array<double, machine::kMaxAxes> unit_per_tick_{};  // mm or rad
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_MOVE_CORRECTOR_H_
