// Whether a measured error keeps its tolerance, as far as its uncertainty lets one say.
#ifndef AXISCAL_SERVER_INPUTS_TOLERANCE_H_
#define AXISCAL_SERVER_INPUTS_TOLERANCE_H_

#include <algorithm>
#include <cmath>

#include "core/records/calibration.h"
#include "core/records/drift.h"

namespace axiscal::inputs {

// An error is out of its tolerance when its measurement leaves at most one chance in twenty that it is inside, and
// inside when it leaves at most one in twenty that it is outside: proven at 95 %, as ISO 14253-1 asks (assumed, the
// standard was not at hand).
inline constexpr double kProvenOutside = 0.95, kProvenInside = 0.05;

// 0 to 1, of an error with a value and a sigma, for normal noise.
inline double ProbabilityOutside(const records::DriftLimit& limit, const records::Estimate& estimate) {
  const auto normal_cdf = [](double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); };
  const double value = *estimate.value, sigma = std::max(*estimate.sigma, 1e-9);
  return normal_cdf((limit.low - value) / sigma) + normal_cdf((value - limit.high) / sigma);
}

}  // namespace axiscal::inputs

#endif  // AXISCAL_SERVER_INPUTS_TOLERANCE_H_
