#include "core/drift/scales.h"

#include <algorithm>
#include <cmath>

namespace axiscal::drift {
namespace {

constexpr double kDrawn = 30.0;        // calibrations after which an error's own scale counts as much as the machine's
constexpr double kLeastCommon = 0.36;  // 0.6^2: no instrument is so much better than it states
constexpr double kQuantile = 0.3;      // of the errors' scales: set-ups add to some errors, a wrong sigma to all
constexpr double kOwnCount = 150.0;    // calibrations until the quantile is trusted

}  // namespace

Scales ScalesOf(const State& state) {
  const auto n = static_cast<Eigen::Index>(state.errors.size());
  Scales scales{1.0, Eigen::VectorXd(n), Eigen::VectorXd(n)};
  std::vector<double> logs(n);
  double mean = 0.0, sum = 0.0, most = 0.0;
  for (Eigen::Index j = 0; j < n; ++j) {
    const double count = state.errors[j].bank.count;
    logs[j] = std::log(ScaleOf(state.errors[j].bank));
    mean += (1.0 + count) * logs[j];
    sum += 1.0 + count;
    most = std::max(most, count);
  }
  mean /= sum;
  for (Eigen::Index j = 0; j < n; ++j) {
    const double count = state.errors[j].bank.count;
    scales.each(j) = std::exp((count * logs[j] + kDrawn * mean) / (count + kDrawn));
    scales.rate(j) = scales.each(j) * SquaredRateOf(state.errors[j].bank);
  }
  std::sort(logs.begin(), logs.end());
  const double quantile = logs[static_cast<size_t>(kQuantile * static_cast<double>(n - 1))];
  const double own = std::min(1.0, most / kOwnCount);
  scales.common = std::max(kLeastCommon, std::exp((1.0 - own) * mean + own * quantile));
  return scales;
}

Eigen::MatrixXd NoiseOf(const Eigen::MatrixXd& stated, const Scales& scales) {
  Eigen::MatrixXd noise = scales.common * stated;
  for (Eigen::Index j = 0; j < noise.rows(); ++j) noise(j, j) += std::max(0.0, scales.each(j) - scales.common);
  return noise;
}

}  // namespace axiscal::drift
