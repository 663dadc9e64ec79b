// The distribution function of Student's t.
#ifndef AXISCAL_CORE_DRIFT_STUDENT_H_
#define AXISCAL_CORE_DRIFT_STUDENT_H_

#include <cmath>
#include <numbers>

namespace axiscal::drift {

// The share of a Student distribution below t, by the normal distribution (Wallace 1959); for 12 degrees of freedom and
// more it is right to 0.0001.
inline double StudentBelow(double t, double freedom) {
  const double z = (8.0 * freedom + 1.0) / (8.0 * freedom + 3.0) * std::sqrt(freedom * std::log1p(t * t / freedom));
  return 0.5 * std::erfc(t < 0.0 ? z / std::numbers::sqrt2 : -z / std::numbers::sqrt2);
}

}  // namespace axiscal::drift

#endif  // AXISCAL_CORE_DRIFT_STUDENT_H_
