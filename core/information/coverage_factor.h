// Half-width of a 95 % interval in standard uncertainties.
#ifndef AXISCAL_CORE_INFORMATION_COVERAGE_FACTOR_H_
#define AXISCAL_CORE_INFORMATION_COVERAGE_FACTOR_H_

namespace axiscal::information {

// Of Student's t where the scale of the uncertainties was estimated from `degrees_of_freedom` readings (JCGM 100:2008,
// G.3), else of the normal distribution.
double CoverageFactor(bool is_estimated, int degrees_of_freedom);

}  // namespace axiscal::information

#endif  // AXISCAL_CORE_INFORMATION_COVERAGE_FACTOR_H_
