// Late warmth: error = a (F - 20 degrees C), F the temperature that a body takes on with a first-order lag behind a
// recorded channel (temperatures.h); with `times` also times the position of an axis: a scale that heats up. F beyond
// what the readings saw counts as the nearest that they saw (`from_celsius`, `to_celsius`).
#ifndef AXISCAL_CORE_SHAPES_THERMAL_LAG_H_
#define AXISCAL_CORE_SHAPES_THERMAL_LAG_H_

#include <algorithm>
#include <limits>
#include <string>
#include <type_traits>

#include "core/shapes/state.h"
#include "core/shapes/temperatures.h"
#include "core/shapes/times.h"

namespace axiscal::shapes {

struct ThermalLag {
  static constexpr char kName[] = "thermal-lag";
  static constexpr int kBasisCount = 1;
  static constexpr int kNonlinearCount = 1;

  std::string channel = kTemperatureChannel;
  double tau_s = 600.0;  // time constant: the shape's non-linear parameter; 0: at once, and it is none
  Times times = {};
  double from_celsius = -std::numeric_limits<double>::infinity();
  double to_celsius = std::numeric_limits<double>::infinity();

  // F at a state, deg C. A state without a history is one that has lasted: F = T.
  Temperatures::Late LateAt(const State& state, double tau) const {
    const Temperatures::Channel* found = state.temperatures == nullptr ? nullptr : state.temperatures->Find(channel);
    if (found != nullptr) return state.temperatures->At(*found, tau, state.moment);
    return {channel == kTemperatureChannel ? state.temperature_celsius : kReferenceTemperatureCelsius, 0.0};
  }
  // Kelvin by which F is beyond what the readings saw.
  double BeyondSeen(const State& state) const {
    const double late = LateAt(state, tau_s).celsius;
    return std::max({0.0, from_celsius - late, late - to_celsius});
  }

  template <typename T>
  void Basis(const State& state, const T* tau, T* basis) const {
    const double factor = times.FactorAt(state);
    const Temperatures::Late late = LateAt(state, tau_s);
    const double seen = std::clamp(late.celsius, from_celsius, to_celsius);
    basis[0] = T(factor * (seen - kReferenceTemperatureCelsius));
    // The value is that at tau_s, which `tau` holds; of a derivative the slope is added.
    if constexpr (!std::is_same_v<T, double>) {
      if (tau_s > 0.0 && seen == late.celsius) basis[0] += (*tau - tau_s) * (factor * late.per_s);
    }
  }
  bool operator==(const ThermalLag&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_THERMAL_LAG_H_
