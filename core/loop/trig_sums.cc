#include "core/loop/trig_sums.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

#include "core/base/demand.h"

namespace axiscal::loop {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr int kHalfPoints = 6;  // on either side of a position: 1e-6 with twice as many points as frequencies
constexpr int kPoints = 2 * kHalfPoints;

}  // namespace

TrigSums::TrigSums(const Eigen::ArrayXd& positions, double first, double step, int count) : count_(count) {
  DEMAND(step > 0.0 && count > 0);
  const int frequencies = std::max(2 * kPoints, 2 * ((count + 1) / 2));
  grid_ = static_cast<int>(std::bit_ceil(static_cast<unsigned>(2 * frequencies)));
  // exp(-x^2 / (4 width)) on a period of 2 pi; with the grid's own ratio of points to frequencies.
  const double ratio = static_cast<double>(grid_) / frequencies;
  const double width = std::numbers::pi * kHalfPoints / (frequencies * frequencies * ratio * (ratio - 0.5));
  const double spacing = kTurn / grid_;
  // Frequencies are counted from the middle one.
  const double middle = first + step * (count / 2);
  turned_.resize(positions.size());
  first_point_.resize(positions.size());
  spread_.resize(kPoints, positions.size());
  for (Eigen::Index k = 0; k < positions.size(); ++k) {
    const double angle_rad = middle * positions[k];
    turned_[k] = {std::cos(angle_rad), std::sin(angle_rad)};
    const double turns = step * positions[k] / kTurn;
    const double x = (turns - std::floor(turns)) * kTurn;
    const int nearest = static_cast<int>(x / spacing);
    first_point_[k] = nearest - kHalfPoints + 1;
    for (int p = 0; p < kPoints; ++p) {
      const double away = x - (first_point_[k] + p) * spacing;
      spread_(p, k) = std::exp(-away * away / (4.0 * width));
    }
  }
  undone_.resize(count);
  for (int m = 0; m < count; ++m) {
    const double k = m - count / 2;
    undone_[m] = std::sqrt(std::numbers::pi / width) * std::exp(k * k * width) / grid_;
  }
}

Eigen::MatrixXcd TrigSums::Of(const Eigen::Ref<const Eigen::MatrixXd>& strengths) const {
  DEMAND(strengths.rows() == turned_.size());
  Eigen::MatrixXcd sums(count_, strengths.cols());
  Eigen::FFT<double> transform;
  Eigen::VectorXcd points(grid_), turns(grid_);
  for (Eigen::Index column = 0; column < strengths.cols(); ++column) {
    points.setZero();
    for (Eigen::Index k = 0; k < turned_.size(); ++k) {
      const std::complex<double> value = strengths(k, column) * turned_[k];
      for (int p = 0; p < kPoints; ++p) points[(first_point_[k] + p) & (grid_ - 1)] += value * spread_(p, k);
    }
    // The transform's kernel is exp(-i): frequency m stands at -m.
    transform.fwd(turns, points);
    for (int m = 0; m < count_; ++m) sums(m, column) = undone_[m] * turns[(count_ / 2 - m) & (grid_ - 1)];
  }
  return sums;
}

}  // namespace axiscal::loop
