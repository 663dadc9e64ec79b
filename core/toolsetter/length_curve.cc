#include "core/toolsetter/length_curve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/units.h"
#include "core/toolsetter/insert_edge.h"

namespace axiscal::toolsetter {
double LengthCurve::DepthMm(const CutterRun& run) {
  // However little a tool sinks in a turn, a range is wide enough to be seen from one angle of the table to the next.
  constexpr double kBeyondMm = 0.02;
  return 1.05 * run.feed_per_turn_mm() + kBeyondMm;
}

LengthCurve::LengthCurve(const InsertHeights& heights, const Cutter& cutter, const CutterRun& run,
                         std::vector<double> wear_mm)
    : heights_(heights),
      cutter_(cutter),
      wear_mm_(std::move(wear_mm)),
      start_mm_(run.start_height_mm),
      per_rad_mm_(run.feed_per_turn_mm() / kTurn) {}

std::vector<CurvePoint> LengthCurve::At(const std::vector<double>& starts_rad) const {
  std::vector<CurvePoint> points;
  points.reserve(starts_rad.size());
  // Nothing fires while the beam stands above the highest peak; from there on it does within a turn.
  const double peak_mm = heights_.peak_mm() - *std::min_element(wear_mm_.begin(), wear_mm_.end());
  const double idle_rad = (start_mm_ - peak_mm) / per_rad_mm_;
  for (const double start_rad : starts_rad) {
    double first = start_rad + cutter_.theta_t_rad + idle_rad;
    first -= kTurn * std::floor(first / kTurn);
    CurvePoint point{.start_rad = start_rad};
    double fired = std::numeric_limits<double>::infinity(), slope = 0.0;
    for (int k = 0; k < cutter_.inserts; ++k) {
      // The rise at which the beam stands to insert k, over its own angle.
      const double angle = cutter_.InsertAngle(k);
      const double rise_mm = peak_mm + wear_mm_[k] + per_rad_mm_ * (first + angle);
      double slope_of = 0.0;
      const double psi = heights_.FirstAngle(rise_mm, &slope_of) - angle;
      if (!(psi < fired)) continue;
      fired = psi;
      slope = slope_of;
      point.insert = k;
    }
    point.turned_rad = fired - first + idle_rad;
    point.height_mm = start_mm_ - per_rad_mm_ * point.turned_rad;
    // The insert's height and the sinking line meet: dpsi (Zc' + p) = p dstart + dW.
    point.by_start = slope * per_rad_mm_ / (slope + per_rad_mm_);
    point.by_wear = -per_rad_mm_ / (slope + per_rad_mm_);
    points.push_back(point);
  }
  return points;
}

std::vector<double> UnseenFromMm(const InsertHeights& heights, const Cutter& cutter, const CutterRun& run) {
  if (cutter.inserts == 1) return {run.feed_per_turn_mm()};
  const double per_rad_mm = run.feed_per_turn_mm() / kTurn;
  const std::vector<double> firing = heights.FiringAngles();
  std::vector<double> unseen_mm;
  for (int k = 0; k < cutter.inserts; ++k) {
    double most_mm = 0.0;
    for (const double chi : firing) {
      const double psi = chi - cutter.InsertAngle(k);
      double others_mm = -std::numeric_limits<double>::infinity();
      for (int j = 0; j < cutter.inserts; ++j) {
        const double angle = cutter.InsertAngle(j);
        if (j != k) others_mm = std::max(others_mm, heights.HighestRise(psi + angle) - per_rad_mm * angle);
      }
      most_mm = std::max(most_mm, heights.HighestRise(chi) - per_rad_mm * cutter.InsertAngle(k) - others_mm);
    }
    unseen_mm.push_back(most_mm);
  }
  return unseen_mm;
}

std::optional<FeedProposal> FeedThatSees(const Cutter& cutter, const CutterRun& run,
                                         const std::vector<double>& wear_mm) {
  // The least wear that stays unseen, of the inserts asked for; nothing where one would not be seen as asked.
  const auto sees = [&](double feed_mm_min) -> std::optional<double> {
    CutterRun faster = run;
    faster.feed_mm_min = feed_mm_min;
    const auto heights = HeightsOf(cutter, faster);
    if (!heights.ok()) return std::nullopt;
    const std::vector<double> unseen_mm = UnseenFromMm(*heights, cutter, faster);
    double least_mm = std::numeric_limits<double>::infinity();
    for (size_t k = 0; k < wear_mm.size(); ++k) {
      constexpr double kRounding = 1e-9;
      if (wear_mm[k] == 0.0) continue;
      const double asked_mm = std::min(2.0 * wear_mm[k], cutter.insert_radius_mm);
      if (!(unseen_mm[k] >= asked_mm * (1.0 - kRounding))) return std::nullopt;
      least_mm = std::min(least_mm, unseen_mm[k]);
    }
    return least_mm;
  };
  const auto rounded_up = [](double feed_mm_min) {
    const double digit = std::pow(10.0, std::floor(std::log10(feed_mm_min)) - 2.0);
    return digit * std::ceil(feed_mm_min / digit * (1.0 - 1e-5));
  };
  const auto is_possible = [&](double feed_mm_min) {
    CutterRun faster = run;
    faster.feed_mm_min = feed_mm_min;
    return HeightsOf(cutter, faster).ok();
  };
  // Upwards to the first feed that shows it; the last one tried is the largest at which the cutter still reaches the
  // beam with its edges first.
  constexpr double kStep = 1.25, kNearLimit = 1e-3;
  double below = run.feed_mm_min, feed = below;
  for (bool is_last = false; !sees(feed);) {
    if (is_last) return std::nullopt;
    below = feed;
    feed = std::min(kStep * below, kMaxFeedMmMin);
    is_last = feed == kMaxFeedMmMin;
    if (is_possible(feed)) continue;
    is_last = true;
    double possible = below;
    while (feed - possible > kNearLimit * feed) {
      const double middle = 0.5 * (possible + feed);
      (is_possible(middle) ? possible : feed) = middle;
    }
    feed = possible;
  }
  constexpr double kNear = 1e-6;
  while (feed - below > kNear * feed) {
    const double middle = 0.5 * (below + feed);
    (sees(middle) ? feed : below) = middle;
  }
  // What is asked for may be seen at a feed and, by a second crossing of the beam, no longer a little above.
  for (const double proposed : {std::min(rounded_up(feed), kMaxFeedMmMin), feed}) {
    if (const auto sees_mm = sees(proposed)) return FeedProposal{proposed, *sees_mm};
  }
  return std::nullopt;
}

absl::Status CheckInsertsApart(const InsertHeights& heights, const Cutter& cutter, const CutterRun& run,
                               double sigma_mm) {
  constexpr double kShare = 0.1;
  const std::vector<double> unseen_mm = UnseenFromMm(heights, cutter, run);
  const auto least = std::min_element(unseen_mm.begin(), unseen_mm.end());
  if (*least > kShare * sigma_mm) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "offset_d_mm = %g: inserts cannot be told apart: insert %d never fires first once it is worn by %.3f um more "
      "than "
      "the others, because another insert crosses the beam a second time just before it, expected more than a tenth of "
      "a reading's sigma of %g um: take an offset nearer to the %.3g mm at which the inserts' lowest points pass the "
      "axis, or a larger feed per turn",
      run.offset_mm, static_cast<int>(least - unseen_mm.begin()) + 1, *least * base::kUmPerMm,
      sigma_mm * base::kUmPerMm, BottomRadiusMm(cutter)));
}

