// Thermal: error = a (T - 20 degrees C), T the temperature stated with the reading.
#ifndef AXISCAL_CORE_SHAPES_THERMAL_H_
#define AXISCAL_CORE_SHAPES_THERMAL_H_

#include "core/shapes/state.h"

namespace axiscal::shapes {

struct Thermal {
  static constexpr char kName[] = "thermal";
  static constexpr int kBasisCount = 1;
  static constexpr int kNonlinearCount = 0;

  template <typename T>
  void Basis(const State& state, const T*, T* basis) const {
    basis[0] = T(state.temperature_celsius - kReferenceTemperatureCelsius);
  }
  bool operator==(const Thermal&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_THERMAL_H_
