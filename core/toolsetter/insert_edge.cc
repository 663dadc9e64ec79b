#include "core/toolsetter/insert_edge.h"

#include <Eigen/Core>
#include <cmath>

#include "core/toolsetter/narrow_shade.h"

namespace axiscal::toolsetter {

InsertEdge::InsertEdge(const Cutter& cutter, double offset_mm, double psi_rad, double depth_mm) {
  const double cr = std::cos(cutter.radial_rad), sr = std::sin(cutter.radial_rad);
  const double ca = std::cos(cutter.axial_rad), sa = std::sin(cutter.axial_rad);
  Eigen::Matrix3d m;
  m << cr, sr * ca, sr * sa, -sr, cr * ca, cr * sa, 0.0, -sa, ca;
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

double ShadedShare(const Cutter& cutter, const CutterRun& run, double psi_rad, double height_mm) {
  const InsertEdge edge(cutter, run.offset_mm, psi_rad);
  return NarrowShadeAt(edge, run.beam_radius_mm, run.beam_radius_mm, height_mm).area_mm2 /
         (2.0 * HalfDiscMm2(run.beam_radius_mm));
}

double FlankBelowEdgeMm(const Cutter& cutter, const CutterRun& run, double psi_rad) {
  const double edge_mm = InsertEdge(cutter, run.offset_mm, psi_rad).At(0.0).z_mm;
  double below_mm = 0.0;
  constexpr int kDepths = 16;
  for (int i = 1; i <= kDepths; ++i) {
    const double depth_mm = cutter.insert_thickness_mm * i / kDepths;
    below_mm = std::fmax(below_mm, edge_mm - InsertEdge(cutter, run.offset_mm, psi_rad, depth_mm).At(0.0).z_mm);
  }
  return below_mm;
}

}  // namespace axiscal::toolsetter
