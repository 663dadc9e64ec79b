// What the readings scatter by, judged from the readings themselves: the stated sigma is only where to start
// (design.md, "Close the loop", 1).
#ifndef AXISCAL_CORE_LOOP_NOISE_H_
#define AXISCAL_CORE_LOOP_NOISE_H_

#include <Eigen/Core>
#include <vector>

#include "core/identify/problem.h"

namespace axiscal::loop {

// Sigma and neighbour correlation of one series from its differences, which a slowly varying effect hardly touches:
//   var(d) = 2 s^2 (1 - phi),   cov(d_k, d_k+1) = -s^2 (1 - phi)^2,   so phi = 1 + 2 cov / var.
// Readings not used are left out with the differences they belong to. Sigma 0 when fewer than `min_differences` remain.
identify::Noise NoiseFromDifferences(const Eigen::VectorXd& residual_mm, const std::vector<bool>& is_used,
                                     int min_differences = 60);

// Noise of every run from its residuals under the model so far. Series too short or too coarsely sampled for
// differences take the robust scatter of their residuals. Never below a third or above three times the stated sigma:
// beyond that a session is not what it says it is.
std::vector<identify::Noise> EstimateNoise(const identify::Problem& problem,
                                           const std::vector<Eigen::MatrixXd>& residuals_mm);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_NOISE_H_
