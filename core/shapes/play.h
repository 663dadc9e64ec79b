// An element of friction (play operator of Prandtl and Ishlinskii): error = a (q - p) / r. p follows the position q as
// soon as it is r away, p = min(max(p, q - r), q + r), and stands still between: after a reversal the error goes over
// from -a to a along a way of 2 r, and comes back the same way where the axis turns before that. Several elements of
// different r make friction and wind-up as they are.
#ifndef AXISCAL_CORE_SHAPES_PLAY_H_
#define AXISCAL_CORE_SHAPES_PLAY_H_

#include <cmath>

#include "core/shapes/state.h"

namespace axiscal::shapes {

struct Play {
  static constexpr char kName[] = "play";
  static constexpr int kBasisCount = 1;
  static constexpr int kNonlinearCount = 1;

  int axis = 0;
  double length = 1.0;  // r, mm or rad: the shape's non-linear parameter

  // An axis that has not turned came from far: a times its sense.
  template <typename T>
  void Basis(const State& state, const T* r, T* basis) const {
    const AxisState& of_axis = state.axes[axis];
    int turns = 0;
    while (turns < kTurns && std::isfinite(of_axis.turned_at[turns])) ++turns;
    if (turns == 0) {
      basis[0] = T(of_axis.sense);
      return;
    }
    const auto follow = [&](T p, double q) {
      const T lowest = q - *r, highest = q + *r;
      return p < lowest ? lowest : p > highest ? highest : p;
    };
    // The farthest turn was come to from far, in the sense of now or in the other one.
    const double sense = turns % 2 == 0 ? of_axis.sense : -of_axis.sense;
    T p = of_axis.turned_at[turns - 1] - sense * *r;
    for (int i = turns - 2; i >= 0; --i) p = follow(p, of_axis.turned_at[i]);
    basis[0] = (of_axis.position - follow(p, of_axis.position)) / *r;
  }
  bool operator==(const Play&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_PLAY_H_
