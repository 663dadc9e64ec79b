// Free curves: error = sum of a_i phi_i, phi_i the functions of span.h.
//   Curve      over the position of an axis
//   TimeCurve  over the time, with `times` also times the position of an axis. Outside its time it is not known at all:
//              zero, and its prior.
//   BacklashCurve  over the position of an axis, times the sense of its motion: a screw or worm that is worn more here
//              than there. Half of the lost motion beyond its mean, which is `Backlash`.
//   Crossed    over the positions of two axes: sum of a_ij phi_i(q) psi_j(r), phi_0 = psi_0 = 1, without a_00
// Over an open span from P_1 on: the mean is another error. The line belongs to a curve: named apart from it, it was
// taken for the squareness of another axis.
// Their amplitudes have a prior (machine::ErrorTerm::prior_sigma): what was not measured stays near zero. With prior
// covariance s^2 times the spectrum this is a Gaussian process of reduced rank (Solin and Saerkkae 2020); polynomials
// in place of sines, as they are orthogonal to the mean.
#ifndef AXISCAL_CORE_SHAPES_CURVE_H_
#define AXISCAL_CORE_SHAPES_CURVE_H_

#include <array>

#include "core/shapes/span.h"
#include "core/shapes/state.h"
#include "core/shapes/times.h"

namespace axiscal::shapes {

struct Curve {
  static constexpr char kName[] = "curve";
  static constexpr int kNonlinearCount = 0;
  static constexpr int kFirst = 1;  // order over an open span

  int axis = 0;
  Span span;
  int functions = 16;

  double PriorShare(int i) const { return SpectrumOf(span.OrderOf(i, kFirst)); }
  double KeptAt(const State& state) const { return span.KeptAt(state.axes[axis].position); }
  template <typename T>
  void Basis(const State& state, const T*, T* basis) const {
    std::array<double, kMaxBasisCount> values;
    const double q = state.axes[axis].position, kept = span.KeptAt(q);
    span.Values(q, kFirst, functions, values.data());
    for (int i = 0; i < functions; ++i) basis[i] = T(kept * values[i]);
  }
  bool operator==(const Curve&) const = default;
};

struct BacklashCurve : Curve {
  static constexpr char kName[] = "backlash-curve";

  template <typename T>
  void Basis(const State& state, const T* none, T* basis) const {
    Curve::Basis(state, none, basis);
    for (int i = 0; i < functions; ++i) basis[i] *= state.axes[axis].sense;
  }
  bool operator==(const BacklashCurve&) const = default;
};

struct TimeCurve {
  static constexpr char kName[] = "time-curve";
  static constexpr int kNonlinearCount = 0;
  static constexpr int kFirst = 1;

  Span span;  // s, open
  int functions = 16;
  Times times = {};

  double PriorShare(int i) const { return SpectrumOf(span.OrderOf(i, kFirst)); }
  double KeptAt(const State& state) const { return state.time_s >= span.low && state.time_s <= span.high ? 1.0 : 0.0; }
  template <typename T>
  void Basis(const State& state, const T*, T* basis) const {
    std::array<double, kMaxBasisCount> values;
    const double factor = KeptAt(state) * times.FactorAt(state);
    span.Values(state.time_s, kFirst, functions, values.data());
    for (int i = 0; i < functions; ++i) basis[i] = T(factor * values[i]);
  }
  bool operator==(const TimeCurve&) const = default;
};

struct Crossed {
  static constexpr char kName[] = "crossed";
  static constexpr int kNonlinearCount = 0;
  static constexpr int kFirst = 1;
  static constexpr int kMostEach = 6;  // six orders of a line, three of a turn

  int axis = 0, second_axis = 0;
  Span span, second;
  int each = kMostEach;  // functions of each axis, beside the constant
  // Whether the products of one function and the constant, which vary with one axis alone, are among the amplitudes.
  // What bends under a body that travels does so about some place of it, which nobody knows.
  bool has_singles = true;

  int Count() const { return has_singles ? (each + 1) * (each + 1) - 1 : each * each; }
  // Function of each axis in product i, the second axis' running fastest; -1: the constant.
  int OfFirst(int i) const { return has_singles ? (i + 1) / (each + 1) - 1 : i / each; }
  int OfSecond(int i) const { return has_singles ? (i + 1) % (each + 1) - 1 : i % each; }

  double PriorShare(int i) const { return ShareOf(span, OfFirst(i)) * ShareOf(second, OfSecond(i)); }
  double KeptAt(const State& state) const {
    return span.KeptAt(state.axes[axis].position) * second.KeptAt(state.axes[second_axis].position);
  }
  template <typename T>
  void Basis(const State& state, const T*, T* basis) const {
    std::array<double, kMostEach + 1> first, other;
    first[0] = other[0] = 1.0;
    span.Values(state.axes[axis].position, kFirst, each, &first[1]);
    second.Values(state.axes[second_axis].position, kFirst, each, &other[1]);
    const double kept = KeptAt(state);
    for (int i = 0; i < Count(); ++i) basis[i] = T(kept * first[OfFirst(i) + 1] * other[OfSecond(i) + 1]);
  }
  bool operator==(const Crossed&) const = default;

 private:
  static double ShareOf(const Span& of, int function) {
    return function < 0 ? 1.0 : SpectrumOf(of.OrderOf(function, kFirst));
  }
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_CURVE_H_
