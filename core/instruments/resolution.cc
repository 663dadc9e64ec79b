#include "core/instruments/resolution.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace axiscal::instruments {
namespace {

// Euclid's algorithm with the nearest multiple; a rest below `same` counts as zero.
double CommonStep(double a, double b, double same) {
  while (b > same) {
    const double rest = std::abs(std::remainder(a, b));
    a = b;
    b = rest;
  }
  return a;
}

// The largest step of which all differences between readings of the column are multiples. 0 where it is below
// `finest_mm`, or may be chance: with fewer than five different values, unless each of them came five times.
double StepOf(const MeasuringRun& run, int row, double finest_mm) {
  constexpr int kFewest = 10, kMostLookedAt = 2000;       // readings
  constexpr double kOfFinest = 1e-3, kOfLargest = 1e-14;  // what decimals and differences of doubles are off by
  constexpr size_t kDifferent = 5, kOften = 5;
  if (run.reading_count() < kFewest) return 0.0;
  const int count = std::min(run.reading_count(), kMostLookedAt);
  const double same = std::max(kOfFinest * finest_mm, kOfLargest * run.measured_mm.row(row).cwiseAbs().maxCoeff());
  std::vector<double> different;
  double step = 0.0, last_mm = run.measured_mm(row, 0);
  for (int k = 0; k < count; ++k) {
    const double reading_mm = run.measured_mm(row, static_cast<Eigen::Index>(k) * run.reading_count() / count);
    step = CommonStep(std::abs(reading_mm - last_mm), step, same);
    if (step > same && step < finest_mm) return 0.0;
    last_mm = reading_mm;
    if (different.size() < kDifferent && std::find(different.begin(), different.end(), reading_mm) == different.end())
      different.push_back(reading_mm);
  }
  const bool is_told = different.size() >= kDifferent || kOften * different.size() <= static_cast<size_t>(count);
  return is_told ? step : 0.0;
}

}  // namespace

double ResolutionOf(const MeasuringRun& run, int row) {
  constexpr double kOfNoInterest = 0.01;  // of sigma
  return StepOf(run, row, kOfNoInterest * run.sigma_mm);
}

double CoarseResolutionOf(const MeasuringRun& run) {
  double coarsest = 0.0;
  for (int row = 0; row < run.row_count; ++row) coarsest = std::max(coarsest, StepOf(run, row, kCoarse * run.sigma_mm));
  return coarsest;
}

double RoundingSigma(const MeasuringRun& run) { return CoarseResolutionOf(run) / std::sqrt(12.0); }

double SigmaWithRounding(const MeasuringRun& run) { return std::hypot(run.sigma_mm, RoundingSigma(run)); }

}  // namespace axiscal::instruments
