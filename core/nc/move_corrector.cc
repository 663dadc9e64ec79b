#include "core/nc/move_corrector.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"

namespace axiscal::nc {
namespace {

constexpr int kMinIntervals = 4;
constexpr int kMaxIntervals = 8192;
// Samples that stand in one piece of a split move, at least: the departure between two samples is then 1/64 of the
// piece's.
constexpr int kSamplesPerPiece = 8;
// Rounding of words and the samples' spacing must not carry a piece beyond the tolerance.
constexpr double kShare = 0.95;
constexpr double kTurnedSamples = 4.0;
constexpr double kMostToleranceMm = 1.0;  // an infinite tolerance still weighs directions

}  // namespace

// Largest distance of the samples between `first` and `last` from the straight line between these two.
double MoveCorrector::ChordDeparture(const Samples& samples, int first, int last) const {
  static const Effect kNone;
  double largest = 0;
  const double length = last - first;
  const Change &from = samples.changes[static_cast<size_t>(first)], &to = samples.changes[static_cast<size_t>(last)];
  for (int i = first + 1; i < last; ++i) {
    const double t = (i - first) / length;
    const Change difference = samples.changes[static_cast<size_t>(i)] - ((1.0 - t) * from + t * to);
    largest = std::max(largest, Weight(difference, orientation_ ? samples.effects[static_cast<size_t>(i)] : kNone));
  }
  return largest * samples.scale;
}

MoveCorrector::MoveCorrector(const compensate::Compensator& compensator, const RewriteOptions& options,
                             double length_mm)
    : compensator_(&compensator),
      frame_(compensator.machine(), options.tool_tip_mm),
      length_mm_(length_mm),
      tolerance_mm_(options.tolerance_mm),
      axis_count_(compensator.machine().axis_count()),
      orientation_(options.orientation),
      max_rotary_correction_rad_(options.max_rotary_correction_rad),
      mm_per_rad_(std::min(options.tolerance_mm, kMostToleranceMm) / options.tolerance_rad),
      begins_near_(options.orientation || !compensator.is_constant()),
      corrected_(compensator.linear_axes()) {
  for (int i = 0; i < axis_count_; ++i) {
    const bool is_rotary = compensator.machine().axes[i].kind == machine::AxisKind::kRotary;
    unit_per_tick_[i] = (is_rotary ? base::kRadPerDeg : 1.0) / kTicksPerUnit;
    uses_sense_ |= compensator.uses_sense(i);
    if (is_rotary && orientation_) corrected_.push_back(i);
  }
}

absl::Status MoveCorrector::CorrectAt(const AxisTicks& nominal, const Senses& senses, const WordGrain& grain,
                                      Piece* piece) const {
  if (piece->is_tool_point) {
    for (int i = 0; i < axis_count_; ++i) {
      piece->pose.sense[i] = senses[i];
      piece->nominal[i] = nominal[i];
    }
    return CorrectWords(grain, piece);
  }
  compensate::AxisValues near;
  if (begins_near_) {
    for (const int axis : corrected_)
      near[axis] = static_cast<double>(piece->targets[axis] - piece->nominal[axis]) * unit_per_tick_[axis];
  }
  compensate::Pose& pose = piece->pose;
  for (int i = 0; i < axis_count_; ++i) {
    pose.position[i] = static_cast<double>(nominal[i]) * unit_per_tick_[i];
    pose.sense[i] = senses[i];
    piece->nominal[i] = piece->targets[i] = nominal[i];
  }
  if (orientation_) return TurnAt(near, grain, piece);
  RETURN_IF_ERROR(compensator_->Correct(pose, near, &piece->correction));
  for (const int axis : compensator_->linear_axes()) {
    // The change alone is converted: a position of 500 mm has no digits to lose to it.
    const double change_mm = piece->correction.corrected[axis] - pose.position[axis];
    if (!(std::abs(change_mm) < 1e5)) return absl::FailedPreconditionError("the correction is beyond any machine");
    piece->targets[axis] += NearestTick(change_mm * kTicksPerUnit);
  }
  return absl::OkStatus();
}

absl::Status MoveCorrector::CorrectEnd(const Step& step, const WordGrain& grain, Piece* piece) const {
  piece->end_fraction = 1.0;
  Begin(step, piece);
  return CorrectAt(step.end.ticks, step.end.sense, grain, piece);
}

absl::Status MoveCorrector::CorrectStart(const Step& step, const WordGrain& grain, Piece* piece) const {
  piece->end_fraction = 0.0;
  Begin(step, piece);
  return CorrectAt(step.start.ticks, step.is_arc ? SensesOfArc(step, 0.0) : step.end.sense, grain, piece);
}

AxisTicks MoveCorrector::Between(const Step& step, double fraction) const {
  AxisTicks nominal{};
  for (int i = 0; i < axis_count_; ++i) {
    const double travel = static_cast<double>(step.end.ticks[i] - step.start.ticks[i]);
    nominal[i] = step.start.ticks[i] + std::llround(travel * fraction);
  }
  if (step.is_arc && fraction > 0.0 && fraction < 1.0) {
    const Eigen::Vector2d at_mm = step.arc.At(fraction);
    nominal[step.arc.first] = std::llround(at_mm.x() * kTicksPerUnit);
    nominal[step.arc.second] = std::llround(at_mm.y() * kTicksPerUnit);
  }
  return nominal;
}

absl::Status MoveCorrector::Sample(const Step& step, int intervals, Samples* samples) const {
  samples->changes.clear();
  samples->effects.clear();
  Piece piece;
  Begin(step, &piece);
  samples->scale = ScaleOf(piece.placed);
  for (int k = 0; k <= intervals; ++k) {
    RETURN_IF_ERROR(CorrectAt(Between(step, static_cast<double>(k) / intervals), step.end.sense, WordGrain(), &piece));
    samples->changes.push_back(ChangeOf(piece.targets, piece.nominal));
    if (orientation_) samples->effects.push_back(EffectAt(piece));
  }
  return absl::OkStatus();
}

int MoveCorrector::SampleIntervals(const Step& step) const {
  double intervals = kMinIntervals;
  const compensate::AxisValues travels = step.is_tool_point ? AxisTravels(step) : compensate::AxisValues();
  for (int i = 0; i < axis_count_; ++i) {
    const double travel = std::max(
        travels[i], std::abs(static_cast<double>(step.end.ticks[i] - step.start.ticks[i])) * unit_per_tick_[i]);
    // Near singular poses rotary corrections bend within a few degrees.
    const double finer = orientation_ ? kTurnedSamples : 1.0;
    intervals = std::max(intervals, kMinIntervals * std::ceil(finer * travel / compensator_->smooth_travel(i)));
  }
  return static_cast<int>(std::min<double>(intervals, kMaxIntervals));
}

absl::StatusOr<double> MoveCorrector::Departure(const Step& step, const Piece& end) const {
  compensate::AxisValues from;
  for (int i = 0; i < axis_count_; ++i) from[i] = static_cast<double>(step.start.ticks[i]) * unit_per_tick_[i];
  const compensate::AxisValues& to = end.pose.position;
  const double bound_mm = step.is_tool_point ? ToolPointDepartureBound(step)
                          : orientation_     ? TurnedDepartureBound(from, to, end)
                                             : compensator_->DepartureBound(from, to);
  if (bound_mm <= tolerance_mm_) return bound_mm;
  Samples samples;
  const int intervals = SampleIntervals(step);
  RETURN_IF_ERROR(Sample(step, intervals, &samples));
  return ChordDeparture(samples, 0, intervals);
}

absl::StatusOr<std::vector<Piece>> MoveCorrector::Split(const Step& step, const WordGrain& grain) const {
  Samples samples;
  int intervals = SampleIntervals(step);
  std::vector<int> ends;
  while (true) {
    RETURN_IF_ERROR(Sample(step, intervals, &samples));
    ends.clear();
    int shortest = intervals;
    for (int first = 0; first < intervals;) {
      int last = first + 1;
      while (last < intervals && ChordDeparture(samples, first, last + 1) <= kShare * tolerance_mm_) ++last;
      if (last < intervals) shortest = std::min(shortest, last - first);
      ends.push_back(last);
      first = last;
    }
    if (static_cast<int>(ends.size()) > kMaxPieces) {
      return absl::FailedPreconditionError(absl::StrCat("the move needs more than ", kMaxPieces, " pieces"));
    }
    if (shortest >= kSamplesPerPiece || intervals >= kMaxIntervals) break;
    intervals = std::min(2 * intervals, kMaxIntervals);
  }
  // As many pieces of equal length, where they keep the tolerance too: even, and with plain numbers.
  const int count = static_cast<int>(ends.size());
  const int even_length = (intervals + count - 1) / count;
  RETURN_IF_ERROR(Sample(step, even_length * count, &samples));
  bool is_even = true;
  for (int k = 0; k < count && is_even; ++k) {
    is_even = ChordDeparture(samples, k * even_length, (k + 1) * even_length) <= kShare * tolerance_mm_;
  }
  if (is_even) {
    intervals = even_length * count;
    for (int k = 0; k < count; ++k) ends[static_cast<size_t>(k)] = (k + 1) * even_length;
  }
  std::vector<Piece> pieces(ends.size());
  for (size_t k = 0; k < ends.size(); ++k) {
    Piece& piece = pieces[k];
    piece.end_fraction = static_cast<double>(ends[k]) / intervals;
    Begin(step, &piece);
    AxisTicks nominal = Between(step, piece.end_fraction);
    // Rotary axes are written as nominal, and linear ones at such numbers are short where no correction changes them.
    for (int i = 0; i < axis_count_ && k + 1 < ends.size(); ++i) nominal[i] = grain.Held(i, nominal[i]);
    RETURN_IF_ERROR(CorrectAt(nominal, step.end.sense, grain, &piece));
  }
  return pieces;
}

}  // namespace axiscal::nc
