#include "core/effects/harmonic_scan.h"

#include <algorithm>
#include <cmath>

#include "core/loop/trig_sums.h"

namespace axiscal::effects {

std::unique_ptr<HarmonicScan> HarmonicScan::Make(const Linearised& linearised, std::vector<ShapedItem> items) {
  constexpr double kSame = 1e-9;  // of a frequency: rounding
  double first = INFINITY, last = 0.0, step = INFINITY;
  int axis = -1;
  for (const ShapedItem& item : items) {
    const auto* harmonic = std::get_if<shapes::Harmonic>(&item.shape);
    if (harmonic == nullptr || (axis >= 0 && harmonic->axis != axis)) return nullptr;
    axis = harmonic->axis;
    if (last > 0.0 && harmonic->frequency > last * (1.0 + kSame)) step = std::min(step, harmonic->frequency - last);
    first = std::min(first, harmonic->frequency);
    last = harmonic->frequency;
  }
  constexpr int kFew = 8, kMost = 2000;  // frequencies for which sums pay, and that a transform is made for
  const double steps = (last - first) / step;
  if (!(steps >= kFew && steps <= kMost)) return nullptr;
  for (const ShapedItem& item : items) {
    const double order = (std::get<shapes::Harmonic>(item.shape).frequency - first) / step;
    constexpr double kOff = 1e-6;  // of a step: over the whole range a millionth of a turn
    if (std::abs(order - std::round(order)) > kOff || order < -kOff || order > steps + kOff) return nullptr;
  }
  const int count = 1 + static_cast<int>(std::lround(steps));
  return std::unique_ptr<HarmonicScan>(new HarmonicScan(linearised, std::move(items), first, step, count));
}

HarmonicScan::HarmonicScan(const Linearised& linearised, std::vector<ShapedItem> items, double first, double step,
                           int count)
    : Shaped(linearised, std::move(items), true),
      axis_(std::get<shapes::Harmonic>(items_.front().shape).axis),
      first_(first),
      step_(step),
      count_(count) {
  for (const ShapedItem& item : items_)
    order_.push_back(
        static_cast<int>(std::lround((std::get<shapes::Harmonic>(item.shape).frequency - first_) / step_)));
}

Eigen::ArrayXd HarmonicScan::Positions(int begin, Eigen::Index count) const {
  Eigen::ArrayXd positions(count);
  for (Eigen::Index i = 0; i < count; ++i)
    positions[i] = linearised_.StateAt(begin + static_cast<int>(i)).axes[axis_].position;
  return positions;
}

void HarmonicScan::AddProducts(int begin, const Eigen::MatrixXd& u, Eigen::Ref<Eigen::MatrixXd> products) const {
  const Eigen::Index n = u.rows(), k = u.cols();
  const auto seen = static_cast<Eigen::Index>(sensitivities_.size());
  Eigen::MatrixXd strengths(n, seen * k);
  for (Eigen::Index c = 0; c < seen; ++c)
    strengths.middleCols(c * k, k) =
        u.array().colwise() * linearised_.sensitivity.col(sensitivities_[c]).segment(begin, n).array();
  const Eigen::MatrixXcd sums = loop::TrigSums(Positions(begin, n), first_, step_, count_).Of(strengths);
  for (size_t i = 0; i < items_.size(); ++i) {
    const auto its = sums.row(order_[i]).segment(static_cast<Eigen::Index>(sensitivity_of_[i]) * k, k);
    products.row(static_cast<Eigen::Index>(2 * i)) += its.real();
    products.row(static_cast<Eigen::Index>(2 * i + 1)) += its.imag();
  }
}

// |W x|^2 = sum_k d_k x_k^2 - 2 sum_k o_k x_k x_(k-1) without an echo; products of cosines and sines are those of sums
// and differences of the angles.
std::vector<Eigen::MatrixXd> HarmonicScan::Grams(const objective::Whitening& whitening) const {
  if (whitening.has_echo()) return Shaped::Grams(whitening);
  const Eigen::Index n = linearised_.count();
  const auto seen = static_cast<Eigen::Index>(sensitivities_.size());
  const Eigen::ArrayXd off = whitening.weight().square() * whitening.correlation();
  Eigen::ArrayXd diagonal = whitening.weight().square();
  diagonal.head(n - 1) += off.tail(n - 1) * whitening.correlation().tail(n - 1);
  const Eigen::ArrayXd positions = Positions(0, n);
  const auto sums_of = [&](const Eigen::ArrayXd& at, const Eigen::MatrixXd& strengths) {
    return loop::TrigSums(at, first_, step_, count_).Of(strengths);
  };
  Eigen::MatrixXd own(n, seen), neighbours(n - 1, seen);
  for (Eigen::Index c = 0; c < seen; ++c) {
    const auto its = linearised_.sensitivity.col(sensitivities_[c]).array();
    own.col(c) = its.square() * diagonal;
    neighbours.col(c) = its.tail(n - 1) * its.head(n - 1) * off.tail(n - 1);
  }
  const Eigen::RowVectorXd total = own.colwise().sum();
  const Eigen::MatrixXcd twice = sums_of(2.0 * positions, own);
  Eigen::MatrixXcd sum, difference;
  if (!whitening.is_white()) {
    sum = sums_of(positions.tail(n - 1) + positions.head(n - 1), neighbours);
    difference = sums_of(positions.tail(n - 1) - positions.head(n - 1), neighbours);
  }
  std::vector<Eigen::MatrixXd> grams;
  for (size_t i = 0; i < items_.size(); ++i) {
    const int m = order_[i];
    const auto c = static_cast<Eigen::Index>(sensitivity_of_[i]);
    Eigen::MatrixXd& gram = grams.emplace_back(2, 2);
    gram(0, 0) = 0.5 * (total[c] + twice(m, c).real());
    gram(1, 1) = 0.5 * (total[c] - twice(m, c).real());
    gram(0, 1) = 0.5 * twice(m, c).imag();
    if (!whitening.is_white()) {
      gram(0, 0) -= difference(m, c).real() + sum(m, c).real();
      gram(1, 1) -= difference(m, c).real() - sum(m, c).real();
      gram(0, 1) -= sum(m, c).imag();
    }
    gram(1, 0) = gram(0, 1);
  }
  return grams;
}

}  // namespace axiscal::effects
