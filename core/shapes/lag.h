// Lag: error = a times the speed of an axis. A servo's following error that differs between axes.
#ifndef AXISCAL_CORE_SHAPES_LAG_H_
#define AXISCAL_CORE_SHAPES_LAG_H_

#include "core/shapes/state.h"

namespace axiscal::shapes {

struct Lag {
  static constexpr char kName[] = "lag";
  static constexpr int kBasisCount = 1;
  static constexpr int kNonlinearCount = 0;

  int axis = 0;  // amplitude per mm/s or rad/s of this axis

  template <typename T>
  void Basis(const State& state, const T*, T* basis) const {
    basis[0] = T(state.axes[axis].speed);
  }
  bool operator==(const Lag&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_LAG_H_
