#include "core/drift/rate_bank.h"

#include <algorithm>
#include <cmath>

namespace axiscal::drift {
namespace {

constexpr double kUnknownLevel = 1e4;  // (100 sigma)^2: more than what a machine's errors differ by
// The prior of the scale: as if 12 calibrations had scattered by 1.2 times what they state.
constexpr double kPriorCount = 12.0, kPriorScale = 1.44;
constexpr double kMostCount = 400.0;       // calibrations after which older ones fade
constexpr double kClip = 9.0;              // z^2 of one calibration counts as this at most
constexpr double kOutlier = 12.0;          // beyond it a value hardly moves the level
constexpr double kOutlierWeight = 0.02;    // of such a value
constexpr double kLeastKnown = 100.0;      // a stated variance above tells nothing of scatter
constexpr int kSettling = 3;               // steps after a start without judgement
constexpr double kLeastLogWeight = -20.0;  // below the best: a rate that fits no longer can come back

std::array<double, 5> Weights(const RateBank& bank) {
  std::array<double, 5> weights;
  const double most = *std::max_element(bank.log_weight.begin(), bank.log_weight.end());
  double sum = 0.0;
  for (int k = 0; k < 5; ++k) sum += weights[k] = std::exp(bank.log_weight[k] - most);
  for (double& weight : weights) weight /= sum;
  return weights;
}

}  // namespace

void Restart(double level, RateBank* bank) {
  bank->mean.fill(level);
  bank->variance.fill(kUnknownLevel);
  for (int k = 0; k < 5; ++k) bank->log_weight[k] = std::log(kRatePrior[k]);
  bank->steps = 0;
}

double ScaleOf(const RateBank& bank) { return (kPriorCount * kPriorScale + bank.squares) / (kPriorCount + bank.count); }

double SquaredRateOf(const RateBank& bank) {
  const std::array<double, 5> weights = Weights(bank);
  double sum = 0.0;
  for (int k = 0; k < 5; ++k) sum += weights[k] * kRates[k] * kRates[k];
  return sum;
}

void Absorb(double y, double variance, double weeks, RateBank* bank) {
  const double scale = ScaleOf(*bank);
  const std::array<double, 5> weights = Weights(*bank);
  const bool is_settled = bank->steps >= kSettling;
  double mean = 0.0, spread = 0.0;
  for (int k = 0; k < 5; ++k) {
    bank->variance[k] += kRates[k] * kRates[k] * weeks;
    mean += weights[k] * bank->mean[k];
    spread += weights[k] * (bank->variance[k] + bank->mean[k] * bank->mean[k]);
  }
  spread = std::max(0.0, spread - mean * mean);
  if (is_settled && variance < kLeastKnown) {
    bank->squares += std::min((y - mean) * (y - mean) / (spread + variance), kClip * scale);
    bank->count += 1.0;
    if (bank->count > kMostCount) {
      bank->squares *= kMostCount / bank->count;
      bank->count = kMostCount;
    }
  }
  for (int k = 0; k < 5; ++k) {
    const double predicted = bank->variance[k] + variance;
    const double off = y - bank->mean[k];
    const double square = off * off / predicted / scale;
    if (is_settled) bank->log_weight[k] -= 0.5 * (std::min(square, kClip) + std::log(predicted));
    const double trusted = is_settled && square > kOutlier ? bank->variance[k] + variance / kOutlierWeight : predicted;
    const double gain = bank->variance[k] / trusted;
    bank->mean[k] += gain * off;
    bank->variance[k] *= 1.0 - gain;
  }
  const double most = *std::max_element(bank->log_weight.begin(), bank->log_weight.end());
  for (double& log_weight : bank->log_weight) log_weight = std::max(log_weight - most, kLeastLogWeight);
  ++bank->steps;
}

}  // namespace axiscal::drift
