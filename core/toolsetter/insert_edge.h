// The shadow of one round insert at one spindle angle, and the height Zc of O_t at which it shades exactly half of the
// beam. Projected along X the cutting edge is an ellipse,  y = c_y + u_y cos x + w_y sin x,  z = c_z + w_z sin x, whose
// lower arc is the lower edge of the shadow. Over Y = y - c_y, with rho = hypot(u_y, w_y):
//   z(Y) = c_z - |w_z u_y| / rho^2 sqrt(rho^2 - Y^2) + w_z w_y / rho^2 Y      (O_t at height 0)
#ifndef AXISCAL_CORE_TOOLSETTER_INSERT_EDGE_H_
#define AXISCAL_CORE_TOOLSETTER_INSERT_EDGE_H_

#include <cmath>
#include <optional>

#include "core/toolsetter/cutter.h"
#include "core/toolsetter/half_shade.h"

namespace axiscal::toolsetter {

class InsertEdge {
 public:
  // `depth_mm` into the flank, 0: the cutting edge.
  InsertEdge(const Cutter& cutter, double offset_mm, double psi_rad, double depth_mm = 0.0);

  // At O_t's height 0.
  const ShadowEdge& shadow() const { return shadow_; }
  // NaN where the edge does not reach.
  EdgePoint At(double y_mm) const { return shadow_.At(y_mm); }
  // Whether it reaches across |y| <= radius.
  bool Spans(double radius_mm) const { return std::abs(shadow_.centre_mm) + radius_mm < shadow_.rho_mm; }

  // The edge's lowest z within |y| <= radius, at O_t's height 0: no trigger stands higher than the negative of it.
  // +infinity where the insert reaches nowhere into the beam.
  double LowestMm(double radius_mm) const;
  // Whether the whole disc stands below the insert's upper edge: else the insert is seen so slim that its lower edge
  // alone does not tell what it shades.
  bool IsBeamBelowTop(double radius_mm, double height_mm) const;

  // Zc by the edge's height and curvature in the beam's centre (half_shade.h), within 5e-7 mm where a trigger can
  // happen. Nothing where the edge does not reach the beam's centre.
  std::optional<double> ClosedFormMm(double beam_radius_mm) const;

 private:
  ShadowEdge shadow_;
  double bottom_mm_ = 0.0;  // the lowest z of the whole edge
};

// Exact to 1e-12 mm; nothing where the insert does not reach across the beam.
std::optional<double> TriggerHeightMm(const Cutter& cutter, const CutterRun& run, double psi_rad);
std::optional<double> ClosedFormTriggerMm(const Cutter& cutter, const CutterRun& run, double psi_rad);

// How far from the axis the edge's lowest point stands: the largest offset at which it still crosses the beam.
double BottomRadiusMm(const Cutter& cutter);

// Share of the beam's disc that an insert shades with O_t at `height_mm`, 0 .. 1.
double ShadedShare(const Cutter& cutter, const CutterRun& run, double psi_rad, double height_mm);

// How far the flank's shadow reaches below the cutting edge's in the middle of the beam, mm; 0 where it is clear.
double FlankBelowEdgeMm(const Cutter& cutter, const CutterRun& run, double psi_rad);

// Where the cutting edge alone does not tell: the height at which the whole insert, edge and flank,
// shades half of it, to about 1e-4 of the beam's radius; nothing where it never does.
std::optional<double> WholeInsertTriggerMm(const Cutter& cutter, const CutterRun& run, double psi_rad);

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_INSERT_EDGE_H_
