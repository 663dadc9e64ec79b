// Quadratic in an axis' position q: error = a (q / reference)^2. Bow of a guideway, sag.
#ifndef AXISCAL_CORE_SHAPES_QUADRATIC_H_
#define AXISCAL_CORE_SHAPES_QUADRATIC_H_

#include "core/shapes/state.h"

namespace axiscal::shapes {

struct Quadratic {
  static constexpr char kName[] = "quadratic";
  static constexpr int kBasisCount = 1;
  static constexpr int kNonlinearCount = 0;
  static constexpr double kReferenceMm = 250.0;  // amplitude is the error 250 mm (or 1 rad) from zero
  static constexpr double kReferenceRad = 1.0;

  int axis = 0;
  double reference = kReferenceMm;

  template <typename T>
  void Basis(const State& state, const T*, T* basis) const {
    const double ratio = state.axes[axis].position / reference;
    basis[0] = T(ratio * ratio);
  }
  bool operator==(const Quadratic&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_QUADRATIC_H_
