// Local defect: error = a exp(-((q - at) / width)^2). An empirical curve and no physical effect: it stands for a
// guideway that is worn or chipped in one place. The loop reports it under `unexplained` with its axis and range
// (docs/loop.md, "Steps", 6).
#ifndef AXISCAL_CORE_SHAPES_BUMP_H_
#define AXISCAL_CORE_SHAPES_BUMP_H_

#include <cmath>

#include "core/shapes/state.h"

namespace axiscal::shapes {

struct Bump {
  static constexpr char kName[] = "empirical";
  static constexpr int kBasisCount = 1;
  static constexpr int kNonlinearCount = 0;

  int axis = 0;
  double at = 0.0;     // mm or rad
  double width = 1.0;  // mm or rad

  template <typename T>
  void Basis(const State& state, const T*, T* basis) const {
    const double distance = (state.axes[axis].position - at) / width;
    basis[0] = T(std::exp(-distance * distance));
  }
  bool operator==(const Bump&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_BUMP_H_
