// Drift, linear in time: error = a t / 1 h.
#ifndef AXISCAL_CORE_SHAPES_DRIFT_H_
#define AXISCAL_CORE_SHAPES_DRIFT_H_

#include "core/shapes/state.h"

namespace axiscal::shapes {

struct Drift {
  static constexpr char kName[] = "drift";
  static constexpr int kBasisCount = 1;
  static constexpr int kNonlinearCount = 0;
  static constexpr double kReferenceS = 3600.0;  // amplitude per hour

  template <typename T>
  void Basis(const State& state, const T*, T* basis) const {
    basis[0] = T(state.time_s / kReferenceS);
  }
  bool operator==(const Drift&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_DRIFT_H_
