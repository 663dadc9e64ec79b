#include "core/compensate/bend.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace axiscal::compensate {

using machine::ErrorTerm;

double GapOf(const shapes::Tabulated& map, int axis) {
  const shapes::Node& node = axis == map.second_axis ? map.second : map.node;
  double gap = std::min(node.before, node.after);
  if (axis == map.axis && map.is_tied) gap = std::min({gap, map.tied_to.before, map.tied_to.after});
  return gap;
}

namespace {

// Largest value, first and second derivative of each function of a span by its variable.
Bend LargestOf(const shapes::Span& span, int order) {
  if (span.is_turn) return {std::numbers::sqrt2, std::numbers::sqrt2 * order, std::numbers::sqrt2 * order * order};
  // Of P_j: 1, j (j + 1) / 2 and (j - 1) j (j + 1) (j + 2) / 8, all at an end.
  const double scale = std::sqrt(2.0 * order + 1.0), per_mm = 2.0 / (span.high - span.low), j = order;
  return {scale, scale * j * (j + 1) / 2 * per_mm, scale * (j - 1) * j * (j + 1) * (j + 2) / 8 * per_mm * per_mm};
}

// Behind the end of a span a curve fades, with a corner at the end.
void AddFade(const shapes::Span& span, double from, double to, Bend* bend) {
  if (span.is_turn) return;
  const double low = std::min(span.Within(from), span.Within(to)), high = std::max(span.Within(from), span.Within(to));
  if (low >= -1.0 && high <= 1.0) return;
  const double travel = (high - low) / shapes::kFade;  // exp(-u^2): slopes up to 0.858, curvatures up to 2
  bend->curvature += 2.0 * bend->slope * 0.858 * travel + 2.0 * bend->size * travel * travel;
  bend->slope += bend->size * 0.858 * travel;
  bend->curvature += 8.0 * std::min(bend->slope, 2.0 * bend->size);
}

// The sum over an open span, at the extrema of the Chebyshev polynomial of twice its degree between `from` and `to`:
// no polynomial exceeds its largest value there by more than 1 / cos(pi / 4) (Ehlich and Zeller 1964).
Bend AlongSpan(const shapes::Curve& curve, const ErrorTerm& term, double from, double to) {
  constexpr double kBetween = std::numbers::sqrt2;
  const int degree = curve.span.OrderOf(curve.functions - 1, shapes::Curve::kFirst), points = 2 * degree;
  const double first = std::clamp(curve.span.Within(from), -1.0, 1.0);
  const double last = std::clamp(curve.span.Within(to), -1.0, 1.0);
  Bend largest;
  for (int k = 0; k <= points; ++k) {
    const double x = 0.5 * (first + last) + 0.5 * (last - first) * std::cos(std::numbers::pi * k / points);
    // P_j and its derivatives: P'_(j + 1) = P'_(j - 1) + (2 j + 1) P_j.
    double value[2] = {0, 1}, slope[2] = {0, 0}, curvature[2] = {0, 0};
    Bend sum;
    for (int j = 0; j <= degree; ++j) {
      if (j >= shapes::Curve::kFirst) {
        const double a = term.amplitude[j - shapes::Curve::kFirst] * std::sqrt(2.0 * j + 1.0);
        sum.size += a * value[1];
        sum.slope += a * slope[1];
        sum.curvature += a * curvature[1];
      }
      const double next[3] = {((2 * j + 1) * x * value[1] - j * value[0]) / (j + 1), slope[0] + (2 * j + 1) * value[1],
                              curvature[0] + (2 * j + 1) * slope[1]};
      value[0] = value[1], slope[0] = slope[1], curvature[0] = curvature[1];
      value[1] = next[0], slope[1] = next[1], curvature[1] = next[2];
    }
    largest.size = std::max(largest.size, kBetween * std::abs(sum.size));
    largest.slope = std::max(largest.slope, kBetween * std::abs(sum.slope));
    largest.curvature = std::max(largest.curvature, kBetween * std::abs(sum.curvature));
  }
  const double travel = std::abs(to - from) * 2.0 / (curve.span.high - curve.span.low);
  largest.slope *= travel;
  largest.curvature *= travel * travel;
  return largest;
}

Bend BendOfCurve(const shapes::Curve& curve, const ErrorTerm& term, double from, double to) {
  Bend bend;
  if (curve.span.is_turn) {
    const double travel = std::abs(to - from);
    for (int i = 0; i < curve.functions; ++i) {
      const Bend one = LargestOf(curve.span, curve.span.OrderOf(i, shapes::Curve::kFirst));
      bend.size += std::abs(term.amplitude[i]) * one.size;
      bend.slope += std::abs(term.amplitude[i]) * one.slope * travel;
      bend.curvature += std::abs(term.amplitude[i]) * one.curvature * travel * travel;
    }
    return bend;
  }
  bend = AlongSpan(curve, term, from, to);
  AddFade(curve.span, from, to, &bend);
  return bend;
}

Bend BendOfCrossed(const shapes::Crossed& crossed, const ErrorTerm& term, const AxisValues& from,
                   const AxisValues& to) {
  const double travel = std::abs(to[crossed.axis] - from[crossed.axis]);
  const double other_travel = std::abs(to[crossed.second_axis] - from[crossed.second_axis]);
  Bend bend;
  const auto largest_of = [](const shapes::Span& span, int function) {
    constexpr Bend kOfConstant{.size = 1.0};
    return function < 0 ? kOfConstant : LargestOf(span, span.OrderOf(function, shapes::Crossed::kFirst));
  };
  for (int i = 0; i < crossed.Count(); ++i) {
    const double a = std::abs(term.amplitude[i]);
    const Bend one = largest_of(crossed.span, crossed.OfFirst(i));
    const Bend other = largest_of(crossed.second, crossed.OfSecond(i));
    bend.size += a * one.size * other.size;
    bend.slope += a * (one.slope * travel * other.size + one.size * other.slope * other_travel);
    bend.curvature +=
        a * (one.curvature * travel * travel * other.size + 2.0 * one.slope * travel * other.slope * other_travel +
             one.size * other.curvature * other_travel * other_travel);
  }
  AddFade(crossed.span, from[crossed.axis], to[crossed.axis], &bend);
  AddFade(crossed.second, from[crossed.second_axis], to[crossed.second_axis], &bend);
  return bend;
}

}  // namespace

