// The length characteristic curve: the height Z_t of the tool's origin above the beam when the trigger fires, over the
// spindle angle theta_s0 at which the measurement starts. The tool turns while it sinks, psi_k = theta_s0 + theta_t +
// omega t + angle_k, Z = h - v t; the trigger fires first where Z <= max_k [Zc(psi_k) - W_k]. Tool length:
// L_t = Z'_s - Z_ts - Z_t; a reading that ignores Z_t is L_t + Z_t. Its peaks are the inserts' lengths.
#ifndef AXISCAL_CORE_TOOLSETTER_LENGTH_CURVE_H_
#define AXISCAL_CORE_TOOLSETTER_LENGTH_CURVE_H_

#include <optional>
#include <vector>

#include "core/toolsetter/insert_heights.h"

namespace axiscal::toolsetter {

// One reading of the curve.
struct CurvePoint {
  double start_rad = 0.0;   // theta_s0
  double height_mm = 0.0;   // Z_t
  double turned_rad = 0.0;  // from the start to the trigger
  int insert = 0;           // that fired, from 0
  double by_start = 0.0;    // dZ_t / dtheta_s0, mm per rad, away from the jumps
  double by_wear = 0.0;     // dZ_t / dW of that insert
};

class LengthCurve {
 public:
  // `heights` of the same cutter and run, deep enough (DepthMm), must outlive the curve; `wear_mm` per insert, of which
  // the least counts as 0 only for the depth. The start must stand above the beam (HeightsOf
  // checks it).
  LengthCurve(const InsertHeights& heights, const Cutter& cutter, const CutterRun& run, std::vector<double> wear_mm);

  // In the order of `starts_rad`.
  std::vector<CurvePoint> At(const std::vector<double>& starts_rad) const;

  // How deep below the peak a trigger can happen: what the tool sinks in a turn, and some more.
  static double DepthMm(const CutterRun& run);

 private:
  const InsertHeights& heights_;
  const Cutter& cutter_;
  const std::vector<double> wear_mm_;
  const double start_mm_, per_rad_mm_;  // h, p / 2 pi
};

// The curve of a cutter at `starts_rad`. INVALID_ARGUMENT as Validate, or when the tool already shades the beam where
// it starts.
absl::StatusOr<std::vector<CurvePoint>> ComputeCurve(const Cutter& cutter, const CutterRun& run,
                                                     const std::vector<double>& wear_mm,
                                                     const std::vector<double>& starts_rad);

// The heights that a run needs, checked.
absl::StatusOr<InsertHeights> HeightsOf(const Cutter& cutter, const CutterRun& run);

// Per insert, mm: worn by this much more than all others it never fires first, at no start angle. Far out in the beam
// that is f times the gap to the insert before it; where the offset is well below the inserts' reach it is less, for
// another insert's second crossing comes before it. 0: its wear does not show at all, as at offset 0 with an insert
// right opposite. A single insert has what the tool sinks in a turn.
std::vector<double> UnseenFromMm(const InsertHeights& heights, const Cutter& cutter, const CutterRun& run);

// A feed per minute for another measurement of the same cutter at the run's speed.
struct FeedProposal {
  double feed_mm_min = 0.0;
  double sees_mm = 0.0;  // wear from which an insert that was not seen would still not fire, by the model at this feed
};
// The least feed above the run's at which each insert fires until it is worn by twice its entry of `wear_mm` more than
// the others (0: not asked for, and no cutter has more wear than its insert's radius), rounded up to three digits. By
// UnseenFromMm at that feed, the others unworn, which hides most. Nothing where no feed up to kMaxFeedMmMin does. What
// the machine can run is not known here.
std::optional<FeedProposal> FeedThatSees(const Cutter& cutter, const CutterRun& run,
                                         const std::vector<double>& wear_mm);

// INVALID_ARGUMENT naming offset, insert and rule where the readings of a run cannot tell which insert is worn: an
// insert never fires once it is worn by a tenth of `sigma_mm` (of one reading) more than the others, which no number of
// readings shows.
absl::Status CheckInsertsApart(const InsertHeights& heights, const Cutter& cutter, const CutterRun& run,
                               double sigma_mm);

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_LENGTH_CURVE_H_
