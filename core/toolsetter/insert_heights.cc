#include "core/toolsetter/insert_heights.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/toolsetter/insert_edge.h"

namespace axiscal::toolsetter {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Angles of the first look over the turn: 0.125 deg, and finer for large tools, so that between two of them an insert
// moves by less than a 200th of its radius.
constexpr int kLeastAngles = 2880, kMostAngles = 1 << 19;
constexpr double kMovedRadii = 0.005;

double Wrapped(double psi_rad) {
  const double turned = psi_rad - kTurn * std::floor(psi_rad / kTurn);
  return turned < kTurn ? turned : 0.0;
}

// What the first look says of an angle.
struct Look {
  bool spans = false;
  double most_mm = -kInfinity;  // no trigger stands higher
};

std::vector<Look> LookAround(const Cutter& cutter, const CutterRun& run) {
  const double wanted = kTurn * cutter.tool_radius_mm / (kMovedRadii * cutter.insert_radius_mm);
  const int count = static_cast<int>(std::clamp<double>(std::ceil(wanted), kLeastAngles, kMostAngles));
  std::vector<Look> looks(count);
  for (int i = 0; i < count; ++i) {
    const InsertEdge edge(cutter, run.offset_mm, kTurn * i / count);
    looks[i] = {edge.Spans(run.beam_radius_mm), -edge.LowestMm(run.beam_radius_mm)};
  }
  return looks;
}

// The highest Zc at the angles of the look; nothing where there is none.
std::optional<double> HighestMm(const Cutter& cutter, const CutterRun& run, const std::vector<Look>& looks) {
  const double step = kTurn / static_cast<double>(looks.size());
  double likely_mm = -kInfinity, likely_rad = 0.0;
  for (size_t i = 0; i < looks.size(); ++i) {
    if (!looks[i].spans || looks[i].most_mm <= likely_mm) continue;
    const double height_mm = ClosedFormTriggerMm(cutter, run, i * step).value_or(-kInfinity);
    if (height_mm > likely_mm) likely_mm = height_mm, likely_rad = i * step;
  }
  std::optional<double> best_mm = TriggerHeightMm(cutter, run, likely_rad);
  for (size_t i = 0; i < looks.size(); ++i) {
    if (!looks[i].spans || (best_mm && looks[i].most_mm <= *best_mm)) continue;
    const std::optional<double> height_mm = TriggerHeightMm(cutter, run, i * step);
    if (height_mm && (!best_mm || *height_mm > *best_mm)) best_mm = height_mm;
  }
  return best_mm;
}

}  // namespace

absl::StatusOr<InsertHeights> InsertHeights::Create(const Cutter& cutter, const CutterRun& run, double depth_mm) {
  const std::vector<Look> looks = LookAround(cutter, run);
  const std::optional<double> best_mm = HighestMm(cutter, run, looks);
  if (!best_mm) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "offset_d_mm = %g: no insert reaches across the beam at any angle, the inserts stand %g mm from the axis with "
        "a radius of %g mm (at most %.3g mm away): expected a smaller offset",
        run.offset_mm, cutter.tool_radius_mm - cutter.insert_radius_mm, cutter.insert_radius_mm,
        std::hypot(cutter.tool_radius_mm, cutter.insert_radius_mm)));
  }
  const int count = static_cast<int>(looks.size());
  const double step = kTurn / count, lowest_mm = *best_mm - depth_mm;
  const auto is_wanted = [&](int i) {
    const Look& look = looks[((i % count) + count) % count];
    return look.spans && look.most_mm >= lowest_mm;
  };
  InsertHeights out;
  out.per_rad_mm_ = run.feed_per_turn_mm() / kTurn;
  // Ranges of wanted angles, with some beyond for the cubic.
  constexpr int kBeyond = 3;
  std::vector<std::pair<double, double>> spans;
  int begin = 0;
  while (begin < count && is_wanted(begin)) ++begin;
  out.is_whole_turn_ = begin == count;
  if (out.is_whole_turn_) spans.emplace_back(0.0, kTurn);
  for (int i = begin; i < begin + count && !out.is_whole_turn_; ++i) {
    if (!is_wanted(i) || is_wanted(i - 1)) continue;
    int from = i, to = i;
    while (is_wanted(to + 1)) ++to;
    const auto spans_at = [&](int k) { return looks[((k % count) + count) % count].spans; };
    for (int k = 0; k < kBeyond && spans_at(from - 1); ++k) --from;
    i = to;
    for (int k = 0; k < kBeyond && spans_at(to + 1); ++k) ++to;
    if (!spans.empty() && from * step <= spans.back().second) {
      spans.back().second = to * step;
      continue;
    }
    spans.emplace_back(from * step, to * step);
  }
  // Finer until the cubic is exact.
  constexpr int kMostHalvings = 7;
  out.step_rad_ = step;
  for (int halving = 0; !out.Tabulate(cutter, run, spans, depth_mm) && halving < kMostHalvings; ++halving)
    out.step_rad_ *= 0.5;

  std::vector<Doubt> doubts;
  for (int i = 0; i < count; ++i) {
    const double psi = step * i;
    if (!(looks[i].most_mm >= *best_mm - run.feed_per_turn_mm())) continue;
    const double height_mm = out.At(psi);
    const bool is_known = std::isfinite(height_mm);
    if (!is_known || !InsertEdge(cutter, run.offset_mm, psi).IsBeamBelowTop(run.beam_radius_mm, height_mm)) {
      const std::optional<double> whole_mm = WholeInsertTriggerMm(cutter, run, psi);
      if (!whole_mm) continue;
      doubts.push_back(
          {psi, *whole_mm,
           is_known ? "an insert stands edge-on in the beam" : "an insert reaches across a part of the beam only"});
    } else if (const double below_mm = FlankBelowEdgeMm(cutter, run, psi); below_mm > 0.0) {
      doubts.push_back({psi, height_mm + below_mm, nullptr});
    }
  }
  RETURN_IF_ERROR(out.FindStops(run, doubts));
  return out;
}