absl::StatusOr<InsertHeights> HeightsOf(const Cutter& cutter, const CutterRun& run) {
  RETURN_IF_ERROR(Validate(cutter, run));
  ASSIGN_OR_RETURN(InsertHeights heights, InsertHeights::Create(cutter, run, LengthCurve::DepthMm(run)));
  if (!(run.start_height_mm > heights.peak_mm())) {
    return absl::InvalidArgumentError(
        absl::StrFormat("start_height_mm = %g: an insert shades the beam there already, expected more than %.6f",
                        run.start_height_mm, heights.peak_mm()));
  }
  return heights;
}

absl::StatusOr<std::vector<CurvePoint>> ComputeCurve(const Cutter& cutter, const CutterRun& run,
                                                     const std::vector<double>& wear_mm,
                                                     const std::vector<double>& starts_rad) {
  ASSIGN_OR_RETURN(const InsertHeights heights, HeightsOf(cutter, run));
  RETURN_IF_ERROR(ValidateWear(cutter, wear_mm));
  for (const double start_rad : starts_rad) {
    if (!(std::abs(start_rad) < 1e4)) return absl::InvalidArgumentError("a start angle is no number");
  }
  return LengthCurve(heights, cutter, run, wear_mm).At(starts_rad);
}

}  // namespace axiscal::toolsetter
