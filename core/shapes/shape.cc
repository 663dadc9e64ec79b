#include "core/shapes/shape.h"

#include <ceres/jet.h>

#include <type_traits>

namespace axiscal::shapes {
namespace {

// To a double of the shape's own constness.
template <typename S>
auto* Nonlinear(S& shape) {
  using Double = std::conditional_t<std::is_const_v<S>, const double, double>;
  if constexpr (requires { shape.tau_s; }) return &shape.tau_s;
  if constexpr (requires { shape.length; }) return &shape.length;
  if constexpr (requires { shape.is_frequency_free; }) return shape.is_frequency_free ? &shape.frequency : nullptr;
  return static_cast<Double*>(nullptr);
}

}  // namespace

std::string Name(const Shape& shape) {
  return std::visit([](const auto& s) { return std::string(s.kName); }, shape);
}

int BasisCount(const Shape& shape) {
  return std::visit([](const auto& s) { return s.kBasisCount; }, shape);
}

std::optional<int> VariableAxis(const Shape& shape) {
  return std::visit(
      [](const auto& s) -> std::optional<int> {
        if constexpr (requires { s.axis; }) return s.axis;
        return std::nullopt;
      },
      shape);
}

double* NonlinearParameter(Shape& shape) {
  return std::visit([](auto& s) { return Nonlinear(s); }, shape);
}

const double* NonlinearParameter(const Shape& shape) { return NonlinearParameter(const_cast<Shape&>(shape)); }

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
