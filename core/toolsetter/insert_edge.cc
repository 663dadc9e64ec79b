#include "core/toolsetter/insert_edge.h"

#include <cmath>
#include <limits>

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
  c_y_mm_ = s * c.x() + k * c.y() - offset_mm;
  u_y_mm_ = s * u.x() + k * u.y();
  w_y_mm_ = s * w.x() + k * w.y();
  c_z_mm_ = c.z();
  w_z_mm_ = w.z();  // u is horizontal
  rho_mm_ = std::hypot(u_y_mm_, w_y_mm_);
  x0_rad_ = std::atan2(w_y_mm_, u_y_mm_);
}

double InsertEdge::LowerArc(double y_mm) const {
  const double q = std::acos((y_mm - c_y_mm_) / rho_mm_);
  const double plus = x0_rad_ + q, minus = x0_rad_ - q;
  return w_z_mm_ * std::sin(plus) < w_z_mm_ * std::sin(minus) ? plus : minus;
}

EdgePoint InsertEdge::At(double y_mm) const {
  const double x = LowerArc(y_mm), sine = std::sin(x), cosine = std::cos(x);
  return {c_z_mm_ + w_z_mm_ * sine, w_z_mm_ * cosine / (w_y_mm_ * cosine - u_y_mm_ * sine)};
}

bool InsertEdge::Spans(double radius_mm) const { return std::abs(c_y_mm_) + radius_mm < rho_mm_; }

std::optional<double> InsertEdge::ClosedFormMm(double beam_radius_mm) const {
  if (!(std::abs(c_y_mm_) < rho_mm_)) return std::nullopt;
  const double x = LowerArc(0.0), sine = std::sin(x), cosine = std::cos(x);
  const double y1 = -u_y_mm_ * sine + w_y_mm_ * cosine, z1 = w_z_mm_ * cosine;
  const double y2 = -u_y_mm_ * cosine - w_y_mm_ * sine, z2 = -w_z_mm_ * sine;
  const double f1 = z1 / y1, f2 = (z2 * y1 - z1 * y2) / (y1 * y1 * y1);
  return -(c_z_mm_ + w_z_mm_ * sine) - f2 * beam_radius_mm * beam_radius_mm / (6.0 * (1.0 + f1 * f1));
}

std::optional<double> TriggerHeightMm(const Cutter& cutter, const CutterRun& run, double psi_rad) {
  const InsertEdge edge(cutter, run.offset_mm, psi_rad);
  if (!edge.Spans(run.beam_radius_mm)) return std::nullopt;
  const std::optional<HalfShade> half =
      HalfShadeHeight(edge, run.beam_radius_mm, *edge.ClosedFormMm(run.beam_radius_mm));
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
