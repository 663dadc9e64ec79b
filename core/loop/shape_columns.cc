#include "core/loop/shape_columns.h"

#include <cmath>

namespace axiscal::loop {

ShapeColumns::ShapeColumns(int row_count, std::function<shapes::State(int row)> state_of)
    : row_count_(row_count), state_of_(std::move(state_of)) {}

const Eigen::MatrixXd& ShapeColumns::Of(const shapes::Shape& shape) {
  if (is_filled_ && shape == shape_) return values_;
  const auto* harmonic = std::get_if<shapes::Harmonic>(&shape);
  const auto* last = is_filled_ ? std::get_if<shapes::Harmonic>(&shape_) : nullptr;
  // A step that comes again is worth its cosines; rounding grows by one unit a step, far below what a reading resolves.
  if (harmonic != nullptr && last != nullptr && harmonic->axis == last->axis && harmonic->frequency > last->frequency) {
    Turn(*harmonic);
  } else {
    values_.resize(row_count_, shapes::BasisCount(shape));
    double basis[shapes::kMaxBasisCount];
    for (int row = 0; row < row_count_; ++row) {
      shapes::Basis(shape, state_of_(row), basis);
      for (Eigen::Index b = 0; b < values_.cols(); ++b) values_(row, b) = basis[b];
    }
  }
  shape_ = shape;
  is_filled_ = true;
  return values_;
}

void ShapeColumns::Turn(const shapes::Harmonic& harmonic) {
  const double step = harmonic.frequency - std::get<shapes::Harmonic>(shape_).frequency;
  constexpr double kSame = 1e-9;
  if (turned_axis_ != harmonic.axis || std::abs(step - turned_by_) > kSame * step) {
    cosine_.resize(row_count_);
    sine_.resize(row_count_);
    for (int row = 0; row < row_count_; ++row) {
      const double angle_rad = step * state_of_(row).axes[harmonic.axis].position;
      cosine_[row] = std::cos(angle_rad);
      sine_[row] = std::sin(angle_rad);
    }
    turned_axis_ = harmonic.axis;
    turned_by_ = step;
  }
  scratch_ = values_.col(0).array() * cosine_ - values_.col(1).array() * sine_;
  values_.col(1).array() = values_.col(1).array() * cosine_ + values_.col(0).array() * sine_;
  values_.col(0) = scratch_;
}

}  // namespace axiscal::loop
