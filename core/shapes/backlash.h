// Backlash: error = a/2 times the sense of motion; the amplitude a is peak to peak (docs/formats.md, "Loop report").
// ISO 230-1: reversal error.
#ifndef AXISCAL_CORE_SHAPES_BACKLASH_H_
#define AXISCAL_CORE_SHAPES_BACKLASH_H_

#include "core/shapes/state.h"

namespace axiscal::shapes {

struct Backlash {
  static constexpr char kName[] = "backlash";
  static constexpr int kBasisCount = 1;
  static constexpr int kNonlinearCount = 0;

  int axis = 0;

  template <typename T>
  void Basis(const State& state, const T*, T* basis) const {
    basis[0] = T(0.5 * state.axes[axis].sense);
  }
  bool operator==(const Backlash&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_BACKLASH_H_
