// How far the axis came from point to point: error = a s (1 - exp(-|m| / length)), m the last move of the axis, s its
// sense. A long move leaves a, a short one a part of it: a carriage that creeps into its position.
#ifndef AXISCAL_CORE_SHAPES_LAST_MOVE_H_
#define AXISCAL_CORE_SHAPES_LAST_MOVE_H_

#include <cmath>

#include "core/shapes/state.h"

namespace axiscal::shapes {

struct LastMove {
  static constexpr char kName[] = "last-move";
  static constexpr int kBasisCount = 1;
  static constexpr int kNonlinearCount = 1;

  int axis = 0;
  double length = 10.0;  // mm or rad: the shape's non-linear parameter

  // Where no move is known it was a long one.
  template <typename T>
  void Basis(const State& state, const T* full, T* basis) const {
    using std::exp;
    const AxisState& of_axis = state.axes[axis];
    basis[0] = of_axis.last_move == 0.0
                   ? T(of_axis.sense)
                   : std::copysign(1.0, of_axis.last_move) * (1.0 - exp(-std::abs(of_axis.last_move) / *full));
  }
  bool operator==(const LastMove&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_LAST_MOVE_H_
