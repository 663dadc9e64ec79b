// One error by itself: how fast its level wanders, and by which factor its calibrations scatter more than they state.
//   y_k = level_k + noise,  level_(k+1) = level_k + q sqrt(weeks) noise',   both noises with the same unknown factor
// for five rates q at once (a bank of scalar Kalman filters, weighed by their likelihoods). All in units of the error's
// stated sigma.
#ifndef AXISCAL_CORE_DRIFT_RATE_BANK_H_
#define AXISCAL_CORE_DRIFT_RATE_BANK_H_

#include <array>

namespace axiscal::drift {

// Stated sigmas per root of a week: none at all, and from what takes a year to be seen to what is gone in a month.
inline constexpr std::array<double, 5> kRates = {0.0, 0.02, 0.05, 0.12, 0.3};
inline constexpr std::array<double, 5> kRatePrior = {0.70, 0.10, 0.08, 0.07, 0.05};

struct RateBank {
  std::array<double, 5> mean{}, variance{}, log_weight{};
  int steps = 0;         // since it started
  double squares = 0.0;  // sum of z^2, stated sigmas; clipped
  double count = 0.0;    // of them; fades, so that what was long ago counts less
};

// Anew at `level`, with the scatter that is known.
void Restart(double level, RateBank* bank);
// `weeks` later the value `y` with the stated variance `variance`.
void Absorb(double y, double variance, double weeks, RateBank* bank);

// Scatter by statement, squared.
double ScaleOf(const RateBank& bank);
// Expected q^2, stated sigmas^2 per week, before the scale.
double SquaredRateOf(const RateBank& bank);

}  // namespace axiscal::drift

#endif  // AXISCAL_CORE_DRIFT_RATE_BANK_H_
