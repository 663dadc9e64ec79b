// Constant: a location error or squareness, error = a.
#ifndef AXISCAL_CORE_SHAPES_CONSTANT_H_
#define AXISCAL_CORE_SHAPES_CONSTANT_H_

#include "core/shapes/state.h"

namespace axiscal::shapes {

struct Constant {
  static constexpr char kName[] = "constant";
  static constexpr int kBasisCount = 1;
  static constexpr int kNonlinearCount = 0;

  template <typename T>
  void Basis(const State&, const T*, T* basis) const {
    basis[0] = T(1.0);
  }
  bool operator==(const Constant&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_CONSTANT_H_
