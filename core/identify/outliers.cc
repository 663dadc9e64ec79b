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
  if (count < options.fewest_readings) return stands_out;
  if (count < options.min_readings) {
    std::vector<double> values(series_mm.begin(), series_mm.end());
    const Eigen::VectorXd off = series_mm.array() - Median(&values);
    const double most = options.short_threshold * std::max(RobustSigma(off), sigma_floor_mm);
    for (int k = 0; k < count; ++k) stands_out[k] = std::abs(off[k]) > most;
    return stands_out;
  }
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
  // Neighbours that stand out together on one side are structure; chips fall on either side and leave gaps.
  for (int first = 0; first < count;) {
    if (!stands_out[first]) {
      ++first;
      continue;
    }
    int last = first + 1;
    while (last < count && stands_out[last] && std::signbit(deviation[last]) == std::signbit(deviation[first])) ++last;
    if (last - first > options.max_cluster) std::fill(stands_out.begin() + first, stands_out.begin() + last, false);
    first = last;
  }
  return stands_out;
}

}  // namespace axiscal::identify
