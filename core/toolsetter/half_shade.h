// The height at which the shadow of a convex tool covers half of the beam's disc. The shadow is what lies above a
// convex lower edge z = edge(y) + height; an Edge is a value with
//   EdgePoint At(double y_mm) const   // at height 0
// Disc: y = R sin t, z = -R cos t. Where the edge crosses it at t- in (-pi, 0) and t+ in (0, pi), y1 and y2:
//   S = R^2 (u/2 + sin(2u)/4) from t+ to t- + 2 pi  -  integral of z over y1 .. y2,  dS/dheight = -(y2 - y1)
// S falls with the height, so that the wanted height is the one root of S = pi R^2 / 2 (seeds: Fang 2022, 2.6; exact).
#ifndef AXISCAL_CORE_TOOLSETTER_HALF_SHADE_H_
#define AXISCAL_CORE_TOOLSETTER_HALF_SHADE_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace axiscal::toolsetter {

struct EdgePoint {
  double z_mm = 0.0;
  double slope = 0.0;  // dz/dy
};

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

// The shadow at one height: the spans of y in which its edge runs inside the disc (one, but for tools that are narrower
// than the beam), how much of the circle is shaded, and the area.
struct Shade {
  std::array<std::pair<double, double>, 3> spans_mm = {};
  int span_count = 0;
  double arc_rad = 0.0;
  double area_mm2 = 0.0;

  double WidthMm() const {
    double width_mm = 0.0;
    for (int i = 0; i < span_count; ++i) width_mm += spans_mm[i].second - spans_mm[i].first;
    return width_mm;
  }
};

// The crossing on one side (+1: t in (0, pi), -1: (-pi, 0)), Newton kept in its bracket; nothing when the edge passes
// the disc's top or bottom.
template <typename Edge>
std::optional<double> Crossing(const Edge& edge, double radius_mm, double height_mm, double side) {
  const double middle_mm = edge.At(0.0).z_mm + height_mm;
  if (!(std::abs(middle_mm) < radius_mm)) return std::nullopt;
  double low = 0.0, high = std::numbers::pi;  // of |t|: below the edge at 0, above it at pi
  double t = std::acos(std::clamp(-middle_mm / radius_mm, -1.0, 1.0));
  for (int i = 0; i < 60; ++i) {
    const double sine = side * std::sin(t), cosine = std::cos(t);
    const EdgePoint at = edge.At(radius_mm * sine);
    const double miss = -radius_mm * cosine - at.z_mm - height_mm;
    (miss < 0.0 ? low : high) = t;
    const double slope = radius_mm * (side * sine - at.slope * side * cosine);
    double next = t - miss / slope;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const double step = std::abs(next - t);
    t = next;
    if (step < 1e-14) break;
  }
  return side * t;
}

// The shade of an edge that reaches across the whole disc; nothing when it passes above or below the disc's middle.
template <typename Edge>
std::optional<Shade> ShadeAt(const Edge& edge, double radius_mm, double height_mm) {
  const std::optional<double> left = Crossing(edge, radius_mm, height_mm, -1.0);
  const std::optional<double> right = Crossing(edge, radius_mm, height_mm, 1.0);
  if (!left || !right) return std::nullopt;
  const auto circle = [radius_mm](double t) { return radius_mm * radius_mm * (0.5 * t + 0.25 * std::sin(2.0 * t)); };
  const double turn = 2.0 * std::numbers::pi, from_mm = radius_mm * std::sin(*left),
               to_mm = radius_mm * std::sin(*right);
  Shade shade;
  shade.spans_mm[shade.span_count++] = {from_mm, to_mm};
  shade.arc_rad = turn - (*right - *left);
  shade.area_mm2 = circle(*left + turn) - circle(*right) -
                   Integrate(from_mm, to_mm, [&](double y_mm) { return edge.At(y_mm).z_mm + height_mm; });
  return shade;
}

inline double HalfDiscMm2(double radius_mm) { return 0.5 * std::numbers::pi * radius_mm * radius_mm; }

struct HalfShade {
  double height_mm = 0.0;
  Shade shade;
};

// Newton from `start_mm` (the closed forms are within 1e-5: two steps); nothing when no height shades half.
template <typename Edge>
std::optional<HalfShade> HalfShadeHeight(const Edge& edge, double radius_mm, double start_mm) {
  const double target_mm2 = HalfDiscMm2(radius_mm);
  double height_mm = start_mm;
  for (int i = 0; i < 30; ++i) {
    const std::optional<Shade> shade = ShadeAt(edge, radius_mm, height_mm);
    if (!shade) return std::nullopt;
    const double step_mm = (shade->area_mm2 - target_mm2) / shade->WidthMm();
    if (!(std::abs(step_mm) > 1e-13 * radius_mm)) return HalfShade{height_mm, *shade};
    height_mm += step_mm;
  }
  return std::nullopt;
}

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_HALF_SHADE_H_
