#include "core/toolsetter/insert_heights.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/units.h"
#include "core/toolsetter/insert_edge.h"

namespace axiscal::toolsetter {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kStep = 0.125 * base::kRadPerDeg;

}  // namespace

absl::StatusOr<InsertHeights> InsertHeights::Create(const Cutter& cutter, const CutterRun& run, double depth_mm) {
  // The highest Zc to a degree.
  double best_mm = -std::numeric_limits<double>::infinity(), best_rad = 0.0;
  for (int degree = 0; degree < 360; ++degree) {
    const double psi = degree * base::kRadPerDeg;
    if (!InsertEdge(cutter, run.offset_mm, psi).Spans(run.beam_radius_mm)) continue;
    const double height_mm = ClosedFormTriggerMm(cutter, run, psi).value_or(best_mm);
    if (height_mm > best_mm) best_mm = height_mm, best_rad = psi;
  }
  const double reach_mm = std::hypot(cutter.tool_radius_mm, cutter.insert_radius_mm);
  if (!std::isfinite(best_mm)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "offset_d_mm = %g: no insert reaches across the beam at any angle, the inserts stand %g mm from the axis with "
        "a "
        "radius of %g mm (at most %.3g mm away): expected a smaller offset",
        run.offset_mm, cutter.tool_radius_mm - cutter.insert_radius_mm, cutter.insert_radius_mm, reach_mm));
  }
  InsertHeights out;
  std::vector<double> down, up;
  for (const int side : {-1, 1}) {
    std::vector<double>& heights_mm = side < 0 ? down : up;
    int beyond = 0;
    for (int i = side < 0 ? 1 : 0; beyond < 3; ++i) {
      const std::optional<double> height_mm = TriggerHeightMm(cutter, run, best_rad + side * i * kStep);
      if (!height_mm || i * kStep > 0.5 * kTurn) {
        return absl::InvalidArgumentError(
            absl::StrFormat("feed_mm_min / spindle_rpm: within a turn the tool sinks so far (%g mm below its peak) "
                            "that an insert no longer "
                            "reaches across the beam: expected a smaller feed or a higher speed",
                            depth_mm));
      }
      heights_mm.push_back(*height_mm);
      if (*height_mm < best_mm - depth_mm) ++beyond;
    }
  }
  out.heights_mm_.assign(down.rbegin(), down.rend());
  out.first_rad_ = best_rad - static_cast<double>(down.size()) * kStep;
  out.heights_mm_.insert(out.heights_mm_.end(), up.begin(), up.end());
  const auto highest = std::max_element(out.heights_mm_.begin(), out.heights_mm_.end());
  out.peak_rad_ = out.first_rad_ + static_cast<double>(highest - out.heights_mm_.begin()) * kStep;
  double low = out.peak_rad_ - kStep, high = out.peak_rad_ + kStep, slope = 0.0;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    out.At(middle, &slope);
    (slope > 0.0 ? low : high) = middle;
  }
  out.peak_rad_ = 0.5 * (low + high);
  out.peak_mm_ = out.At(out.peak_rad_);
  return out;
}

double InsertHeights::At(double psi_rad, double* slope) const {
  double from = psi_rad - first_rad_;
  if (!(std::abs(from) < 4.0 * kTurn)) from -= kTurn * std::floor(from / kTurn);
  while (from < 0.0) from += kTurn;  // the usual case by far: once or not at all
  while (from >= kTurn) from -= kTurn;
  constexpr double kPerStep = 1.0 / kStep;
  const double place = from * kPerStep;
  const auto i = static_cast<size_t>(place);
  if (i < 1 || i + 2 >= heights_mm_.size()) {
    if (slope != nullptr) *slope = 0.0;
    return -std::numeric_limits<double>::infinity();
  }
  // Four-point Lagrange.
  const double s = place - static_cast<double>(i);
  const double a = heights_mm_[i - 1], b = heights_mm_[i], c = heights_mm_[i + 1], d = heights_mm_[i + 2];
  const double k3 = (d - 3.0 * c + 3.0 * b - a) / 6.0, k2 = 0.5 * (a - 2.0 * b + c);
  const double k1 = c - b - k2 - k3;
  if (slope != nullptr) *slope = (k1 + s * (2.0 * k2 + 3.0 * k3 * s)) / kStep;
  return b + s * (k1 + s * (k2 + s * k3));
}

}  // namespace axiscal::toolsetter
