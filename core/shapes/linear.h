// Linear in an axis' position q: error = a q / reference. Scale error, or an angle that grows along an axis.
#ifndef AXISCAL_CORE_SHAPES_LINEAR_H_
#define AXISCAL_CORE_SHAPES_LINEAR_H_

#include "core/shapes/state.h"

namespace axiscal::shapes {

struct Linear {
  static constexpr char kName[] = "linear";
  static constexpr int kBasisCount = 1;
  static constexpr int kNonlinearCount = 0;
  static constexpr double kReferenceMm = 1000.0;  // amplitude per metre ...
  static constexpr double kReferenceRad = 1.0;    // ... or per radian

  int axis = 0;
  double reference = kReferenceMm;

  template <typename T>
  void Basis(const State& state, const T*, T* basis) const {
    basis[0] = T(state.axes[axis].position / reference);
  }
  bool operator==(const Linear&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_LINEAR_H_
