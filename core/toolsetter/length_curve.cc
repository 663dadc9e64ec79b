#include "core/toolsetter/length_curve.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/units.h"
#include "core/toolsetter/insert_edge.h"

namespace axiscal::toolsetter {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr int kNodesPerTurn = 1440;

}  // namespace

double LengthCurve::DepthMm(const CutterRun& run) {
  // Deeper than the dip between an insert's two crossings of the beam, so that its heights are of one piece.
  constexpr double kDipMm = 0.02;
  return 1.05 * run.feed_per_turn_mm() + kDipMm;
}

LengthCurve::LengthCurve(const InsertHeights& heights, const Cutter& cutter, const CutterRun& run,
                         std::vector<double> wear_mm)
    : heights_(heights),
      cutter_(cutter),
      wear_mm_(std::move(wear_mm)),
      start_mm_(run.start_height_mm),
      per_rad_mm_(run.feed_per_turn_mm() / kTurn) {
  nodes_.reserve(2 * kNodesPerTurn + 32);
  int insert = 0;
  std::vector<Node> turn;
  turn.reserve(kNodesPerTurn + 16);
  const auto rise = [&](double psi) { return Envelope(psi, &insert) + per_rad_mm_ * psi; };
  const double step = kTurn / kNodesPerTurn;
  double before = rise(-step), now = rise(0.0);
  for (int i = 0; i < kNodesPerTurn; ++i) {
    const double psi = step * i, next = rise(psi + step);
    turn.push_back({psi, now});
    // A top between two nodes would be passed over by a line that just touches it.
    const double bend = before - 2.0 * now + next;
    if (now >= before && now >= next && bend < 0.0 && std::isfinite(bend)) {
      const double top = psi + 0.5 * step * (before - next) / bend;
      if (top > psi) turn.push_back({top, rise(top)});
      if (top < psi && top > 0.0) turn.insert(turn.end() - 1, {top, rise(top)});
    }
    before = now;
    now = next;
  }
  for (const int lap : {0, 1}) {
    for (const Node& node : turn)
      nodes_.push_back({node.psi_rad + lap * kTurn, node.rise_mm + lap * kTurn * per_rad_mm_});
  }
}

double LengthCurve::Envelope(double psi_rad, int* insert) const {
  double highest_mm = -std::numeric_limits<double>::infinity();
  for (int k = 0; k < cutter_.inserts; ++k) {
    const double height_mm = heights_.At(psi_rad + cutter_.InsertAngle(k)) - wear_mm_[k];
    if (!(height_mm > highest_mm)) continue;
    highest_mm = height_mm;
    *insert = k;
  }
  return highest_mm;
}

CurvePoint LengthCurve::Hit(double first_rad, double level_mm, size_t node) const {
  CurvePoint point;
  double high = nodes_[node].psi_rad;
  double low = node == 0 ? first_rad : std::max(first_rad, nodes_[node - 1].psi_rad);
  // Newton on the insert that stands lowest, kept in the bracket: the envelope has kinks.
  double at = 0.5 * (low + high);
  for (int i = 0; i < 60; ++i) {
    double slope = 0.0;
    const double miss_mm = Envelope(at, &point.insert) + per_rad_mm_ * at - level_mm;
    heights_.At(at + cutter_.InsertAngle(point.insert), &slope);
    (miss_mm < 0.0 ? low : high) = at;
    double next = at - miss_mm / (slope + per_rad_mm_);
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const double step = std::abs(next - at);
    at = next;
    if (step < 1e-12 || high - low < 1e-13) break;
  }
  const double psi = at;
  Envelope(psi, &point.insert);
  point.turned_rad = psi - first_rad;
  // The insert's height and the sinking line meet: dpsi (Zc' + p) = p dstart + dW.
  double slope = 0.0;
  heights_.At(psi + cutter_.InsertAngle(point.insert), &slope);
  point.by_start = slope * per_rad_mm_ / (slope + per_rad_mm_);
  point.by_wear = -per_rad_mm_ / (slope + per_rad_mm_);
  return point;
}

std::vector<CurvePoint> LengthCurve::At(const std::vector<double>& starts_rad) const {
  std::vector<CurvePoint> points;
  points.reserve(starts_rad.size());
  // Nothing fires while the line stands above the envelope's peak; from there on it does within a turn.
  const double peak_mm = heights_.peak_mm() - *std::min_element(wear_mm_.begin(), wear_mm_.end());
  const double idle_rad = (start_mm_ - peak_mm) / per_rad_mm_;
  size_t node = 0;
  double before_rad = std::numeric_limits<double>::infinity();
  for (const double start_rad : starts_rad) {
    double first = start_rad + cutter_.theta_t_rad + idle_rad;
    first -= kTurn * std::floor(first / kTurn);
    const double level_mm = peak_mm + per_rad_mm_ * first;
    if (first < before_rad) node = 0;  // else: later starts meet later nodes
    before_rad = first;
    if (nodes_[node].psi_rad < first) {
      const auto earlier = [](const Node& n, double psi) { return n.psi_rad < psi; };
      node = std::lower_bound(nodes_.begin() + node, nodes_.end(), first, earlier) - nodes_.begin();
    }
    while (node + 1 < nodes_.size() && nodes_[node].rise_mm < level_mm) ++node;
    CurvePoint point = Hit(first, level_mm, node);
    point.start_rad = start_rad;
    point.turned_rad += idle_rad;
    point.height_mm = start_mm_ - per_rad_mm_ * point.turned_rad;
    points.push_back(point);
  }
  return points;
}

absl::StatusOr<InsertHeights> HeightsOf(const Cutter& cutter, const CutterRun& run) {
  RETURN_IF_ERROR(Validate(cutter, run));
  ASSIGN_OR_RETURN(InsertHeights heights, InsertHeights::Create(cutter, run, LengthCurve::DepthMm(run)));
  if (!(run.start_height_mm > heights.peak_mm())) {
    return absl::InvalidArgumentError(
        absl::StrFormat("start_height_mm = %g: an insert shades the beam there already, expected more than %.6f",
                        run.start_height_mm, heights.peak_mm()));
  }
  const double below_mm = FlankBelowEdgeMm(cutter, run, heights.peak_rad());
  constexpr double kClearMm = 1e-6;
  if (below_mm > kClearMm) {
    return absl::InvalidArgumentError(
        absl::StrFormat("clearance_deg = %g: the flank stands %.4f mm below the cutting edge in the beam, expected a "
                        "larger clearance (it "
                        "would rub)",
                        cutter.clearance_rad * base::kDegPerRad, below_mm));
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
