#include "core/identify/outliers.h"

#include <algorithm>
#include <cmath>

namespace axiscal::identify {

double Median(std::vector<double>* values) {
  if (values->empty()) return 0.0;
  const size_t middle = values->size() / 2;
  constexpr size_t kSmall = 16;  // a running median's window: insertion beats selection
  if (values->size() <= kSmall) {
    for (size_t i = 1; i < values->size(); ++i) {
      const double value = (*values)[i];
      size_t at = i;
      for (; at > 0 && (*values)[at - 1] > value; --at) (*values)[at] = (*values)[at - 1];
      (*values)[at] = value;
    }
    return values->size() % 2 == 1 ? (*values)[middle] : 0.5 * ((*values)[middle - 1] + (*values)[middle]);
  }
  std::nth_element(values->begin(), values->begin() + middle, values->end());
  const double upper = (*values)[middle];
  if (values->size() % 2 == 1) return upper;
  return 0.5 * (upper + *std::max_element(values->begin(), values->begin() + middle));
}

double RobustSigma(Eigen::VectorXd deviations) {
  constexpr double kSigmaPerMedian = 1.4826;
  std::vector<double> absolute(deviations.size());
  for (size_t i = 0; i < absolute.size(); ++i) absolute[i] = std::abs(deviations[i]);
  return kSigmaPerMedian * Median(&absolute);
}

std::vector<bool> FindOutliers(const Eigen::VectorXd& series_mm, double sigma_floor_mm, const OutlierOptions& options) {
  const int count = static_cast<int>(series_mm.size());
  std::vector<bool> stands_out(count, false);
  if (count < options.min_readings) return stands_out;
  Eigen::VectorXd deviation(count);
  std::vector<double> window;
  for (int k = 0; k < count; ++k) {
    window.clear();
    // The neighbours without the reading itself; at the ends the window is one-sided.
    for (int i = std::max(0, k - options.half_window); i <= std::min(count - 1, k + options.half_window); ++i) {
      if (i != k) window.push_back(series_mm[i]);
    }
    deviation[k] = series_mm[k] - Median(&window);
  }
  const double limit = options.threshold * std::max(RobustSigma(deviation), sigma_floor_mm);
  for (int k = 0; k < count; ++k) stands_out[k] = std::abs(deviation[k]) > limit;
  // Clusters are structure: a run of neighbours, gaps of one allowed.
  int first = -1, last = -10, members = 0;
  const auto close_cluster = [&] {
    if (members > options.max_cluster) std::fill(stands_out.begin() + first, stands_out.begin() + last + 1, false);
  };
  for (int k = 0; k < count; ++k) {
    if (!stands_out[k]) continue;
    if (k - last > 2) {
      close_cluster();
      first = k;
      members = 0;
    }
    last = k;
    ++members;
  }
  close_cluster();
  return stands_out;
}

}  // namespace axiscal::identify
