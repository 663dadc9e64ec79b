// Pre-travel of a touch probe: how far it moves on between contact and trigger, as a function of the direction of
// approach. The error lies along the approach, so these shapes belong to no single component of a joint: the tool
// point's error is - value * approach (spindle frame), and zero where nothing is touched.
//   pre-travel   value = a                                  the same in every direction
//   lobe         value = sin t (a cos(k f) + b sin(k f))    t: angle between approach and stylus, f: azimuth about it
// Three contacts under the stylus make k = 3; k = 1 looks like a stylus that is mounted off centre (EX0T, EY0T).
#ifndef AXISCAL_CORE_SHAPES_LOBE_H_
#define AXISCAL_CORE_SHAPES_LOBE_H_

#include <cmath>

#include "core/shapes/state.h"

namespace axiscal::shapes {

struct PreTravel {
  static constexpr char kName[] = "pre-travel";
  static constexpr int kBasisCount = 1;
  static constexpr int kNonlinearCount = 0;

  template <typename T>
  void Basis(const State& state, const T*, T* basis) const {
    basis[0] = T(state.approach.is_touch ? 1.0 : 0.0);
  }
  bool operator==(const PreTravel&) const = default;
};

struct Lobe {
  static constexpr char kName[] = "lobe";
  static constexpr int kBasisCount = 2;
  static constexpr int kNonlinearCount = 0;

  int order = 3;

  template <typename T>
  void Basis(const State& state, const T*, T* basis) const {
    const double across = state.approach.is_touch ? state.approach.across : 0.0;
    basis[0] = T(across * std::cos(order * state.approach.azimuth_rad));
    basis[1] = T(across * std::sin(order * state.approach.azimuth_rad));
  }
  bool operator==(const Lobe&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_LOBE_H_
