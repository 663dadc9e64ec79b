// Warming up: error = a (1 - exp(-t / tau)), zero at the clock's zero and a when settled; with `times` also times the
// position of an axis.
#ifndef AXISCAL_CORE_SHAPES_DRIFT_EXP_H_
#define AXISCAL_CORE_SHAPES_DRIFT_EXP_H_

#include <cmath>

#include "core/shapes/state.h"
#include "core/shapes/times.h"

namespace axiscal::shapes {

struct DriftExp {
  static constexpr char kName[] = "drift-exp";
  static constexpr int kBasisCount = 1;
  static constexpr int kNonlinearCount = 1;

  double tau_s = 1800.0;  // time constant: the shape's non-linear parameter
  Times times = {};

  template <typename T>
  void Basis(const State& state, const T* tau, T* basis) const {
    using std::exp;
    basis[0] = times.FactorAt(state) * (1.0 - exp(-state.time_s / *tau));
  }
  bool operator==(const DriftExp&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_DRIFT_EXP_H_
