#include "core/shapes/shape.h"

#include <ceres/jet.h>

namespace axiscal::shapes {
namespace {

template <typename S>
double* Nonlinear(S& shape) {
  if constexpr (requires { shape.tau_s; }) return &shape.tau_s;
  if constexpr (requires { shape.length; }) return &shape.length;
  if constexpr (requires { shape.is_frequency_free; }) return shape.is_frequency_free ? &shape.frequency : nullptr;
  return nullptr;
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
  const double* nonlinear = NonlinearParameter(shape);
  std::visit([&](const auto& s) { s.template Basis<double>(state, nonlinear, basis); }, shape);
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
