#include "core/information/coverage_factor.h"

#include <boost/math/distributions/students_t.hpp>

namespace axiscal::information {

double CoverageFactor(bool is_estimated, int degrees_of_freedom) {
  constexpr double kNormal = 1.959964, kUpper = 0.975;
  if (!is_estimated || degrees_of_freedom < 1) return kNormal;
  return boost::math::quantile(boost::math::students_t(static_cast<double>(degrees_of_freedom)), kUpper);
}

}  // namespace axiscal::information
