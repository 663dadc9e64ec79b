#include "core/loop/noise.h"

#include <algorithm>
#include <cmath>

#include "core/identify/outliers.h"

namespace axiscal::loop {
namespace {

using identify::Noise;

constexpr double kLargestCorrelation = 0.9;

// A reading follows its neighbour closely enough for differences where one step of the plan is a small part of the
// whole motion.
bool IsDenselySampled(const instruments::MeasuringRun& run) {
  constexpr int kDense = 100;
  return run.reading_count() >= kDense && run.kind == instruments::Kind::kBallbar;
}

Noise FromScatter(const Eigen::VectorXd& residual_mm, const std::vector<bool>& is_used) {
  std::vector<double> used;
  for (Eigen::Index k = 0; k < residual_mm.size(); ++k) {
    if (is_used[k]) used.push_back(residual_mm[k]);
  }
  if (used.size() < 8) return {};
  return {identify::RobustSigma(Eigen::Map<Eigen::VectorXd>(used.data(), static_cast<Eigen::Index>(used.size()))), 0.0};
}

}  // namespace

Noise NoiseFromDifferences(const Eigen::VectorXd& residual_mm, const std::vector<bool>& is_used, int min_differences) {
  double squares = 0.0, products = 0.0;
  int count = 0, pairs = 0;
  for (Eigen::Index k = 1; k < residual_mm.size(); ++k) {
    if (!is_used[k] || !is_used[k - 1]) continue;
    const double difference = residual_mm[k] - residual_mm[k - 1];
    squares += difference * difference;
    ++count;
    if (k + 1 < residual_mm.size() && is_used[k + 1]) {
      products += difference * (residual_mm[k + 1] - residual_mm[k]);
      ++pairs;
    }
  }
  if (count < min_differences || pairs < min_differences / 2 || squares == 0.0) return {};
  const double variance = squares / count, covariance = products / pairs;
  // Correlation weaker than its own uncertainty (2.4 / sqrt(n) for phi near 0) is white noise.
  double phi = std::clamp(1.0 + 2.0 * covariance / variance, 0.0, kLargestCorrelation);
  if (phi < 3.0 * 2.4 / std::sqrt(static_cast<double>(pairs))) phi = 0.0;
  return {std::sqrt(variance / (2.0 * (1.0 - phi))), phi};
}

std::vector<Noise> EstimateNoise(const identify::Problem& problem, const std::vector<Eigen::MatrixXd>& residuals_mm) {
  std::vector<Noise> noise;
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const instruments::MeasuringRun& run = problem.runs[i];
    double variance = 0.0, phi = 0.0;
    int series = 0;
    for (int row = 0; row < run.row_count; ++row) {
      std::vector<bool> is_used(run.reading_count());
      for (int k = 0; k < run.reading_count(); ++k)
        is_used[k] = problem.is_used[i][static_cast<size_t>(k) * run.row_count + row];
      const Eigen::VectorXd residual_mm = residuals_mm[i].row(row).transpose();
      const Noise one =
          IsDenselySampled(run) ? NoiseFromDifferences(residual_mm, is_used) : FromScatter(residual_mm, is_used);
      if (one.sigma_mm <= 0.0) continue;
      variance += one.sigma_mm * one.sigma_mm;
      phi += one.ar1;
      ++series;
    }
    Noise mean{run.sigma_mm, 0.0};
    if (series > 0) {
      mean.sigma_mm = std::clamp(std::sqrt(variance / series), run.sigma_mm / 3.0, run.sigma_mm * 3.0);
      mean.ar1 = phi / series;
    }
    noise.push_back(mean);
  }
  return noise;
}

}  // namespace axiscal::loop
