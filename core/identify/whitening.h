// Turns the rows of one series (one run, one reading column) into rows of unit variance and no correlation: what is new
// in each, after the best prediction from those before it (the Kalman filter of white noise beside first-order
// autoregressive noise). With variance shares w (white) and 1 - w, and a gap of g readings (some set aside) to the row
// before,
//   innovation_k = row_k - ar1^g row_(k-g) + echo_k innovation_(k-g),   echo_k = ar1^g w / F_(k-g)
//   whitened_k = innovation_k / (sigma sqrt(F_k)),                      the first row: row / sigma, F = 1
//   F_k = w + (1 - w) (1 - ar1^(2g)) + ar1^g echo_k (F_(k-g) - w)
// Without white noise echo_k = 0 and F_k = 1 - ar1^(2g).
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
    if (noise.ar1 == 0.0) return;
    previous_.setZero(width);
    innovation_.setZero(width);
  }

  // innovation = row - correlation previous row + echo previous innovation;   whitened = weight innovation
  struct Factors {
    double weight, correlation, echo;
  };

  // Factors of the next used reading's row. Call in time order.
  Factors Next(int reading) {
    Factors factors{1.0 / noise_.sigma_mm, 0.0, 0.0};
    if (noise_.ar1 != 0.0 && last_reading_ >= 0) {
      const double white = noise_.white_share, decay = std::pow(noise_.ar1, reading - last_reading_);
      factors.correlation = decay;
      factors.echo = decay * white / variance_;
      variance_ = white + (1.0 - white) * (1.0 - decay * decay) + decay * factors.echo * (variance_ - white);
      factors.weight /= std::sqrt(variance_);
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
      innovation_[i] = raw - factors.correlation * previous_[i] + factors.echo * innovation_[i];
      row[i] = factors.weight * innovation_[i];
      previous_[i] = raw;
    }
  }

 private:
  Noise noise_;
  Eigen::RowVectorXd previous_, innovation_;
  double variance_ = 1.0;  // of the last innovation over sigma squared
  int last_reading_ = -1;
};

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_WHITENING_H_
