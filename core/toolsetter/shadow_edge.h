// The lower edge of a tool's shadow in the beam, at height 0: the lower arc of an ellipse, grown by a ball.
//   core(Y) = level - a sqrt(rho^2 - Y^2) - b Y,  |Y| <= rho, a >= 0
//   edge: y = centre + Y + R_f g/h, z = core(Y) - R_f/h, g = core'(Y), h = sqrt(1 + g^2)
// Y is the foot of the edge's point at y: where the ball stands that touches it. The edge of a measuring rod is such an
// arc (rod.h), that of a round insert too, with R_f = 0 (insert_edge.h). Photodiode's y and z (beam.h), mm.
#ifndef AXISCAL_CORE_TOOLSETTER_SHADOW_EDGE_H_
#define AXISCAL_CORE_TOOLSETTER_SHADOW_EDGE_H_

#include <cmath>

namespace axiscal::toolsetter {

struct EdgePoint {
  double z_mm = 0.0;
  double slope = 0.0;  // dz/dy
};

// The edge's point that belongs to a foot.
struct FootPoint {
  double y_mm = 0.0, z_mm = 0.0;
  double slope = 0.0;       // dz/dy, which is core' too
  double y_per_foot = 1.0;  // dy/dY, 1 or more
};

struct ShadowEdge {
  double centre_mm = 0.0, rho_mm = 0.0, level_mm = 0.0;
  double a = 0.0, b = 0.0;
  double fillet_mm = 0.0;  // R_f

  // NaN where |foot| > rho.
  FootPoint AtFoot(double foot_mm) const {
    const double rho2 = rho_mm * rho_mm, w2 = rho2 - foot_mm * foot_mm, w = std::sqrt(w2);
    const double g = a * foot_mm / w - b, core_mm = level_mm - a * w - b * foot_mm;
    if (fillet_mm == 0.0) return {centre_mm + foot_mm, core_mm, g, 1.0};
    const double h2 = 1.0 + g * g, h = std::sqrt(h2);
    return {centre_mm + foot_mm + fillet_mm * g / h, core_mm - fillet_mm / h, g,
            1.0 + fillet_mm * a * rho2 / (w2 * w * h2 * h)};
  }
  // d2core/dY2.
  double Bend(double foot_mm) const {
    const double w2 = rho_mm * rho_mm - foot_mm * foot_mm;
    return a * rho_mm * rho_mm / (w2 * std::sqrt(w2));
  }
  // Y of the edge's point at y.
  double FootMm(double y_mm) const;
  // NaN where the edge does not reach.
  EdgePoint At(double y_mm) const;
};

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_SHADOW_EDGE_H_
