#include "core/instruments/plausible.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/instruments/bind_readings.h"
#include "core/instruments/eccentricity/eccentricity_bind.h"
#include "core/instruments/evaluation.h"
#include "core/instruments/length/length_model.h"
#include "core/instruments/registry.h"
#include "core/instruments/tracker/tracker_bind.h"
#include "core/instruments/tracker/tracker_model.h"
#include "core/session/column_rules.h"

namespace axiscal::instruments {
namespace {

// By how much what the nominal machine would read can differ between two readings, at most: dense series need not be
// predicted reading by reading. A linear axis moves tool against table by what it moves itself; a rotary axis moves
// either by its angle times their distance from it. That distance is never more than
//   |tool tip| + |table ball| + 3 sum |points on rotary axes| + sum of the farthest linear positions,
// since turning about a point p takes a point no farther from the origin than 2 |p|.
class NominalReach {
 public:
  NominalReach(const machine::Machine& machine, const MeasuringRun& run)
      : run_(run), mm_per_unit_(static_cast<size_t>(run.axis_count), 1.0) {
    // Commands of sphere centres follow from the rotary axes by a condition of their own: nothing is surely near.
    if (run.kind != Kind::kBallbar && run.kind != Kind::kRtest) {
      mm_per_unit_.assign(mm_per_unit_.size(), std::numeric_limits<double>::infinity());
      return;
    }
    const Eigen::Map<const Eigen::MatrixXd> positions(run.positions.data(), run.axis_count, run.reading_count());
    double farthest_mm = run.tip_mm.norm() + run.ball_mm.norm();
    for (int i = 0; i < run.axis_count; ++i) {
      const machine::Axis& axis = machine.axes[i];
      farthest_mm +=
          axis.kind == machine::AxisKind::kLinear ? positions.row(i).cwiseAbs().maxCoeff() : 3.0 * axis.point_mm.norm();
    }
    for (int i = 0; i < run.axis_count; ++i) {
      if (machine.axes[i].kind == machine::AxisKind::kRotary) mm_per_unit_[i] = farthest_mm;
    }
  }

  double Between(int one, int other) const {
    const double *const a = run_.PositionsOf(one), *const b = run_.PositionsOf(other);
    double reach_mm = 0.0;
    for (size_t i = 0; i < mm_per_unit_.size(); ++i) reach_mm += mm_per_unit_[i] * std::abs(a[i] - b[i]);
    return reach_mm;
  }

 private:
  const MeasuringRun& run_;
  std::vector<double> mm_per_unit_;  // per axis: mm per mm or rad
};

// Whether the reading is near what would be read there, since that is within `reach_mm` of `predicted_mm`.
bool IsSurelyNear(const MeasuringRun& run, int reading, const double* predicted_mm, double reach_mm) {
  constexpr double kRoundingMm = 1.0;  // much more than all sums above, and directions that are units, can be off by
  double most_mm = 0.0;
  for (int row = 0; row < run.row_count; ++row)
    most_mm = std::max(most_mm, std::abs(predicted_mm[row] - run.measured_mm(row, reading)));
  return most_mm + reach_mm + kRoundingMm <= kMaxDisagreementMm;
}

}  // namespace

absl::Status CheckPlausible(const session::Session& session, const machine::Machine& machine, size_t readings_before,
                            const std::vector<size_t>* log_lines) {
  const Instrument* instrument = FindInstrument(session::FindHeader(session, "instrument").value_or(""));
  if (instrument == nullptr) return absl::OkStatus();
  // Eccentricities without paths are stored, but nothing is identified from them.
  if (instrument->kind == Kind::kEccentricity && !eccentricity::HasPaths(session)) return absl::OkStatus();
  ASSIGN_OR_RETURN(MeasuringRun run, BindReadings(session, machine, readings_before, log_lines));
  if (run.kind == Kind::kTouch || run.kind == Kind::kEccentricity) return absl::OkStatus();  // gated when bound
  RETURN_IF_ERROR(CheckAlive(session, run, log_lines));
  if (run.kind == Kind::kDirection) return absl::OkStatus();
  if (run.kind == Kind::kTracker) run.tracker_from_machine = tracker::StartingPose(machine, run);
  if (run.kind == Kind::kLength && !length::HasStatedZero(run)) run.length.zero_mm = length::StartingZero(machine, run);
  const machine::JointErrors<double> no_errors;
  const double no_setup[kMaxSetupParameters] = {};
  const NominalReach reach(machine, run);
  double predicted_mm[kMaxRows];
  int predicted = -1;  // the reading that predicted_mm is of
  for (int reading = 0; reading < run.reading_count(); ++reading) {
    if (run.targets.IsReference(reading)) continue;  // whose place is known roughly
    if (predicted >= 0 && IsSurelyNear(run, reading, predicted_mm, reach.Between(predicted, reading))) continue;
    Predict(machine, run, reading, no_errors, no_setup, predicted_mm);
    predicted = reading;
    for (int row = 0; row < run.row_count; ++row) {
      const double measured_mm = run.measured_mm(row, reading);
      if (std::abs(predicted_mm[row] - measured_mm) <= kMaxDisagreementMm) continue;
      const size_t place = readings_before + static_cast<size_t>(reading);
      return absl::InvalidArgumentError(absl::StrFormat(
          "line %d: reading %d of session '%s': %s = %g mm, but at these positions the nominal machine would read %g "
          "mm, expected within %g mm: are the units (mm, deg), the signs of machine %s, tool_tip_mm and table_ball_mm "
          "right?%s",
          session::ReadingLine(session.header.size(), place, log_lines), place + 1, run.session,
          instrument->reading_columns[row], measured_mm, predicted_mm[row], kMaxDisagreementMm, machine.id,
          run.kind == Kind::kLength    ? " (and anchor_mm or beam; the zero is the middle reading's)"
          : run.kind == Kind::kTracker ? " (the tracker stands where its readings fit best)"
                                       : ""));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckWhole(const session::Session& session) {
  const Instrument* const instrument = FindInstrument(session::FindHeader(session, "instrument").value_or(""));
  if (instrument == nullptr || instrument->kind != Kind::kTracker) return absl::OkStatus();
  MeasuringRun run;
  return base::Within(absl::StrCat("session '", session::FindHeader(session, "session").value_or(""), "'"),
                      tracker::BindTargets(session, /*is_whole=*/true, &run));
}

}  // namespace axiscal::instruments
