#include "core/objective/whitening.h"

#include <algorithm>

namespace axiscal::objective {

Whitening::Whitening(Eigen::ArrayXd weight, Eigen::ArrayXd correlation, Eigen::ArrayXd echo)
    : weight_(std::move(weight)), correlation_(std::move(correlation)), echo_(std::move(echo)) {
  is_white_ = (correlation_ == 0.0).all();
  has_echo_ = (echo_ != 0.0).any();
}

void Whitening::Apply(int begin, Eigen::Ref<Eigen::MatrixXd> columns) const {
  const Eigen::Index n = columns.rows();
  constexpr Eigen::Index kRows = 512;  // of a part that stays in the cache
  Eigen::Array<double, kRows, 1> before;
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    auto x = columns.col(c);
    // From the end, as each row needs the one before it as it was.
    for (Eigen::Index end = n, rows = 0; !is_white_ && end > 1; end -= rows) {
      rows = std::min(kRows, end - 1);
      before.head(rows) = x.segment(end - rows - 1, rows).array();
      x.segment(end - rows, rows).array() -= correlation_.segment(begin + end - rows, rows) * before.head(rows);
    }
    for (Eigen::Index k = 1; has_echo_ && k < n; ++k) x[k] += echo_[begin + k] * x[k - 1];
    x.array() *= weight_.segment(begin, n);
  }
}

void Whitening::Undo(int begin, Eigen::Ref<Eigen::MatrixXd> columns) const {
  const Eigen::Index n = columns.rows();
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    auto x = columns.col(c);
    x.array() /= weight_.segment(begin, n);
    for (Eigen::Index k = n - 1; has_echo_ && k > 0; --k) x[k] -= echo_[begin + k] * x[k - 1];
    for (Eigen::Index k = 1; !is_white_ && k < n; ++k) x[k] += correlation_[begin + k] * x[k - 1];
  }
}

Eigen::MatrixXd Whitening::Adjoint(Eigen::MatrixXd v) const {
  const Eigen::Index n = v.rows();
  for (Eigen::Index c = 0; c < v.cols(); ++c) {
    auto x = v.col(c);
    x.array() *= weight_;
    for (Eigen::Index k = n - 1; has_echo_ && k > 0; --k) x[k - 1] += echo_[k] * x[k];
    for (Eigen::Index k = 0; !is_white_ && k + 1 < n; ++k) x[k] -= correlation_[k + 1] * x[k + 1];
  }
  return v;
}

int Whitening::Memory(int first, int end) const {
  if (is_white_) return std::min(1, end - first);
  constexpr double kForgotten = 1e-9;
  int count = 1;
  for (double left = 1.0; has_echo_ && left > kForgotten && first + count < end; ++count) left *= echo_[first + count];
  return std::min(count + 1, end - first);
}

}  // namespace axiscal::objective
