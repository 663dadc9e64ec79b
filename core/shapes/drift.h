// Drift, linear in time: error = a t / 1 h. A time beyond what the readings saw counts as the nearest that they saw
// (`from_s`, `to_s`): no machine drifts on for ever.
#ifndef AXISCAL_CORE_SHAPES_DRIFT_H_
#define AXISCAL_CORE_SHAPES_DRIFT_H_

#include <algorithm>
#include <limits>

#include "core/shapes/state.h"

namespace axiscal::shapes {

struct Drift {
  static constexpr char kName[] = "drift";
  static constexpr int kBasisCount = 1;
  static constexpr int kNonlinearCount = 0;
  static constexpr double kReferenceS = 3600.0;  // amplitude per hour

  double from_s = -std::numeric_limits<double>::infinity();
  double to_s = std::numeric_limits<double>::infinity();

  // Seconds by which a moment is beyond what the readings saw.
  double BeyondSeen(const State& state) const { return std::max({0.0, from_s - state.time_s, state.time_s - to_s}); }

  template <typename T>
  void Basis(const State& state, const T*, T* basis) const {
    basis[0] = T(std::clamp(state.time_s, from_s, to_s) / kReferenceS);
  }
  bool operator==(const Drift&) const = default;
};

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_DRIFT_H_
