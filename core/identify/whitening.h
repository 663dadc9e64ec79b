// Turns the rows of one series (one run, one reading column) into rows of unit variance and no correlation. The noise
// is first-order autoregressive with marginal sigma; over a gap of g readings (some set aside) neighbours correlate by
// ar1^g, so
//   whitened_k = (row_k - ar1^g row_(k-g)) / (sigma sqrt(1 - ar1^(2g))),   the first row: row / sigma.
#ifndef AXISCAL_CORE_IDENTIFY_WHITENING_H_
#define AXISCAL_CORE_IDENTIFY_WHITENING_H_

#include <Eigen/Core>
#include <cmath>

#include "core/identify/problem.h"

namespace axiscal::identify {

class SeriesWhitener {
 public:
  SeriesWhitener() = default;
  SeriesWhitener(const Noise& noise, Eigen::Index width) : noise_(noise) {
    if (noise.ar1 != 0.0) previous_.setZero(width);
  }

  // whitened = weight (row - correlation previous row)
  struct Factors {
    double weight, correlation;
  };

  // Factors of the next used reading's row. Call in time order.
  Factors Next(int reading) {
    Factors factors{1.0 / noise_.sigma_mm, 0.0};
    if (noise_.ar1 != 0.0 && last_reading_ >= 0) {
      factors.correlation = std::pow(noise_.ar1, reading - last_reading_);
      factors.weight /= std::sqrt(1.0 - factors.correlation * factors.correlation);
    }
    last_reading_ = reading;
    return factors;
  }

  // Whitens the row of a used reading in place. Call in time order.
  template <typename Row>
  void Apply(int reading, Row&& row) {
    const Factors factors = Next(reading);
    if (noise_.ar1 == 0.0) {
      row *= factors.weight;
      return;
    }
    for (Eigen::Index i = 0; i < previous_.size(); ++i) {
      const double raw = row[i];
      row[i] = factors.weight * (raw - factors.correlation * previous_[i]);
      previous_[i] = raw;
    }
  }

 private:
  Noise noise_;
  Eigen::RowVectorXd previous_;
  int last_reading_ = -1;
};

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_WHITENING_H_
