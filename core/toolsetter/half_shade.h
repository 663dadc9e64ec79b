// The height at which the shadow of a tool covers half of the beam's disc. The shadow is what lies above its lower edge
// z = edge(y) + height, a convex arc (shadow_edge.h).
// Disc: y = R sin t, z = -R cos t. Where the edge crosses it at t- in (-pi, 0) and t+ in (0, pi), y1 and y2:
//   S = R^2 (u/2 + sin(2u)/4) from t+ to t- + 2 pi  -  integral of z over y1 .. y2,  dS/dheight = -(y2 - y1)
// S falls with the height, so that the wanted height is the one root of S = pi R^2 / 2 (Fang 2022, 2.6; exact). All of
// it is taken over the edge's feet, of which z and y are plain functions: none is looked for.
#ifndef AXISCAL_CORE_TOOLSETTER_HALF_SHADE_H_
#define AXISCAL_CORE_TOOLSETTER_HALF_SHADE_H_

#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/toolsetter/shadow_edge.h"

namespace axiscal::toolsetter {

// 16-point Gauss-Legendre on (-1, 1): positive half, symmetric.
inline constexpr std::array<double, 8> kGaussAt = {
    0.0950125098376374401853193, 0.2816035507792589132304605, 0.4580167776572273863424194, 0.6178762444026437484466718,
    0.7554044083550030338951012, 0.8656312023878317438804679, 0.9445750230732325760779884, 0.9894009349916499325961542};
inline constexpr std::array<double, 8> kGaussWeight = {
    0.1894506104550684962853967, 0.1826034150449235888667637, 0.1691565193950025381893121, 0.1495959888165767320815017,
    0.1246289712555338720524763, 0.0951585116824927848099251, 0.0622535239386478928628438, 0.0271524594117540948517806};

// visit(place, weight) for the 16 points of [from, to]: the integral of f is the sum of f(place) weight.
template <typename Visit>
void ForGaussPoints(double from, double to, const Visit& visit) {
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
  for (size_t i = 0; i < kGaussAt.size(); ++i) {
    visit(middle - half * kGaussAt[i], half * kGaussWeight[i]);
    visit(middle + half * kGaussAt[i], half * kGaussWeight[i]);
  }
}

// Integral of f over [from, to].
template <typename F>
double Integrate(double from, double to, const F& f) {
  double sum = 0.0;
  ForGaussPoints(from, to, [&](double at, double weight) { sum += weight * f(at); });
  return sum;
}

// visit(foot, point, weight) for points that integrate over y what is smooth along the edge, from one foot to another.
// dy/dY has a spike where a nearly straight face turns into its fillet, which 16 points miss; so a panel counts only if
// it gives the width that its ends have, and is halved otherwise.
// Known limit: with a tilted face seen exactly along its edge (a = 0: yaw 0, pitch 0, azimuth 90 deg) all of the fillet
// belongs to one foot. The panels then run out, and a height in a beam of 0.5 mm is 0.4 um off.
template <typename Visit>
void ForEdgePoints(const ShadowEdge& edge, double from_mm, double to_mm, const Visit& visit) {
  constexpr double kWidthOff = 1e-11;  // of the whole width: 1e-11 R in a height
  constexpr int kMostPanels = 400;     // beside it the halves of a spike at one end come to 50
  struct Panel {
    double from_mm, to_mm;
  };
  struct Point {
    double foot_mm, weight_mm;
    FootPoint at;
  };
  const double off_mm = kWidthOff * (edge.AtFoot(to_mm).y_mm - edge.AtFoot(from_mm).y_mm);
  std::array<Panel, 64> open;
  size_t count = 0;
  open[count++] = {from_mm, to_mm};
  for (int panels = 1; count > 0; ++panels) {
    const Panel panel = open[--count];
    std::array<Point, 2 * kGaussAt.size()> points;
    size_t filled = 0;
    double width_mm = edge.AtFoot(panel.from_mm).y_mm - edge.AtFoot(panel.to_mm).y_mm;
    ForGaussPoints(panel.from_mm, panel.to_mm, [&](double foot_mm, double weight_mm) {
      const FootPoint at = edge.AtFoot(foot_mm);
      width_mm += at.y_per_foot * weight_mm;
      points[filled++] = {foot_mm, at.y_per_foot * weight_mm, at};
    });
    const double middle_mm = 0.5 * (panel.from_mm + panel.to_mm);
    const bool is_halved = std::abs(width_mm) > off_mm && panels < kMostPanels && count + 2 <= open.size() &&
                           panel.from_mm < middle_mm && middle_mm < panel.to_mm;
    if (is_halved) {
      open[count++] = {middle_mm, panel.to_mm};
      open[count++] = {panel.from_mm, middle_mm};
      continue;
    }
    for (const Point& point : points) visit(point.foot_mm, point.at, point.weight_mm);
  }
}

inline double HalfDiscMm2(double radius_mm) { return 0.5 * std::numbers::pi * radius_mm * radius_mm; }

struct HalfShade {
  double height_mm = 0.0;
  double area_mm2 = 0.0;                        // shaded there
  double width_mm = 0.0;                        // y2 - y1
  double arc_rad = 0.0;                         // of the circle, shaded
  double foot_from_mm = 0.0, foot_to_mm = 0.0;  // of the edge's points at y1 and y2
};

// Edge through the beam's centre plus its curvature:  height = -z - f2 R^2 / (6 (1 + f1^2)), f1, f2 = dz/dy, d2z/dy2
// at y = 0, to which `foot_mm` belongs.
double ClosedFormHeightMm(const ShadowEdge& edge, double foot_mm, double radius_mm);

// Newton from the closed form. The edge must reach across the whole disc, |y| <= R; nothing where no height shades
// half.
std::optional<HalfShade> HalfShadeHeight(const ShadowEdge& edge, double radius_mm);

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_HALF_SHADE_H_