double SmoothTravel(const shapes::Span& span, int order) {
  // An eighth of the shortest period; polynomials are twice as steep near the ends.
  return span.is_turn ? 0.25 * std::numbers::pi / order : 0.125 * (span.high - span.low) / order;
}

Bend BendOf(const ErrorTerm& term, const AxisValues& from, const AxisValues& to) {
  if (const auto* curve = shapes::CurveOf(term.shape))
    return BendOfCurve(*curve, term, from[curve->axis], to[curve->axis]);
  if (const auto* crossed = std::get_if<shapes::Crossed>(&term.shape)) return BendOfCrossed(*crossed, term, from, to);
  double amplitude = 0;
  for (int i = 0; i < shapes::BasisCount(term.shape); ++i) amplitude += std::abs(term.amplitude[i]);
  const auto along = [&](int axis, double* largest) {
    *largest = std::max(std::abs(from[axis]), std::abs(to[axis]));
    return std::abs(to[axis] - from[axis]);
  };
  double largest = 0;
  if (const auto* linear = std::get_if<shapes::Linear>(&term.shape)) {
    const double travel = along(linear->axis, &largest) / linear->reference;
    return {amplitude * largest / linear->reference, amplitude * travel, 0};
  }
  if (const auto* quadratic = std::get_if<shapes::Quadratic>(&term.shape)) {
    const double travel = along(quadratic->axis, &largest) / quadratic->reference;
    largest /= quadratic->reference;
    return {amplitude * largest * largest, 2 * amplitude * largest * travel, 2 * amplitude * travel * travel};
  }
  if (const auto* harmonic = std::get_if<shapes::Harmonic>(&term.shape)) {
    const double turn = along(harmonic->axis, &largest) * std::abs(harmonic->frequency);
    return {amplitude, amplitude * turn, amplitude * turn * turn};
  }
  if (const auto* bump = std::get_if<shapes::Bump>(&term.shape)) {
    // exp(-u^2) has slopes up to sqrt(2 / e) and curvatures up to 2; six widths away nothing is left of it.
    const double low = std::min(from[bump->axis], to[bump->axis]) - bump->at;
    const double high = std::max(from[bump->axis], to[bump->axis]) - bump->at;
    if (std::min(std::abs(low), std::abs(high)) > 6.0 * bump->width && low * high > 0) return {0, 0, 0};
    const double travel = along(bump->axis, &largest) / bump->width;
    return {amplitude, 0.858 * amplitude * travel, 2.0 * amplitude * travel * travel};
  }
  if (const auto* map = std::get_if<shapes::Tabulated>(&term.shape)) {
    // Linear between nodes, with corners at them: the departure from a straight line is at most the whole change, and a
    // curvature of eight times the change has that departure.
    double travel = along(map->axis, &largest) / GapOf(*map, map->axis);
    if (map->second_axis >= 0) travel += along(map->second_axis, &largest) / GapOf(*map, map->second_axis);
    const double size = (map->is_tied ? 2.0 : 1.0) * amplitude, change = std::min(size * travel, 2.0 * size);
    return {size, change, 8.0 * change};
  }
  // Backlash does not change along a move.
  return {amplitude, 0, 0};
}

}  // namespace axiscal::compensate
