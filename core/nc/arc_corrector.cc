// Arcs of MoveCorrector: one arc again where the corrected points lie on one, else several, else chords.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/nc/move_corrector.h"

namespace axiscal::nc {
namespace {

constexpr int kLeastSamples = 8;           // inside a fitted arc
constexpr int kMostSamples = 4096;         // an arc that waves so often is no arc
constexpr double kSamplesPerTravel = 4.0;  // of the travel within which errors are smooth, as of straight moves
constexpr double kShare =
    0.95;  // rounding of words and the samples' spacing must not carry a piece beyond the tolerance
constexpr int kArcCounts[] = {1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64};
// Start and end lie so near that rounding could turn the arc into a full circle, or a full circle into nothing.
constexpr double kLeastGrains = 20.0;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::Vector2d PlanePoint(const AxisTicks& at, const Arc& arc) {
  return Eigen::Vector2d(static_cast<double>(at[arc.first]), static_cast<double>(at[arc.second])) / kTicksPerUnit;
}

// The position at a fraction of a straight move.
AxisTicks Mean(const AxisTicks& from, const AxisTicks& to, double t) {
  AxisTicks mean{};
  for (size_t i = 0; i < mean.size(); ++i) mean[i] = from[i] + std::llround(static_cast<double>(to[i] - from[i]) * t);
  return mean;
}

bool IsFull(const Arc& arc) { return std::abs(std::abs(arc.sweep_rad) - 2.0 * std::numbers::pi) < 1e-12; }

}  // namespace

MoveCorrector::Senses MoveCorrector::SensesOfArc(const Step& step, double fraction) const {
  Senses senses = step.end.sense;
  const double angle = step.arc.start_rad + fraction * step.arc.sweep_rad;
  const double along[2] = {-std::sin(angle) * step.arc.sweep_rad, std::cos(angle) * step.arc.sweep_rad};
  senses[step.arc.first] = along[0] > 0 ? 1 : -1;
  senses[step.arc.second] = along[1] > 0 ? 1 : -1;
  return senses;
}

std::vector<double> MoveCorrector::Reversals(const Step& step) const {
  std::vector<double> breaks = {0.0, 1.0};
  const Arc& arc = step.arc;
  for (const int axis : {arc.first, arc.second}) {
    if (!compensator_->uses_sense(axis)) continue;
    // cos has its extremes at multiples of pi, sin half a pi later.
    const double shift = axis == arc.first ? 0.0 : 0.5 * std::numbers::pi;
    const double low = std::min(arc.start_rad, arc.start_rad + arc.sweep_rad);
    const double high = std::max(arc.start_rad, arc.start_rad + arc.sweep_rad);
    for (double k = std::ceil((low - shift) / std::numbers::pi); k * std::numbers::pi + shift <= high; k += 1.0) {
      const double fraction = (k * std::numbers::pi + shift - arc.start_rad) / arc.sweep_rad;
      if (fraction > 1e-6 && fraction < 1.0 - 1e-6) breaks.push_back(fraction);
    }
  }
  std::sort(breaks.begin(), breaks.end());
  return breaks;
}

absl::Status MoveCorrector::CorrectOnArc(const Step& step, double fraction, const Senses& senses,
                                         const WordGrain& grain, Piece* piece) const {
  AxisTicks nominal = Between(step, fraction);
  // Rotary axes are written as nominal, so the nominal position is one that their words can hold.
  for (int i = 0; i < axis_count_ && fraction < 1.0; ++i) {
    if (compensator_->machine().axes[i].kind == machine::AxisKind::kRotary && fraction > 0.0)
      nominal[i] = grain.Held(i, nominal[i]);
  }
  piece->end_fraction = fraction;
  Begin(step, piece);
  return CorrectAt(nominal, senses, grain, piece);
}

int MoveCorrector::ArcSamples(const Step& step, double share) const {
  double samples = kLeastSamples;
  for (int i = 0; i < axis_count_; ++i) {
    // In a turned frame the arc may move each linear axis.
    const bool is_linear = compensator_->machine().axes[i].kind == machine::AxisKind::kLinear;
    const bool is_in_plane = i == step.arc.first || i == step.arc.second || (is_linear && step.placed != nullptr);
    const double travel =
        is_in_plane ? std::abs(step.arc.sweep_rad) * step.arc.radius_mm() * ScaleOf(step.placed.get())
                    : std::abs(static_cast<double>(step.end.ticks[i] - step.start.ticks[i])) * unit_per_tick_[i];
    samples = std::max(samples, std::ceil(kSamplesPerTravel * share * travel / compensator_->smooth_travel(i)));
  }
  return static_cast<int>(std::min<double>(samples, kMostSamples));
}

int MoveCorrector::CentreDecimals(const Arc& arc, const AxisTicks& start, const AxisTicks& end,
                                  const WordGrain& grain) {
  const Eigen::Vector2d start_mm = PlanePoint(start, arc), end_mm = PlanePoint(end, arc);
  const int own = std::min(grain.centre[0].form.decimals, grain.centre[1].form.decimals);
  for (int decimals = own; decimals <= (grain.takes_finer_centres ? kMaxDecimals : own); ++decimals) {
    bool is_circle = true;
    // Along either axis the word may count from the origin or from the start.
    for (const int from : {0, 1, 2, 3}) {
      Eigen::Vector2d centre_mm;
      bool is_written = true;
      for (const int index : {0, 1}) {
        const CentreWord& word = grain.centre[static_cast<size_t>(index)];
        const bool from_origin = from >> index & 1;
        is_written &= from_origin ? word.from_origin : word.from_start;
        const Ticks base = from_origin ? word.origin : start[index == 0 ? arc.first : arc.second];
        const Ticks centre = std::llround(arc.centre_mm[index] * kTicksPerUnit);
        const Ticks says = NearestHeld(centre, base, AtLeast(decimals, word.form, word.ticks_per_unit).grain);
        centre_mm[index] = static_cast<double>(says) / kTicksPerUnit;
      }
      if (!is_written) continue;
      const double first_mm = (start_mm - centre_mm).norm(), last_mm = (end_mm - centre_mm).norm();
      const double least_mm = RadiusToleranceMm(std::min(first_mm, last_mm), grain.radius_tolerance_mm);
      is_circle &= std::abs(first_mm - last_mm) <= kShare * least_mm;
    }
    if (is_circle) return decimals;
  }
  return -1;
}

absl::StatusOr<bool> MoveCorrector::FitArc(const Step& step, const AxisTicks& at_begin, const AxisTicks& start,
                                           double first, double last, const WordGrain& grain, Piece* piece) const {
  const Arc& nominal = step.arc;
  const Senses senses = SensesOfArc(step, 0.5 * (first + last));
  RETURN_IF_ERROR(CorrectOnArc(step, last, senses, grain, piece));
  for (int i = 0; grain.is_flat && i < axis_count_; ++i) {
    const bool is_in_plane = i == nominal.first || i == nominal.second;
    if (!is_in_plane && !IsHeld(piece->targets[i], at_begin[i], grain.of_axis[i])) return false;
  }
  const double grain_mm =
      static_cast<double>(std::max(grain.of_axis[nominal.first], grain.of_axis[nominal.second])) / kTicksPerUnit;
  const bool is_full = IsFull(nominal) && last - first == 1.0;
  const double sweep = nominal.sweep_rad * (last - first);
  const Eigen::Vector2d start_mm = PlanePoint(start, nominal);
  Eigen::Vector2d end_mm = PlanePoint(piece->targets, nominal);
  AxisTicks written = piece->targets;  // as the words will say it
  if (is_full) {
    // Ends that differ by rounding would be a tiny arc instead of a full circle.
    if ((end_mm - start_mm).norm() > 1.5 * grain_mm) return false;
    end_mm = start_mm;
    for (const int axis : {nominal.first, nominal.second}) {
      // So would a start that a word of the block cannot say: it may have more decimals, or be in inch.
      if (step.word_of_axis[axis] >= 0 && grain.Held(axis, start[axis]) != start[axis]) return false;
      written[axis] = piece->targets[axis] = start[axis];
    }
  } else {
    for (const int axis : {nominal.first, nominal.second}) written[axis] = grain.Held(axis, piece->targets[axis]);
    end_mm = PlanePoint(written, nominal);
  }
  if (!is_full && (end_mm - start_mm).norm() < kLeastGrains * grain_mm) {
    return false;
  }
  if (std::abs(sweep) * nominal.radius_mm() < kLeastGrains * grain_mm) return false;

  // Corrected points between the ends.
  const int count = ArcSamples(step, last - first);
  std::vector<AxisTicks> points(static_cast<size_t>(count));
  std::vector<Effect> effects(static_cast<size_t>(orientation_ ? count : 1));
  Eigen::Matrix2Xd in_plane(2, count);
  Piece sample;
  Begin(step, &sample);
  for (int k = 0; k < count; ++k) {
    const double t = (k + 1.0) / (count + 1);
    RETURN_IF_ERROR(CorrectAt(Between(step, first + t * (last - first)), senses, WordGrain(), &sample));
    points[static_cast<size_t>(k)] = sample.targets;
    if (orientation_) effects[static_cast<size_t>(k)] = EffectAt(sample);
    in_plane.col(k) = PlanePoint(sample.targets, nominal);
  }
  // The largest distance of an arc from the corrected points, at equal fractions; infinity where it is another arc.
  const auto departure = [&](const absl::StatusOr<Arc>& arc) {
    if (!arc.ok() || !(std::abs(arc->sweep_rad - sweep) <= 0.1 * std::abs(sweep))) return kInfinity;
    double largest = 0;
    for (int k = 0; k < count; ++k) {
      const double t = (k + 1.0) / (count + 1);
      const Eigen::Vector2d at_mm = arc->At(t);
      AxisTicks reached = Mean(start, piece->targets, t);
      reached[nominal.first] = NearestTick(at_mm.x() * kTicksPerUnit);
      reached[nominal.second] = NearestTick(at_mm.y() * kTicksPerUnit);
      const auto at = static_cast<size_t>(k);
      largest = std::max(largest, Weight(ChangeOf(reached, points[at]), effects[orientation_ ? at : 0]));
    }
    return largest * ScaleOf(step.placed.get());
  };
  const Eigen::Vector2d centre_mm = FitCentre(start_mm, end_mm, is_full, in_plane);
  if (!centre_mm.allFinite()) return false;
  absl::StatusOr<Arc> fitted = ArcAboutCentre(start_mm, end_mm, centre_mm, sweep > 0);
  // The program's own centre, seen from the start, or its radius: words that need no change stay.
  absl::StatusOr<Arc> kept = fitted;
  if (grain.radius > 0) {
    // Near half a turn, and beyond it, the centre depends on the last digit of the radius and of the ends.
    const double height = (centre_mm - 0.5 * (start_mm + end_mm)).norm();
    if (!fitted.ok() || is_full || height < 0.2 * fitted->radius_mm()) return false;
    const double sign = std::abs(sweep) > std::numbers::pi ? -1.0 : 1.0;
    const auto held_mm = [&](double radius_mm) {
      return static_cast<double>(NearestHeld(std::llround(radius_mm * kTicksPerUnit), 0, grain.radius)) / kTicksPerUnit;
    };
    fitted = ArcOfRadius(start_mm, end_mm, sign * held_mm(fitted->radius_mm()), sweep > 0);
    kept = ArcOfRadius(start_mm, end_mm, sign * held_mm(nominal.radius_mm()), sweep > 0);
  } else if (first == 0.0) {
    kept = ArcAboutCentre(start_mm, end_mm, start_mm + nominal.centre_mm - PlanePoint(step.start.ticks, nominal),
                          sweep > 0);
  }
  const double fitted_mm = departure(fitted), kept_mm = departure(kept);
  bool keeps = kept_mm <= fitted_mm + 1.5 * grain_mm && kept_mm <= kShare * tolerance_mm_ &&
               std::abs(kept->start_radius_mm - kept->end_radius_mm) <= 2.0 * grain_mm;
  const auto take = [&](const Arc& arc) {
    piece->arc = arc;
    piece->arc.first = nominal.first;
    piece->arc.second = nominal.second;
    piece->centre_decimals = grain.radius > 0 ? 0 : CentreDecimals(piece->arc, start, written, grain);
  };
  if (keeps) take(*kept);
  // More decimals make no circle of a centre that is nearer to one end.
  const int own = std::min(grain.centre[0].form.decimals, grain.centre[1].form.decimals);
  keeps &= piece->centre_decimals >= 0 && (grain.radius > 0 || piece->centre_decimals == own);
  if (!keeps) {
    if (!(fitted_mm <= kShare * tolerance_mm_)) return false;
    take(*fitted);
  }
  piece->is_arc = piece->centre_decimals >= 0;
  return piece->is_arc;
}

absl::StatusOr<std::vector<Piece>> MoveCorrector::ArcPieces(const Step& step, double first, double last,
                                                            const AxisTicks& commanded, const WordGrain& grain) const {
  AxisTicks at_begin = commanded;  // as words say it
  for (int i = 0; grain.is_flat && i < axis_count_; ++i) at_begin[i] = grain.Held(i, commanded[i]);
  for (const int count : kArcCounts) {
    std::vector<Piece> pieces(static_cast<size_t>(count));
    bool fits = true;
    for (int k = 0; k < count && fits; ++k) {
      AxisTicks start = k == 0 ? commanded : pieces[static_cast<size_t>(k) - 1].targets;
      for (const int axis : {step.arc.first, step.arc.second}) {
        if (k > 0) start[axis] = grain.Held(axis, start[axis]);
      }
      const double from = first + (last - first) * k / count;
      const double to = k + 1 == count ? last : first + (last - first) * (k + 1) / count;
      ASSIGN_OR_RETURN(fits, FitArc(step, at_begin, start, from, to, grain, &pieces[static_cast<size_t>(k)]));
    }
    if (fits) return pieces;
  }
  return std::vector<Piece>();
}

absl::Status MoveCorrector::PiecesBetween(const Step& step, double first, double last, const AxisTicks& commanded,
                                          const WordGrain& grain, std::vector<Piece>* pieces) const {
  const Senses senses = SensesOfArc(step, 0.5 * (first + last));
  Piece start;
  RETURN_IF_ERROR(CorrectOnArc(step, first, senses, grain, &start));
  AxisTicks reached = pieces->empty() ? commanded : pieces->back().targets;
  if (Apart(start, reached) > tolerance_mm_) {
    pieces->push_back(start);  // takes up the lost motion
    reached = start.targets;
  }
  // As the words of the piece in front say it.
  for (const int axis : {step.arc.first, step.arc.second}) {
    if (!pieces->empty()) reached[axis] = grain.Held(axis, reached[axis]);
  }
  ASSIGN_OR_RETURN(const std::vector<Piece> arcs, ArcPieces(step, first, last, reached, grain));
  if (!arcs.empty()) {
    pieces->insert(pieces->end(), arcs.begin(), arcs.end());
    return absl::OkStatus();
  }
  const double reach = std::min(1.0, kShare * tolerance_mm_ / step.arc.radius_mm());
  const double turn = 2.0 * std::acos(1.0 - reach);
  double wanted = std::ceil(std::abs(step.arc.sweep_rad) * (last - first) / turn);
  while (true) {
    if (!(wanted + static_cast<double>(pieces->size()) <= kMaxPieces))
      return absl::FailedPreconditionError(absl::StrCat("the arc needs more than ", kMaxPieces, " pieces"));
    const int count = std::max(1, static_cast<int>(wanted));
    std::vector<Piece> chords(static_cast<size_t>(count));
    bool fits = true;
    Piece sample;
    Begin(step, &sample);
    for (int k = 0; k < count && fits; ++k) {
      const double from = first + (last - first) * k / count;
      const double to = k + 1 == count ? last : first + (last - first) * (k + 1) / count;
      Piece& chord = chords[static_cast<size_t>(k)];
      const AxisTicks& begin = k == 0 ? start.targets : chords[static_cast<size_t>(k) - 1].targets;
      RETURN_IF_ERROR(CorrectOnArc(step, to, senses, grain, &chord));
      for (const double t : {0.25, 0.5, 0.75}) {
        RETURN_IF_ERROR(CorrectAt(Between(step, from + t * (to - from)), senses, WordGrain(), &sample));
        const Change apart = ChangeOf(Mean(begin, chord.targets, t), sample.targets);
        const double off_mm = Weight(apart, orientation_ ? EffectAt(sample) : Effect()) * ScaleOf(sample.placed);
        fits &= off_mm <= tolerance_mm_;
      }
    }
    if (fits) {
      pieces->insert(pieces->end(), chords.begin(), chords.end());
      return absl::OkStatus();
    }
    wanted = std::ceil(1.3 * count) + 1;
  }
}

absl::StatusOr<std::vector<Piece>> MoveCorrector::SplitArc(const Step& step, const AxisTicks& commanded,
                                                           const WordGrain& grain) const {
  const std::vector<double> breaks = Reversals(step);
  Piece start;
  RETURN_IF_ERROR(CorrectStart(step, grain, &start));
  if (breaks.size() == 2 && Apart(start, commanded) <= kShare * tolerance_mm_) {
    ASSIGN_OR_RETURN(std::vector<Piece> pieces, ArcPieces(step, 0.0, 1.0, commanded, grain));
    if (!pieces.empty()) return pieces;
  }
  if (!std::isfinite(tolerance_mm_)) {
    std::vector<Piece> pieces(1);
    RETURN_IF_ERROR(CorrectEnd(step, grain, &pieces[0]));
    return pieces;
  }
  std::vector<Piece> pieces;
  for (size_t i = 0; i + 1 < breaks.size(); ++i)
    RETURN_IF_ERROR(PiecesBetween(step, breaks[i], breaks[i + 1], commanded, grain, &pieces));
  return pieces;
}

}  // namespace axiscal::nc
