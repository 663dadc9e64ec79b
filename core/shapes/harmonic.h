// Periodic in an axis' position q: error = a cos(w q) + b sin(w q) = amplitude cos(w q - phase). Eccentricity and tilt
// (order 1, 2), worm and strain-wave gears (tens to hundreds per turn), the pitch of a ball screw.
#ifndef AXISCAL_CORE_SHAPES_HARMONIC_H_
#define AXISCAL_CORE_SHAPES_HARMONIC_H_

#include <cmath>

#include "core/shapes/state.h"

namespace axiscal::shapes {

struct Harmonic {
  static constexpr char kName[] = "harmonic";
  static constexpr int kBasisCount = 2;
  static constexpr int kNonlinearCount = 0;

  int axis = 0;
  double frequency =
      1.0;  // w: order per turn (rad per rad) of a rotary axis, 2 pi / period (rad per mm) of a linear one

  // True where the frequency is fitted too (a pitch whose period nobody states): it is the shape's non-linear parameter
  // then.
  bool is_frequency_free = false;

  template <typename T>
  void Basis(const State& state, const T* fitted_frequency, T* basis) const {
    using std::cos;
    using std::sin;
    if (!is_frequency_free) {
      const double angle_rad = frequency * state.axes[axis].position;
      basis[0] = T(std::cos(angle_rad));
      basis[1] = T(std::sin(angle_rad));
      return;
    }
    const T angle_rad = *fitted_frequency * state.axes[axis].position;
    basis[0] = cos(angle_rad);
    basis[1] = sin(angle_rad);
  }
  bool operator==(const Harmonic&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_HARMONIC_H_
