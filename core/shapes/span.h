// What a free curve is a sum of: smooth functions of one variable q over the span that was measured, each with a mean
// square of 1 over it.
//   open span [low, high]:  sqrt(2 j + 1) P_j(x), x = (2 q - low - high) / (high - low); P_j: Legendre polynomials.
//                           Those from an order on are orthogonal to all polynomials below it.
//   a full turn:            sqrt(2) cos(n q), sqrt(2) sin(n q), n = 1, 2 ...
// Beyond an open span, d half spans from its end, the functions keep the end's value times exp(-(d / 0.25)^2): what
// was not measured fades to zero, and what is known of it to the prior.
#ifndef AXISCAL_CORE_SHAPES_SPAN_H_
#define AXISCAL_CORE_SHAPES_SPAN_H_

#include <algorithm>
#include <array>
#include <cmath>

namespace axiscal::shapes {

inline constexpr double kFade = 0.25;  // of half a span

// Legendre polynomials by their recurrence: P_(j+1) = by_now[j] x P_j - by_before[j] P_(j-1).
struct LegendreFactors {
  static constexpr int kCount = 32;  // orders: more than any shape has amplitudes
  LegendreFactors() {
    for (int j = 0; j < kCount; ++j) {
      root[j] = std::sqrt(2.0 * j + 1.0);
      by_now[j] = (2.0 * j + 1.0) / (j + 1.0);
      by_before[j] = j / (j + 1.0);
    }
  }
  std::array<double, kCount> root, by_now, by_before;
};
inline const LegendreFactors kLegendre;

struct Span {
  double low = 0.0, high = 1.0;  // mm, rad or s
  bool is_turn = false;          // a full turn: low and high have no meaning

  // -1 to 1 over the span.
  double Within(double q) const { return (2.0 * q - low - high) / (high - low); }
  // The share of the functions that is left at q.
  double KeptAt(double q) const {
    if (is_turn) return 1.0;
    const double beyond = (std::abs(Within(q)) - 1.0) / kFade;
    return beyond > 0.0 ? std::exp(-beyond * beyond) : 1.0;
  }
  // The order (n or j) of function i of those from order `first` on (of a turn: from n = 1).
  int OrderOf(int i, int first) const { return is_turn ? i / 2 + 1 : first + i; }
  // values[0 .. count): without what KeptAt() takes off.
  void Values(double q, int first, int count, double* values) const {
    if (is_turn) {
      const double c1 = std::cos(q), s1 = std::sin(q);
      double c = std::sqrt(2.0), s = 0.0;
      for (int i = 0; i < count; i += 2) {
        const double next = c * c1 - s * s1;
        s = c * s1 + s * c1;
        c = next;
        values[i] = c;
        if (i + 1 < count) values[i + 1] = s;
      }
      return;
    }
    const double x = std::clamp(Within(q), -1.0, 1.0);
    double before = 0.0, now = 1.0;  // P_(j - 1), P_j
    for (int j = 0; j < first + count; ++j) {
      if (j >= first) values[j - first] = kLegendre.root[j] * now;
      const double next = kLegendre.by_now[j] * x * now - kLegendre.by_before[j] * before;
      before = now;
      now = next;
    }
  }
  bool operator==(const Span&) const = default;
};

// Prior variance of a function by its order, up to a factor: a curve is smooth on the whole, and may have detail.
inline double SpectrumOf(int order) {
  constexpr double kSmooth = 3.0;  // orders up to which all are alike
  return 1.0 / (1.0 + (order / kSmooth) * (order / kSmooth));
}

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_SPAN_H_
