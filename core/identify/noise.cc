#include "core/identify/noise.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/identify/outliers.h"
#include "core/instruments/resolution.h"

namespace axiscal::identify {
namespace {

using instruments::MeasuringRun;

constexpr double kLargestCorrelation = 0.9;
constexpr int kAr1Lags = 4;  // of the variogram: noise without a white share has forgotten what is further back
// Range of ar1 that is tried for noise with a white share. Less cannot be told from white noise. What fits best above
// kLargestCorrelation is an effect that the model lacks; the range goes beyond it so that this shows.
constexpr double kLeastMemory = 0.3, kLargestMemory = 0.95;
constexpr double kClearly = 4.0;  // misfit, counted as chi-square, by which a white share must be better

// A reading follows its neighbour closely enough for differences where one step of the plan is a small part of the
// whole motion. Neighbours on a coarse display share what rounding takes from them.
bool IsDenselySampled(const MeasuringRun& run) {
  constexpr int kDense = 100;
  return run.reading_count() >= kDense && run.kind == instruments::Kind::kBallbar &&
         instruments::RoundingSigma(run) == 0.0;
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

// `ratio` to what a run may scatter by at rest, in that unit: rounding is there whatever the residuals show, as
// readings between two steps of a display all miss by the same.
double Clamp(double ratio, const MeasuringRun& run, double unit_mm) {
  return std::clamp(ratio, std::max(1.0 / kMostScatter, instruments::RoundingSigma(run) / unit_mm), kMostScatter);
}

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

double Variogram::SigmaAt(double neighbour_correlation) const {
  return count_[0] > 0 ? std::sqrt(squares_[0] / count_[0] / (1.0 - neighbour_correlation)) : 0.0;
}

Variogram::Mixture Variogram::FitBesideEffects(bool has_white_share) const {
  // Shares of the variogram by linear least squares at each phi of a scan; none may be negative.
  Mixture best{{}, INFINITY};
  for (double phi = has_white_share ? kLeastMemory : 0.0; phi <= kLargestMemory; phi += 0.01) {
    Eigen::Matrix<double, kLags, 3> shapes;  // what remembers, effects, white; relative to the variogram
    for (int i = 0; i < kLags; ++i) {
      const double relative = count_[i] / squares_[i];
      shapes.row(i) << (1.0 - std::pow(phi, kLag[i])) * relative, kLag[i] * kLag[i] * relative, relative;
    }
    for (const bool has_effects : {true, false}) {
      Eigen::Matrix<double, kLags, Eigen::Dynamic, Eigen::ColMajor, kLags, 3> columns(kLags, 0);
      const auto add = [&](int column) {
        columns.conservativeResize(Eigen::NoChange, columns.cols() + 1);
        columns.rightCols(1) = shapes.col(column);
      };
      add(0);
      if (has_white_share) add(2);
      if (has_effects) add(1);
      const Eigen::Matrix<double, kLags, 1> ones = Eigen::Matrix<double, kLags, 1>::Ones();
      const Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 3, 1> parts = columns.householderQr().solve(ones);
      const double misfit = (columns * parts - ones).squaredNorm();
      if (!(parts.minCoeff() >= 0.0) || misfit >= best.misfit) continue;
      const double white = has_white_share ? parts[1] : 0.0, variance = parts[0] + white;
      best = {{std::sqrt(variance), phi, white / variance}, misfit};
    }
  }
  return best;
}

Noise Variogram::Fit() const {
  const Noise alone = FitAr1();
  const int differences = count_[kLags - 1];
  if (differences == 0) return alone;
  const Mixture without = FitBesideEffects(false), with = FitBesideEffects(true);
  const double gain = 0.5 * differences * (without.misfit - with.misfit);
  return gain > kClearly && with.noise.ar1 < kLargestCorrelation ? with.noise : alone;
}

Noise Variogram::FitAr1() const {
  if (count_[0] == 0 || squares_[0] == 0.0) return {};
  // Relative misfit of all lags at the sigma that suits a correlation best; the correlation by a scan.
  const auto fit = [this](double phi, double* sigma) {
    double ratio_sum = 0.0;
    double ratios[kAr1Lags];
    int lags = 0;
    for (int i = 0; i < kAr1Lags; ++i) {
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

double InnovationShare(const Noise& noise) {
  if (noise.ar1 == 0.0) return 1.0;
  // The steady state of whitening.h's F: root of P^2 + P (w - ar1^2 w - fresh) - fresh w, P = F - w.
  const double square = noise.ar1 * noise.ar1, white = noise.white_share;
  const double fresh = (1.0 - white) * (1.0 - square), half = 0.5 * (white * (1.0 - square) - fresh);
  return white - half + std::sqrt(half * half + fresh * white);
}

double LongRunShare(const Noise& noise) {
  return noise.white_share + (1.0 - noise.white_share) * (1.0 + noise.ar1) / (1.0 - noise.ar1);
}

Ar1Bound BoundingAr1(const Noise& noise) {
  if (noise.white_share == 0.0 || noise.ar1 == 0.0) return {noise, 1.0};
  // Spectral density at the cosine c of the frequency. Its inverse is concave in c, that of AR(1) noise linear: equal
  // at both ends, it is larger between them.
  const auto density = [](const Noise& one, double c) {
    return one.white_share +
           (1.0 - one.white_share) * (1.0 - one.ar1 * one.ar1) / (1.0 + one.ar1 * one.ar1 - 2.0 * one.ar1 * c);
  };
  const double lowest = density(noise, 1.0), highest = density(noise, -1.0), root = std::sqrt(lowest / highest);
  Ar1Bound bound{{noise.sigma_mm * std::pow(lowest * highest, 0.25), (root - 1.0) / (root + 1.0)}, 1.0};
  for (double c = -1.0; c <= 1.0; c += 0.01)
    bound.excess = std::max(bound.excess, std::sqrt(lowest * highest) * density(bound.noise, c) / density(noise, c));
  return bound;
}

std::vector<Noise> EstimateNoise(const Problem& problem, const std::vector<Eigen::MatrixXd>& residuals_mm) {
  constexpr int kFewest = 60;          // differences or readings that judge a scatter
  constexpr double kOwnScatter = 4.0;  // standard deviations by which a session's own scatter must differ
  const size_t count = problem.runs.size();
  std::vector<Noise> noise(count);
  std::vector<double> unit_mm(count);
  for (size_t i = 0; i < count; ++i) noise[i].sigma_mm = unit_mm[i] = instruments::SigmaWithRounding(problem.runs[i]);

  // Dense series: one correlation and one factor on the stated sigma for the instrument, its own where it must be.
  std::vector<Variogram> own(count);
  Variogram all;
  for (size_t i = 0; i < count; ++i) {
    const MeasuringRun& run = problem.runs[i];
    if (!IsDenselySampled(run)) continue;
    for (int row = 0; row < run.row_count; ++row)
      own[i].Add(residuals_mm[i].row(row).transpose(), UsedOf(problem, i, row), unit_mm[i]);
    if (own[i].differences() >= kFewest) all.Add(own[i]);
  }
  const Noise shared = all.Fit();
  for (size_t i = 0; i < count; ++i) {
    if (own[i].differences() < kFewest || shared.sigma_mm <= 0.0) continue;
    const double mine = own[i].SigmaAt(shared.NeighbourCorrelation());
    // Relative uncertainty of a standard deviation from n correlated differences.
    const double uncertainty = std::sqrt(LongRunShare(shared) / (2.0 * own[i].differences())) + 0.02;
    const bool differs = std::abs(std::log(mine / shared.sigma_mm)) > kOwnScatter * uncertainty;
    noise[i] = shared;
    noise[i].sigma_mm = Clamp(differs ? mine : shared.sigma_mm, problem.runs[i], unit_mm[i]) * unit_mm[i];
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
        if (is_used[k]) values[i].push_back(residuals_mm[i](row, k) / unit_mm[i]);
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
    noise[i].sigma_mm = Clamp(factor, problem.runs[i], unit_mm[i]) * unit_mm[i];
  }
  return noise;
}

}  // namespace axiscal::identify
