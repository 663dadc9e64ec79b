#include "core/shapes/shape.h"

#include <ceres/jet.h>

#include <cmath>
#include <type_traits>

namespace axiscal::shapes {
namespace {

// To a double of the shape's own constness.
template <typename S>
auto* Nonlinear(S& shape) {
  using Double = std::conditional_t<std::is_const_v<S>, const double, double>;
  if constexpr (std::is_same_v<std::remove_const_t<S>, ThermalLag>) {
    return shape.tau_s > 0.0 ? &shape.tau_s : nullptr;
  } else if constexpr (requires { shape.tau_s; }) {
    return &shape.tau_s;
  }
  if constexpr (requires { shape.length; }) return &shape.length;
  if constexpr (requires { shape.is_frequency_free; }) return shape.is_frequency_free ? &shape.frequency : nullptr;
  return static_cast<Double*>(nullptr);
}

}  // namespace

std::string Name(const Shape& shape) {
  return std::visit([](const auto& s) { return std::string(s.kName); }, shape);
}

int BasisCount(const Shape& shape) {
  return std::visit(
      [](const auto& s) {
        if constexpr (requires { s.functions; }) return s.functions;
        if constexpr (requires { s.each; }) return s.Count();
        if constexpr (requires { s.kBasisCount; }) return s.kBasisCount;
      },
      shape);
}

bool IsFree(const Shape& shape) {
  return std::visit(
      [](const auto& s) {
        return requires { s.PriorShare(0); };
      },
      shape);
}

double PriorRoot(const Shape& shape, int basis) {
  return std::visit(
      [&](const auto& s) {
        if constexpr (requires { s.PriorShare(0); }) {
          double sum = 0.0;
          for (int i = 0; i < BasisCount(shape); ++i) sum += s.PriorShare(i);
          return std::sqrt(s.PriorShare(basis) / sum);
        }
        return 1.0;
      },
      shape);
}

Curve* CurveOf(Shape& shape) {
  if (auto* curve = std::get_if<Curve>(&shape)) return curve;
  return std::get_if<BacklashCurve>(&shape);
}

const Curve* CurveOf(const Shape& shape) { return CurveOf(const_cast<Shape&>(shape)); }

bool IsBeginningOf(const Shape& coarse, const Shape& fine) {
  const Curve *const a = CurveOf(coarse), *const b = CurveOf(fine);
  return coarse.index() == fine.index() && a != nullptr && a->axis == b->axis && a->span == b->span &&
         a->functions <= b->functions;
}

Times* TimesOf(Shape& shape) {
  return std::visit(
      [](auto& s) -> Times* {
        if constexpr (requires { s.times; }) return &s.times;
        return nullptr;
      },
      shape);
}

const Times* TimesOf(const Shape& shape) { return TimesOf(const_cast<Shape&>(shape)); }

double FactorAt(const Shape& shape, const State& state) {
  const Times* times = TimesOf(shape);
  return times == nullptr ? 1.0 : times->FactorAt(state);
}

double KeptAt(const Shape& shape, const State& state) {
  return std::visit(
      [&](const auto& s) {
        if constexpr (requires { s.KeptAt(state); }) return s.KeptAt(state);
        return 1.0;
      },
      shape);
}

std::optional<int> VariableAxis(const Shape& shape) {
  return std::visit(
      [](const auto& s) -> std::optional<int> {
        if constexpr (requires { s.axis; }) return s.axis;
        if constexpr (requires { s.times; }) {
          if (s.times.axis >= 0) return s.times.axis;
        }
        return std::nullopt;
      },
      shape);
}

std::optional<int> SecondAxis(const Shape& shape) {
  const auto* map = std::get_if<Tabulated>(&shape);
  if (map != nullptr && map->second_axis >= 0) return map->second_axis;
  const auto* crossed = std::get_if<Crossed>(&shape);
  if (crossed != nullptr) return crossed->second_axis;
  return std::nullopt;
}

double* NonlinearParameter(Shape& shape) {
  return std::visit([](auto& s) { return Nonlinear(s); }, shape);
}

const double* NonlinearParameter(const Shape& shape) { return NonlinearParameter(const_cast<Shape&>(shape)); }

bool HasLength(const Shape& shape) {
  return std::visit(
      [](const auto& s) {
        return requires { s.length; };
      },
      shape);
}

void Basis(const Shape& shape, const State& state, double* basis) {
  std::visit([&](const auto& s) { s.template Basis<double>(state, Nonlinear(s), basis); }, shape);
}

void BasisSlope(const Shape& shape, const State& state, double* slope) {
  using Jet = ceres::Jet<double, 1>;
  const double* nonlinear = NonlinearParameter(shape);
  const Jet parameter = nonlinear ? Jet(*nonlinear, 0) : Jet(0.0);
  Jet basis[kMaxBasisCount];
  std::visit([&](const auto& s) { s.template Basis<Jet>(state, &parameter, basis); }, shape);
  for (int i = 0; i < BasisCount(shape); ++i) slope[i] = basis[i].v[0];
}

}  // namespace axiscal::shapes
