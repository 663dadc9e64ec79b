// By how much the readings scatter, and how neighbours correlate, estimated from the readings themselves: the stated
// sigma is only where to start.
#ifndef AXISCAL_CORE_IDENTIFY_NOISE_H_
#define AXISCAL_CORE_IDENTIFY_NOISE_H_

#include <Eigen/Core>
#include <vector>

#include "core/identify/problem.h"

namespace axiscal::identify {

// Mean squared differences of readings `lag` apart, halved (the variogram): sums over series, so that sessions pool.
//   gamma(lag) = sigma^2 (1 - phi^lag)                               first-order autoregressive noise
//   gamma(lag) = sigma^2 (w + (1 - w) (1 - phi^lag))                 the same with a white share w beside it
// An effect that varies slowly from reading to reading adds little to it, in proportion to lag^2. That is why it is
// taken and not the residuals' own scatter.
class Variogram {
 public:
  static constexpr int kLags = 6;
  static constexpr int kLag[kLags] = {1, 2, 3, 5, 8, 12};

  // Adds one series, in units of `unit_mm`. Readings not used are left out with the differences they belong to.
  void Add(const Eigen::VectorXd& residual_mm, const std::vector<bool>& is_used, double unit_mm);
  void Add(const Variogram& other);
  int differences() const { return count_[0]; }
  // Sigma (in the unit) and correlation that fit best; correlation 0 where it is within three times its uncertainty,
  // and a white share only where the variogram clearly asks for one. Sigma 0 without differences.
  Noise Fit() const;
  // Sigma alone at a known correlation of neighbours.
  double SigmaAt(double neighbour_correlation) const;

 private:
  Noise FitAr1() const;
  // Of noise with a white share, or without (`has_white_share`), beside what slow effects add: the noise, and the sum
  // of the squared relative misfits of all lags.
  struct Mixture {
    Noise noise;
    double misfit = 0.0;
  };
  Mixture FitBesideEffects(bool has_white_share) const;

  double squares_[kLags] = {};
  int count_[kLags] = {};
};

// First-order autoregressive noise without a white share whose spectral density is that of `noise` at zero and at the
// highest frequency, nowhere smaller, and at most `excess` times as large: a bound that needs one neighbour only.
struct Ar1Bound {
  Noise noise;
  double excess = 1.0;
};
Ar1Bound BoundingAr1(const Noise& noise);

// What is new in a reading after the best prediction from all before it: variance over that of the reading.
double InnovationShare(const Noise& noise);

// Variance of the mean of many readings over that of as many independent ones.
double LongRunShare(const Noise& noise);

// Of the stated sigma: what scatters by more is not the instrument's noise.
inline constexpr double kMostScatter = 3.0;

// Noise of every run from its residuals under the model so far. Sessions of one instrument share the correlation and
// the factor on their stated sigma, unless a session's own scatter clearly differs. Dense series are judged by the
// variogram, others by the robust scatter of their residuals. Never below a third or above kMostScatter times the
// stated sigma: beyond that a session is not what it says it is.
std::vector<Noise> EstimateNoise(const Problem& problem, const std::vector<Eigen::MatrixXd>& residuals_mm);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_NOISE_H_