// Fills the ranges with the step that is set. False where the cubic is not exact between them.
bool InsertHeights::Tabulate(const Cutter& cutter, const CutterRun& run,
                             const std::vector<std::pair<double, double>>& spans, double depth_mm) {
  ranges_.clear();
  peak_mm_ = -kInfinity;
  for (const auto& [from_rad, to_rad] : spans) {
    const int cells = static_cast<int>(std::lround((to_rad - from_rad) / step_rad_));
    Range range{from_rad, {}};
    for (int i = 0; i <= cells; ++i) {
      const double psi = from_rad + i * step_rad_;
      // A break in the middle makes two ranges; what lies between is a doubt.
      const std::optional<double> height_mm = TriggerHeightMm(cutter, run, psi);
      if (height_mm) {
        if (range.heights_mm.empty()) range.first_rad = psi;
        range.heights_mm.push_back(*height_mm);
        if (*height_mm > peak_mm_) peak_mm_ = *height_mm, peak_rad_ = Wrapped(psi);
      }
      if (height_mm && i < cells) continue;
      is_whole_turn_ = is_whole_turn_ && height_mm.has_value();
      range.first_rad = Wrapped(range.first_rad);
      if (range.heights_mm.size() > 3) ranges_.push_back(range);
      range.heights_mm.clear();
    }
  }
  std::sort(ranges_.begin(), ranges_.end(), [](const Range& a, const Range& b) { return a.first_rad < b.first_rad; });
  double low = peak_rad_ - step_rad_, high = peak_rad_ + step_rad_, slope = 0.0;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    At(middle, &slope);
    (slope > 0.0 ? low : high) = middle;
  }
  const double peak_rad = 0.5 * (low + high), peak_mm = At(peak_rad);
  if (std::isfinite(peak_mm)) peak_rad_ = Wrapped(peak_rad), peak_mm_ = peak_mm;

  constexpr double kOffMm = 1e-9;
  constexpr size_t kEvery = 8;
  for (const Range& range : ranges_) {
    for (size_t i = 1; i + 2 < range.heights_mm.size(); i += kEvery) {
      if (range.heights_mm[i] < peak_mm_ - depth_mm) continue;
      const double middle = range.first_rad + (static_cast<double>(i) + 0.5) * step_rad_;
      const std::optional<double> exact_mm = TriggerHeightMm(cutter, run, middle);
      if (!exact_mm || std::abs(At(middle) - *exact_mm) > kOffMm) return false;
    }
  }
  return true;
}

double InsertHeights::At(double psi_rad, double* slope) const {
  double turned = psi_rad;
  if (!(std::abs(turned) < 4.0 * kTurn)) turned -= kTurn * std::floor(turned / kTurn);
  while (turned < 0.0) turned += kTurn;  // the usual case by far: once or not at all
  while (turned >= kTurn) turned -= kTurn;
  for (const Range& range : ranges_) {
    const double from = turned < range.first_rad ? turned - range.first_rad + kTurn : turned - range.first_rad;
    const double place = from / step_rad_;
    const auto i = static_cast<size_t>(place);
    const std::vector<double>& heights_mm = range.heights_mm;
    if (!is_whole_turn_ && (i < 1 || i + 2 >= heights_mm.size())) continue;
    // Four-point Lagrange. Round a whole turn the last height is the first one again.
    const double s = place - static_cast<double>(i);
    const size_t cells = heights_mm.size() - 1;
    const auto at = [&](size_t k) { return is_whole_turn_ ? heights_mm[k % cells] : heights_mm[k]; };
    const double a = at(i + (i == 0 ? cells : 0) - 1), b = at(i), c = at(i + 1), d = at(i + 2);
    const double k3 = (d - 3.0 * c + 3.0 * b - a) / 6.0, k2 = 0.5 * (a - 2.0 * b + c);
    const double k1 = c - b - k2 - k3;
    if (slope != nullptr) *slope = (k1 + s * (2.0 * k2 + 3.0 * k3 * s)) / step_rad_;
    return b + s * (k1 + s * (k2 + s * k3));
  }
  if (slope != nullptr) *slope = 0.0;
  return -kInfinity;
}

}  // namespace axiscal::toolsetter
