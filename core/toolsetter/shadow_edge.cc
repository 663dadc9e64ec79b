#include "core/toolsetter/shadow_edge.h"

namespace axiscal::toolsetter {

double ShadowEdge::FootMm(double y_mm) const {
  const double from_centre_mm = y_mm - centre_mm;
  if (fillet_mm == 0.0) return from_centre_mm;
  double foot_mm = from_centre_mm * rho_mm / (rho_mm + fillet_mm);
  for (int i = 0; i < 60; ++i) {  // y grows with Y: Newton, kept inside
    const FootPoint at = AtFoot(foot_mm);
    double next = foot_mm - (at.y_mm - y_mm) / at.y_per_foot;
    if (!(std::abs(next) < rho_mm)) next = 0.5 * (foot_mm + std::copysign(rho_mm, next));
    const double step = std::abs(next - foot_mm);
    foot_mm = next;
    if (step < 1e-15 * rho_mm) break;
  }
  return foot_mm;
}

EdgePoint ShadowEdge::At(double y_mm) const {
  const FootPoint at = AtFoot(FootMm(y_mm));
  return {at.z_mm, at.slope};
}

}  // namespace axiscal::toolsetter
