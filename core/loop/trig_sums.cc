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
constexpr int kHalfPoints = 8;  // on either side of a position: 1e-7 with twice as many points as frequencies
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
  double falls[kPoints];
  for (int p = 0; p < kPoints; ++p) falls[p] = std::exp(-std::pow(p * spacing, 2) / (4.0 * width));
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
    // exp(-(x - p h)^2 / 4 w) = exp(-x^2 / 4 w) exp(x h / 2 w)^p exp(-(p h)^2 / 4 w), x from the lowest point
    const double away = x - first_point_[k] * spacing;
    const double growth = std::exp(away * spacing / (2.0 * width));
    double value = std::exp(-away * away / (4.0 * width));
    for (int p = 0; p < kPoints; ++p) {
      spread_(p, k) = value * falls[p];
      value *= growth;
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
  const Eigen::Index columns = strengths.cols();
  // All columns' points side by side, real parts first: what a reading adds to a point stands together.
  Eigen::MatrixXd points = Eigen::MatrixXd::Zero(2 * columns, grid_);
  Eigen::VectorXd values(2 * columns);
  for (Eigen::Index k = 0; k < turned_.size(); ++k) {
    for (Eigen::Index c = 0; c < columns; ++c) {
      values[c] = strengths(k, c) * turned_[k].real();
      values[columns + c] = strengths(k, c) * turned_[k].imag();
    }
    for (int p = 0; p < kPoints; ++p) points.col((first_point_[k] + p) & (grid_ - 1)) += spread_(p, k) * values;
  }
  Eigen::MatrixXcd sums(count_, columns);
  Eigen::FFT<double> transform;
  Eigen::VectorXcd one(grid_), turns(grid_);
  for (Eigen::Index c = 0; c < columns; ++c) {
    one.real() = points.row(c).transpose();
    one.imag() = points.row(columns + c).transpose();
    // The transform's kernel is exp(-i): frequency m stands at -m.
    transform.fwd(turns, one);
    for (int m = 0; m < count_; ++m) sums(m, c) = undone_[m] * turns[(count_ / 2 - m) & (grid_ - 1)];
  }
  return sums;
}

}  // namespace axiscal::loop
