#include "core/identify/noise.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/identify/outliers.h"

namespace axiscal::identify {
namespace {

using instruments::MeasuringRun;

constexpr double kLargestCorrelation = 0.9;

// A reading follows its neighbour closely enough for differences where one step of the plan is a small part of the
// whole motion.
bool IsDenselySampled(const MeasuringRun& run) {
  constexpr int kDense = 100;
  return run.reading_count() >= kDense && run.kind == instruments::Kind::kBallbar;
}

std::vector<bool> UsedOf(const Problem& problem, size_t run, int row) {
  std::vector<bool> is_used(problem.runs[run].reading_count());
  for (size_t k = 0; k < is_used.size(); ++k)
    is_used[k] = problem.is_used[run][k * static_cast<size_t>(problem.runs[run].row_count) + static_cast<size_t>(row)];
  return is_used;
}

// Standard deviation of what lies within a few robust sigmas: as sharp as the plain one, blind to bad readings.
double Scatter(const std::vector<double>& values, double lost_freedom) {
  const double robust =
      RobustSigma(Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
  constexpr double kWithin = 3.5, kShareOfVariance = 0.9985;  // Gaussian variance within 3.5 sigma over the whole
  double squares = 0.0;
  int count = 0;
  for (const double value : values) {
    if (std::abs(value) > kWithin * robust) continue;
    squares += value * value;
    ++count;
  }
  const double freedom = std::max(1.0, count - lost_freedom);
  return std::sqrt(squares / freedom / kShareOfVariance);
}

double Clamp(double ratio) { return std::clamp(ratio, 1.0 / kMostScatter, kMostScatter); }

}  // namespace

void Variogram::Add(const Eigen::VectorXd& residual_mm, const std::vector<bool>& is_used, double unit_mm) {
  for (int i = 0; i < kLags; ++i) {
    for (Eigen::Index k = kLag[i]; k < residual_mm.size(); ++k) {
      if (!is_used[k] || !is_used[k - kLag[i]]) continue;
      const double difference = (residual_mm[k] - residual_mm[k - kLag[i]]) / unit_mm;
      squares_[i] += 0.5 * difference * difference;
      ++count_[i];
    }
  }
}

void Variogram::Add(const Variogram& other) {
  for (int i = 0; i < kLags; ++i) {
    squares_[i] += other.squares_[i];
    count_[i] += other.count_[i];
  }
}

double Variogram::SigmaAt(double ar1) const {
  return count_[0] > 0 ? std::sqrt(squares_[0] / count_[0] / (1.0 - ar1)) : 0.0;
}

Noise Variogram::Fit() const {
  if (count_[0] == 0 || squares_[0] == 0.0) return {};
  // Relative misfit of all lags at the sigma that suits a correlation best; the correlation by a scan.
  const auto fit = [this](double phi, double* sigma) {
    double ratio_sum = 0.0;
    double ratios[kLags];
    int lags = 0;
    for (int i = 0; i < kLags; ++i) {
      if (count_[i] == 0) continue;
      ratios[lags] = squares_[i] / count_[i] / (1.0 - std::pow(phi, kLag[i]));
      ratio_sum += ratios[lags++];
    }
    const double mean = ratio_sum / lags;
    double misfit = 0.0;
    for (int i = 0; i < lags; ++i) misfit += (ratios[i] / mean - 1.0) * (ratios[i] / mean - 1.0);
    *sigma = std::sqrt(mean);
    return misfit;
  };
  Noise best{0.0, 0.0};
  double least = INFINITY, sigma = 0.0;
  for (double phi = 0.0; phi <= kLargestCorrelation; phi += 0.005) {
    const double misfit = fit(phi, &sigma);
    if (misfit >= least) continue;
    least = misfit;
    best = {sigma, phi};
  }
  // Correlation weaker than its own uncertainty is white noise.
  if (best.ar1 < 3.0 * 1.2 / std::sqrt(static_cast<double>(count_[0]))) best = {SigmaAt(0.0), 0.0};
  return best;
}

std::vector<Noise> EstimateNoise(const Problem& problem, const std::vector<Eigen::MatrixXd>& residuals_mm) {
  constexpr int kFewest = 60;          // differences or readings that judge a scatter
  constexpr double kOwnScatter = 4.0;  // standard deviations by which a session's own scatter must differ
  const size_t count = problem.runs.size();
  std::vector<Noise> noise(count);
  for (size_t i = 0; i < count; ++i) noise[i] = {problem.runs[i].sigma_mm, 0.0};

  // Dense series: one correlation and one factor on the stated sigma for the instrument, its own where it must be.
  std::vector<Variogram> own(count);
  Variogram all;
  for (size_t i = 0; i < count; ++i) {
    const MeasuringRun& run = problem.runs[i];
    if (!IsDenselySampled(run)) continue;
    for (int row = 0; row < run.row_count; ++row)
      own[i].Add(residuals_mm[i].row(row).transpose(), UsedOf(problem, i, row), run.sigma_mm);
    if (own[i].differences() >= kFewest) all.Add(own[i]);
  }
  const Noise shared = all.Fit();
  for (size_t i = 0; i < count; ++i) {
    if (own[i].differences() < kFewest || shared.sigma_mm <= 0.0) continue;
    const double mine = own[i].SigmaAt(shared.ar1);
    // Relative uncertainty of a standard deviation from n correlated differences.
    const double uncertainty = std::sqrt((1.0 + shared.ar1) / (1.0 - shared.ar1) / (2.0 * own[i].differences())) + 0.02;
    const bool differs = std::abs(std::log(mine / shared.sigma_mm)) > kOwnScatter * uncertainty;
    noise[i] = {Clamp(differs ? mine : shared.sigma_mm) * problem.runs[i].sigma_mm, shared.ar1};
  }

  // The others: scatter of the residuals, pooled by instrument; what the setup offsets took is given back.
  std::map<instruments::Kind, std::vector<double>> pooled;
  std::map<instruments::Kind, double> lost;
  std::vector<std::vector<double>> values(count);
  for (size_t i = 0; i < count; ++i) {
    const MeasuringRun& run = problem.runs[i];
    if (own[i].differences() >= kFewest) continue;
    for (int row = 0; row < run.row_count; ++row) {
      const std::vector<bool> is_used = UsedOf(problem, i, row);
      for (int k = 0; k < run.reading_count(); ++k) {
        if (is_used[k]) values[i].push_back(residuals_mm[i](row, k) / run.sigma_mm);
      }
    }
    std::vector<double>& pool = pooled[run.kind];
    pool.insert(pool.end(), values[i].begin(), values[i].end());
    lost[run.kind] += static_cast<double>(run.setup.size());
  }
  for (size_t i = 0; i < count; ++i) {
    const instruments::Kind kind = problem.runs[i].kind;
    constexpr size_t kFewestReadings = 24;
    if (own[i].differences() >= kFewest || pooled[kind].size() < kFewestReadings) continue;
    const double together = Scatter(pooled[kind], lost[kind]);
    double factor = together;
    if (values[i].size() >= kFewestReadings) {
      const double mine = Scatter(values[i], static_cast<double>(problem.runs[i].setup.size()));
      const double uncertainty = 1.0 / std::sqrt(2.0 * static_cast<double>(values[i].size()));
      if (std::abs(std::log(mine / together)) > kOwnScatter * uncertainty) factor = mine;
    }
    noise[i].sigma_mm = Clamp(factor) * problem.runs[i].sigma_mm;
  }
  return noise;
}

}  // namespace axiscal::identify
