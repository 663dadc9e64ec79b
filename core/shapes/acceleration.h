// Following error of second order: error = a times the acceleration of an axis. What a servo with speed feed-forward
// leaves, and a mass that gives way.
#ifndef AXISCAL_CORE_SHAPES_ACCELERATION_H_
#define AXISCAL_CORE_SHAPES_ACCELERATION_H_

#include "core/shapes/state.h"

namespace axiscal::shapes {

struct Acceleration {
  static constexpr char kName[] = "acceleration";
  static constexpr int kBasisCount = 1;
  static constexpr int kNonlinearCount = 0;

  int axis = 0;  // amplitude per mm/s^2 or rad/s^2 of this axis

  template <typename T>
  void Basis(const State& state, const T*, T* basis) const {
    basis[0] = T(state.axes[axis].acceleration);
  }
  bool operator==(const Acceleration&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_ACCELERATION_H_
