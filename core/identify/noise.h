// What the readings scatter by, judged from the readings themselves: the stated sigma is only where to start
// (design.md, "Close the loop", 1).
#ifndef AXISCAL_CORE_IDENTIFY_NOISE_H_
#define AXISCAL_CORE_IDENTIFY_NOISE_H_

#include <Eigen/Core>
#include <vector>

#include "core/identify/problem.h"

namespace axiscal::identify {

// Mean squared differences of readings `lag` apart, halved (the variogram): sums over series, so that sessions pool.
//   gamma(lag) = sigma^2 (1 - phi^lag)                               first-order autoregressive noise
// Slowly varying effects hardly touch it, which is why it is taken instead of the residuals' own scatter.
class Variogram {
 public:
  static constexpr int kLags = 4;
  static constexpr int kLag[kLags] = {1, 2, 3, 5};

  // Adds one series, in units of `unit_mm`. Readings not used are left out with the differences they belong to.
  void Add(const Eigen::VectorXd& residual_mm, const std::vector<bool>& is_used, double unit_mm);
  void Add(const Variogram& other);
  int differences() const { return count_[0]; }
  // Sigma (in the unit) and neighbour correlation that fit best; correlation 0 where it is within three times its
  // uncertainty. Sigma 0 without differences.
  Noise Fit() const;
  // Sigma alone at a known correlation, from neighbours.
  double SigmaAt(double ar1) const;

 private:
  double squares_[kLags] = {};
  int count_[kLags] = {};
};

// Of the stated sigma: what scatters by more is not the instrument's noise.
inline constexpr double kMostScatter = 3.0;

// Noise of every run from its residuals under the model so far. Sessions of one instrument share the correlation and
// the factor on their stated sigma, unless a session's own scatter clearly differs. Dense series are judged by the
// variogram, others by the robust scatter of their residuals. Never below a third or above kMostScatter times the
// stated sigma: beyond that a session is not what it says it is.
std::vector<Noise> EstimateNoise(const Problem& problem, const std::vector<Eigen::MatrixXd>& residuals_mm);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_NOISE_H_
