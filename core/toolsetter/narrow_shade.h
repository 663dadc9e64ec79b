// The shade of a tool that may be narrower than the beam, so that its shadow ends inside the disc and its edge can
// cross the circle up to four times: crossings are looked for panel by panel. Slow (milliseconds); for wide tools it
// agrees with half_shade.h and is its twin in tests. An Edge is a value with
//   EdgePoint At(double y_mm) const   // at height 0
#ifndef AXISCAL_CORE_TOOLSETTER_NARROW_SHADE_H_
#define AXISCAL_CORE_TOOLSETTER_NARROW_SHADE_H_

#include <algorithm>
#include <utility>

#include "core/toolsetter/half_shade.h"

namespace axiscal::toolsetter {

// The shadow at one height: the spans of y in which its edge runs inside the disc, how much of the circle is shaded,
// and the area.
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

struct NarrowHalfShade {
  double height_mm = 0.0;
  Shade shade;
};

// Area of the disc within |y| < half_width.
inline double StripMm2(double radius_mm, double half_width_mm) {
  const double w = std::min(half_width_mm, radius_mm);
  return 2.0 * (w * std::sqrt(radius_mm * radius_mm - w * w) + radius_mm * radius_mm * std::asin(w / radius_mm));
}

// The edge stands within |y| < half_width.
template <typename Edge>
Shade NarrowShadeAt(const Edge& edge, double radius_mm, double half_width_mm, double height_mm) {
  // y = R sin t takes the circle's steep sides away; the edge's own end may be as steep, so that panels shrink there.
  constexpr int kPanels = 400;
  const double end = std::asin(std::min(1.0, half_width_mm / radius_mm));
  const auto y_of = [&](double s) { return radius_mm * std::sin(end * std::sin(0.5 * std::numbers::pi * s)); };
  const auto top = [&](double y) { return std::sqrt(std::max(0.0, radius_mm * radius_mm - y * y)); };
  // 0: above the disc, 1: inside, 2: below.
  const auto where = [&](double s) {
    const double y = y_of(s), z = edge.At(y).z_mm + height_mm;
    return !(z < top(y)) ? 0 : z > -top(y) ? 1 : 2;
  };
  Shade shade;
  int last = 0;
  const auto add = [&](double from, double to) {
    const int place = where(0.5 * (from + to));
    const double y1 = y_of(from), y2 = y_of(to);
    const double arc = std::asin(y2 / radius_mm) - std::asin(y1 / radius_mm);
    const double disc = [&] {
      const auto area = [&](double y) { return y * top(y) + radius_mm * radius_mm * std::asin(y / radius_mm); };
      return area(y2) - area(y1);  // twice the area under the circle: the whole strip
    }();
    if (place == 2) shade.area_mm2 += disc;
    shade.arc_rad += place * arc;
    if (place == 1) {
      shade.area_mm2 += 0.5 * disc - Integrate(from, to, [&](double s) {
                          const double phase = 0.5 * std::numbers::pi * s, t = end * std::sin(phase);
                          const double dy = radius_mm * std::cos(t) * end * std::cos(phase) * 0.5 * std::numbers::pi;
                          return (edge.At(radius_mm * std::sin(t)).z_mm + height_mm) * dy;
                        });
      const bool joins = last == 1;
      if (!joins && shade.span_count < 3) shade.spans_mm[shade.span_count++].first = y1;
      shade.spans_mm[shade.span_count - 1].second = y2;
    }
    last = place;
  };
  double from = -1.0 + 1e-12;
  for (int i = 1; i <= kPanels; ++i) {
    const double to = i == kPanels ? 1.0 - 1e-12 : -1.0 + 2.0 * i / kPanels;
    double begin = from;
    while (where(begin) != where(to)) {  // cut where the edge crosses the circle; at most a few times
      double low = begin, high = to;
      const int place = where(begin);
      for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (low + high);
        (where(middle) == place ? low : high) = middle;
      }
      add(begin, low);
      begin = high;
      if (high >= to) break;
    }
    if (begin < to) add(begin, to);
    from = to;
  }
  return shade;
}

// Nothing when the strip that the tool covers is less than half of the disc.
template <typename Edge>
std::optional<NarrowHalfShade> NarrowHalfShadeHeight(const Edge& edge, double radius_mm, double half_width_mm) {
  const double target_mm2 = HalfDiscMm2(radius_mm);
  if (!(StripMm2(radius_mm, half_width_mm) > target_mm2 * (1.0 + 1e-9))) return std::nullopt;
  // The root lies where the edge's lowest point passes the disc, or its highest one, at the shadow's ends, has.
  double low_mm = -2.0 * radius_mm, high_mm = 2.0 * radius_mm;
  while (NarrowShadeAt(edge, radius_mm, half_width_mm, low_mm).area_mm2 < target_mm2) low_mm *= 2.0;
  while (NarrowShadeAt(edge, radius_mm, half_width_mm, high_mm).area_mm2 > target_mm2) high_mm *= 2.0;
  while (high_mm - low_mm > 1e-13 * (1.0 + std::abs(low_mm))) {
    const double middle_mm = 0.5 * (low_mm + high_mm);
    if (!(middle_mm > low_mm && middle_mm < high_mm)) break;
    (NarrowShadeAt(edge, radius_mm, half_width_mm, middle_mm).area_mm2 > target_mm2 ? low_mm : high_mm) = middle_mm;
  }
  const double height_mm = 0.5 * (low_mm + high_mm);
  return NarrowHalfShade{height_mm, NarrowShadeAt(edge, radius_mm, half_width_mm, height_mm)};
}

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_NARROW_SHADE_H_
