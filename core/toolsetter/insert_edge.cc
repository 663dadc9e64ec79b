#include "core/toolsetter/insert_edge.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "core/toolsetter/narrow_shade.h"

namespace axiscal::toolsetter {

namespace {

// M of cutter.h.
Eigen::Matrix3d Orientation(const Cutter& cutter) {
  const double cr = std::cos(cutter.radial_rad), sr = std::sin(cutter.radial_rad);
  const double ca = std::cos(cutter.axial_rad), sa = std::sin(cutter.axial_rad);
  Eigen::Matrix3d m;
  m << cr, sr * ca, sr * sa, -sr, cr * ca, cr * sa, 0.0, -sa, ca;
  return m;
}

constexpr int kDepths = 16;  // slices of the flank

}  // namespace

InsertEdge::InsertEdge(const Cutter& cutter, double offset_mm, double psi_rad, double depth_mm) {
  const Eigen::Matrix3d m = Orientation(cutter);
  const double r = cutter.insert_radius_mm, at_depth = r - depth_mm * std::tan(cutter.clearance_rad);
  const Eigen::Vector3d c = Eigen::Vector3d(cutter.tool_radius_mm, 0, 0) + m * Eigen::Vector3d(-r, depth_mm, r);
  const Eigen::Vector3d u = m * Eigen::Vector3d(at_depth, 0, 0), w = m * Eigen::Vector3d(0, 0, -at_depth);
  const double s = std::sin(psi_rad), k = std::cos(psi_rad);
  const double u_y = s * u.x() + k * u.y(), w_y = s * w.x() + k * w.y();
  const double w_z = w.z(), rho2 = u_y * u_y + w_y * w_y;  // u is horizontal
  shadow_.centre_mm = s * c.x() + k * c.y() - offset_mm;
  shadow_.rho_mm = std::sqrt(rho2);
  shadow_.level_mm = c.z();
  shadow_.a = std::abs(w_z * u_y) / rho2;
  shadow_.b = -w_z * w_y / rho2;
  bottom_mm_ = c.z() - std::abs(w_z);
}

double InsertEdge::LowestMm(double radius_mm) const {
  const double rho = shadow_.rho_mm, from = std::fmax(-radius_mm - shadow_.centre_mm, -rho);
  const double to = std::fmin(radius_mm - shadow_.centre_mm, rho);
  if (!(from <= to)) return std::numeric_limits<double>::infinity();
  const double steepness = std::hypot(shadow_.a, shadow_.b);
  if (!(rho > 0.0 && steepness > 0.0)) return bottom_mm_;  // seen as a line
  const double foot = std::clamp(shadow_.b * rho / steepness, from, to);
  return shadow_.level_mm - shadow_.a * std::sqrt(std::fmax(0.0, rho * rho - foot * foot)) - shadow_.b * foot;
}

bool InsertEdge::IsBeamBelowTop(double radius_mm, double height_mm) const {
  if (!Spans(radius_mm)) return false;
  const auto is_below = [&](double y_mm) {  // the upper edge is an arch: its ends are lowest
    const double foot = y_mm - shadow_.centre_mm;
    const double half_mm = shadow_.a * std::sqrt(shadow_.rho_mm * shadow_.rho_mm - foot * foot);
    return shadow_.level_mm + half_mm - shadow_.b * foot + height_mm > radius_mm;
  };
  return is_below(-radius_mm) && is_below(radius_mm);
}

std::optional<double> InsertEdge::ClosedFormMm(double beam_radius_mm) const {
  if (!(std::abs(shadow_.centre_mm) < shadow_.rho_mm)) return std::nullopt;
  return ClosedFormHeightMm(shadow_, shadow_.FootMm(0.0), beam_radius_mm);
}

std::optional<double> TriggerHeightMm(const Cutter& cutter, const CutterRun& run, double psi_rad) {
  const InsertEdge edge(cutter, run.offset_mm, psi_rad);
  if (!edge.Spans(run.beam_radius_mm)) return std::nullopt;
  const std::optional<HalfShade> half = HalfShadeHeight(edge.shadow(), run.beam_radius_mm);
  if (!half) return std::nullopt;
  return half->height_mm;
}

std::optional<double> ClosedFormTriggerMm(const Cutter& cutter, const CutterRun& run, double psi_rad) {
  return InsertEdge(cutter, run.offset_mm, psi_rad).ClosedFormMm(run.beam_radius_mm);
}

double BottomRadiusMm(const Cutter& cutter) {
  const double r = cutter.insert_radius_mm;
  const Eigen::Vector3d bottom =
      Eigen::Vector3d(cutter.tool_radius_mm, 0, 0) + Orientation(cutter) * Eigen::Vector3d(-r, 0, 0);
  return std::hypot(bottom.x(), bottom.y());
}

double ShadedShare(const Cutter& cutter, const CutterRun& run, double psi_rad, double height_mm) {
  const InsertEdge edge(cutter, run.offset_mm, psi_rad);
  return NarrowShadeAt(edge, run.beam_radius_mm, run.beam_radius_mm, height_mm).area_mm2 /
         (2.0 * HalfDiscMm2(run.beam_radius_mm));
}

double FlankBelowEdgeMm(const Cutter& cutter, const CutterRun& run, double psi_rad) {
  const double edge_mm = InsertEdge(cutter, run.offset_mm, psi_rad).At(0.0).z_mm;
  double below_mm = 0.0;
  for (int i = 1; i <= kDepths; ++i) {
    const double depth_mm = cutter.insert_thickness_mm * i / kDepths;
    below_mm = std::fmax(below_mm, edge_mm - InsertEdge(cutter, run.offset_mm, psi_rad, depth_mm).At(0.0).z_mm);
  }
  return below_mm;
}

std::optional<double> WholeInsertTriggerMm(const Cutter& cutter, const CutterRun& run, double psi_rad) {
  std::vector<InsertEdge> slices;
  for (int i = 0; i <= kDepths; ++i)
    slices.emplace_back(cutter, run.offset_mm, psi_rad, cutter.insert_thickness_mm * i / kDepths);
  // Strips of the disc that have some of the insert's shadow: y = R sin t.
  struct Strip {
    double top_mm, width_mm, edge_mm;
  };
  constexpr int kStrips = 96;
  const double radius_mm = run.beam_radius_mm, step = std::numbers::pi / kStrips;
  std::vector<Strip> strips;
  double low_mm = 0.0, high_mm = 0.0;
  for (int i = 0; i < kStrips; ++i) {
    const double t = (i + 0.5) * step - 0.5 * std::numbers::pi, top_mm = radius_mm * std::cos(t);
    double edge_mm = std::numeric_limits<double>::infinity();
    for (const InsertEdge& slice : slices) edge_mm = std::fmin(edge_mm, slice.At(radius_mm * std::sin(t)).z_mm);
    if (!std::isfinite(edge_mm)) continue;
    low_mm = strips.empty() ? -edge_mm - radius_mm : std::fmin(low_mm, -edge_mm - radius_mm);
    high_mm = strips.empty() ? -edge_mm + radius_mm : std::fmax(high_mm, -edge_mm + radius_mm);
    strips.push_back({top_mm, top_mm * step, edge_mm});
  }
  const auto is_half_shaded = [&](double height_mm) {
    double area_mm2 = 0.0;
    for (const Strip& strip : strips)
      area_mm2 += strip.width_mm * (strip.top_mm - std::clamp(strip.edge_mm + height_mm, -strip.top_mm, strip.top_mm));
    return area_mm2 >= HalfDiscMm2(radius_mm);
  };
  if (strips.empty() || !is_half_shaded(low_mm)) return std::nullopt;
  for (int i = 0; i < 40; ++i) {
    const double middle_mm = 0.5 * (low_mm + high_mm);
    (is_half_shaded(middle_mm) ? low_mm : high_mm) = middle_mm;
  }
  return high_mm;
}

}  // namespace axiscal::toolsetter
