// Reversal spike: error = a sense exp(-d / length), d the travel since the last reversal. Stick-slip and late friction
// compensation.
#ifndef AXISCAL_CORE_SHAPES_REVERSAL_H_
#define AXISCAL_CORE_SHAPES_REVERSAL_H_

#include <cmath>

#include "core/shapes/state.h"

namespace axiscal::shapes {

struct Reversal {
  static constexpr char kName[] = "reversal";
  static constexpr int kBasisCount = 1;
  static constexpr int kNonlinearCount = 1;

  int axis = 0;
  double length = 5.0;  // decay length, mm or rad: the shape's non-linear parameter

  template <typename T>
  void Basis(const State& state, const T* decay_length, T* basis) const {
    using std::exp;
    const AxisState& axis_state = state.axes[axis];
    if (!std::isfinite(axis_state.travel_since_reversal)) {
      basis[0] = T(0.0);
      return;
    }
    basis[0] = axis_state.sense * exp(-axis_state.travel_since_reversal / *decay_length);
  }
  bool operator==(const Reversal&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_REVERSAL_H_
