#include "core/identify/outliers.h"

#include <algorithm>
#include <cmath>

namespace axiscal::identify {
namespace {

// The values of a sliding window in ascending order.
class SortedWindow {
 public:
  explicit SortedWindow(int capacity) { values_.reserve(static_cast<size_t>(capacity)); }

  void Add(double value) { values_.insert(values_.begin() + RankOf(value), value); }
  void Remove(double value) { values_.erase(values_.begin() + RankOf(value)); }
  void Replace(double old_value, double new_value) {
    const int count = static_cast<int>(values_.size());
    int at = RankOf(old_value);
    for (; at + 1 < count && values_[at + 1] < new_value; ++at) values_[at] = values_[at + 1];
    for (; at > 0 && values_[at - 1] > new_value; --at) values_[at] = values_[at - 1];
    values_[at] = new_value;
  }

  // Median of the values without one of those that equal `value`, which is among them. 0 for none.
  double MedianWithout(double value) const {
    const int left = static_cast<int>(values_.size()) - 1, rank = RankOf(value);
    if (left == 0) return 0.0;
    const auto at = [&](int i) { return values_[i < rank ? i : i + 1]; };
    return left % 2 == 1 ? at(left / 2) : 0.5 * (at(left / 2 - 1) + at(left / 2));
  }

 private:
  // How many are smaller: of a value that is there, its place.
  int RankOf(double value) const {
    int rank = 0;
    for (const double one : values_) rank += one < value;
    return rank;
  }

  std::vector<double> values_;
};

}  // namespace

Eigen::VectorXd OffRunningMedian(const Eigen::VectorXd& series, int half_window) {
  const Eigen::Index count = series.size(), half = half_window;
  Eigen::VectorXd off(count);
  SortedWindow window(2 * half_window + 2);
  for (Eigen::Index k = 0; k < std::min(half, count); ++k) window.Add(series[k]);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Index leaves = k - half - 1, enters = k + half;
    if (leaves >= 0 && enters < count) {
      window.Replace(series[leaves], series[enters]);
    } else if (enters < count) {
      window.Add(series[enters]);
    } else if (leaves >= 0) {
      window.Remove(series[leaves]);
    }
    off[k] = series[k] - window.MedianWithout(series[k]);
  }
  return off;
}

double Median(std::vector<double>* values) {
  if (values->empty()) return 0.0;
  const size_t middle = values->size() / 2;
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
  const Eigen::VectorXd deviation = OffRunningMedian(series_mm, options.half_window);
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
