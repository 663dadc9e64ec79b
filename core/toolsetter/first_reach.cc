#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/units.h"
#include "core/toolsetter/insert_heights.h"

namespace axiscal::toolsetter {
double InsertHeights::Rise(double chi_rad, double* slope) const {
  const double height_mm = At(chi_rad, slope);
  if (slope != nullptr) *slope += per_rad_mm_;
  return height_mm + per_rad_mm_ * chi_rad;
}

absl::Status InsertHeights::FindStops(const CutterRun& run, const std::vector<Doubt>& doubts) {
  // Every cell of the ranges from the peak round to it, ascending.
  const double end_rad = peak_rad_ + kTurn;
  struct Cell {
    double low_rad, high_rad;
  };
  std::vector<Cell> cells;
  for (const Range& range : ranges_) {
    const size_t last = range.heights_mm.size() - (is_whole_turn_ ? 1 : 2);
    for (size_t i = is_whole_turn_ ? 0 : 1; i < last; ++i) {
      const double low = range.first_rad + static_cast<double>(i) * step_rad_;
      for (int lap = -1; lap <= 1; ++lap) {
        const Cell cell{std::max(low + lap * kTurn, peak_rad_), std::min(low + step_rad_ + lap * kTurn, end_rad)};
        if (cell.low_rad < cell.high_rad) cells.push_back(cell);
      }
    }
  }
  std::sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) { return a.low_rad < b.low_rad; });
  std::vector<Doubt> ahead = doubts;
  for (Doubt& doubt : ahead) doubt.psi_rad += doubt.psi_rad < peak_rad_ ? kTurn : 0.0;
  std::sort(ahead.begin(), ahead.end(), [](const Doubt& a, const Doubt& b) { return a.psi_rad < b.psi_rad; });

  stops_.clear();
  double highest_mm = peak_mm_ + per_rad_mm_ * peak_rad_;
  stops_.push_back({peak_rad_, peak_rad_, highest_mm});
  const auto take = [&](double low_rad, double high_rad, double rise_mm) {
    if (!(rise_mm > highest_mm)) return;
    highest_mm = rise_mm;
    stops_.push_back({low_rad, high_rad, rise_mm});
  };
  size_t doubt = 0;
  const auto check_until = [&](double chi_rad) -> absl::Status {
    constexpr double kNoticedMm = 1e-6;
    for (; doubt < ahead.size() && ahead[doubt].psi_rad < chi_rad; ++doubt) {
      const Doubt& d = ahead[doubt];
      const double over_mm = d.most_mm + per_rad_mm_ * d.psi_rad - highest_mm;
      if (!(over_mm > kNoticedMm)) continue;
      const double psi_deg = std::fmod(d.psi_rad, kTurn) * base::kDegPerRad;
      if (d.why == nullptr) {
        return absl::InvalidArgumentError(absl::StrFormat(
            "clearance_deg, offset_d_mm = %g: at a spindle angle of %.1f deg the flank stands %.4f mm below the "
            "cutting edge in the beam, expected a larger clearance (it would rub), a smaller feed per turn or another "
            "offset",
            run.offset_mm, psi_deg, d.most_mm - At(d.psi_rad)));
      }
      return absl::InvalidArgumentError(absl::StrFormat(
          "offset_d_mm = %g, feed_mm_min / spindle_rpm = %g mm: at a spindle angle of %.1f deg %s, and it would fire "
          "at a height that its cutting edge does not tell: expected a smaller feed, a higher speed or another offset",
          run.offset_mm, run.feed_per_turn_mm(), psi_deg, d.why));
    }
    return absl::OkStatus();
  };
  for (const Cell& cell : cells) {
    RETURN_IF_ERROR(check_until(cell.low_rad));
    // Within the cell: its slopes are those of its own cubic.
    const double inside = 1e-9 * (cell.high_rad - cell.low_rad);
    double low_slope = 0.0, high_slope = 0.0;
    Rise(cell.low_rad + inside, &low_slope);
    const double high_rise_mm = Rise(cell.high_rad - inside, &high_slope);
    if (low_slope > 0.0 && high_slope < 0.0) {  // a top that a beam may just touch
      double low = cell.low_rad, high = cell.high_rad, slope = 0.0;
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        Rise(middle, &slope);
        (slope > 0.0 ? low : high) = middle;
      }
      take(cell.low_rad, 0.5 * (low + high), Rise(0.5 * (low + high)));
    }
    take(cell.low_rad, cell.high_rad, high_rise_mm);
  }
  RETURN_IF_ERROR(check_until(end_rad));
  const double last_mm = stops_.front().rise_mm + per_rad_mm_ * kTurn;
  while (stops_.size() > 1 && stops_.back().rise_mm >= last_mm) stops_.pop_back();
  stops_.push_back({std::max(stops_.back().high_rad, end_rad - step_rad_), end_rad, last_mm});
  return absl::OkStatus();
}

double InsertHeights::FirstAngle(double rise_mm, double* slope) const {
  const double per_turn_mm = per_rad_mm_ * kTurn;
  const double turns = std::floor((rise_mm - stops_.front().rise_mm) / per_turn_mm);
  const double wanted_mm = rise_mm - turns * per_turn_mm;
  const auto below = [](const Stop& stop, double rise) { return stop.rise_mm < rise; };
  auto stop = std::lower_bound(stops_.begin(), stops_.end(), wanted_mm, below);
  if (stop == stops_.end()) --stop;
  // Newton, kept in the bracket.
  double low = stop->low_rad, high = stop->high_rad;
  double at = 0.5 * (low + high);
  for (int i = 0; i < 60 && high > low; ++i) {
    const double miss_mm = Rise(at, slope) - wanted_mm;
    (miss_mm < 0.0 ? low : high) = at;
    double next = at - miss_mm / *slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const double step = std::abs(next - at);
    at = next;
    if (step < 1e-12 || high - low < 1e-13) break;
  }
  At(at, slope);
  return at + turns * kTurn;
}

double InsertHeights::HighestRise(double chi_rad) const {
  const double turns = std::floor((chi_rad - peak_rad_) / kTurn), within = chi_rad - turns * kTurn;
  const auto ends_before = [](const Stop& stop, double chi) { return stop.high_rad < chi; };
  const auto stop = std::lower_bound(stops_.begin(), stops_.end(), within, ends_before);
  double rise_mm = stop == stops_.begin() ? stops_.front().rise_mm : (stop - 1)->rise_mm;
  if (stop != stops_.end() && within > stop->low_rad)
    rise_mm = std::max(rise_mm, std::min(Rise(within), stop->rise_mm));
  return rise_mm + turns * per_rad_mm_ * kTurn;
}

std::vector<double> InsertHeights::FiringAngles() const {
  std::vector<double> angles;
  constexpr int kWithin = 8;
  for (const Stop& stop : stops_) {
    const double step = (stop.high_rad - stop.low_rad) / kWithin;
    for (int i = 1; i <= kWithin; ++i) angles.push_back(stop.high_rad - (kWithin - i) * step);
  }
  return angles;
}

}  // namespace axiscal::toolsetter
