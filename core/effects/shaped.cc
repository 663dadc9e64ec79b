#include "core/effects/shaped.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <complex>

namespace axiscal::effects {

double PlaceOf(const shapes::Shape& shape) {
  if (const auto* bump = std::get_if<shapes::Bump>(&shape)) return bump->at;
  const double* parameter = shapes::NonlinearParameter(shape);
  if (parameter == nullptr) return 0.0;
  return std::holds_alternative<shapes::Harmonic>(shape) ? *parameter : std::log(*parameter);
}

shapes::Shape AtPlace(shapes::Shape shape, double place) {
  if (auto* bump = std::get_if<shapes::Bump>(&shape)) bump->at = place;
  if (double* parameter = shapes::NonlinearParameter(shape))
    *parameter = std::holds_alternative<shapes::Harmonic>(shape) ? place : std::exp(place);
  return shape;
}

shapes::Shape AsIn(const objective::Group& group, shapes::Shape shape) {
  if (auto* bump = std::get_if<shapes::Bump>(&shape)) bump->width = std::exp(group.size);
  return AtPlace(std::move(shape), group.place);
}

Shaped::Shaped(const Linearised& linearised, std::vector<ShapedItem> items, bool is_scan)
    : linearised_(linearised), items_(std::move(items)), is_scan_(is_scan) {
  first_value_ = {0};
  for (const ShapedItem& item : items_) {
    if (shapes_.empty() || !(shapes_.back() == item.shape)) {
      is_beginning_.push_back(!shapes_.empty() && shapes::IsBeginningOf(item.shape, shapes_.back()));
      shapes_.push_back(item.shape);
      first_value_.push_back(first_value_.back() + shapes::BasisCount(item.shape));
    }
    auto place = std::find(sensitivities_.begin(), sensitivities_.end(), item.sensitivity);
    if (place == sensitivities_.end()) place = sensitivities_.insert(place, item.sensitivity);
    shape_of_.push_back(shapes_.size() - 1);
    sensitivity_of_.push_back(static_cast<size_t>(place - sensitivities_.begin()));
    groups_.push_back(item.group);
    groups_.back().columns = shapes::BasisCount(item.shape);
  }
  constexpr Eigen::Index kFew = 12;  // columns: as many as a session has set-up offsets
  if (first_value_.back() <= kFew) {
    Eigen::MatrixXd values(linearised_.count(), first_value_.back());
    Fill(0, shapes_.size(), 0, values);
    kept_ = std::move(values);
  }
}

void Shaped::Fill(size_t first, size_t last, int begin, Eigen::Ref<Eigen::MatrixXd> values) const {
  const auto n = static_cast<int>(values.rows());
  if (kept_.size() > 0) {
    values.leftCols(first_value_[last] - first_value_[first]) =
        kept_.block(begin, first_value_[first], n, first_value_[last] - first_value_[first]);
    return;
  }
  Eigen::ArrayXd position(n);
  Eigen::ArrayXcd turn(n);
  double step = NAN;
  const shapes::Harmonic* before = nullptr;
  int position_of = -1;  // axis
  const auto take_positions = [&](int axis) {
    if (axis == position_of) return;
    for (int i = 0; i < n; ++i) position[i] = linearised_.StateAt(begin + i).axes[axis].position;
    position_of = axis;
  };
  for (size_t s = first; s < last; ++s) {
    const Eigen::Index at = first_value_[s] - first_value_[first];
    const auto* harmonic = std::get_if<shapes::Harmonic>(&shapes_[s]);
    if (const auto* bump = std::get_if<shapes::Bump>(&shapes_[s])) {
      take_positions(bump->axis);
      // Beyond six widths exp(-36) is left: nothing, and numbers that small are slow.
      constexpr double kReach = 36.0;
      const Eigen::ArrayXd squares = ((position - bump->at) / bump->width).square();
      values.col(at) = (squares < kReach).select((-squares.min(kReach)).exp(), 0.0);
      before = nullptr;
      continue;
    }
    if (s > first && is_beginning_[s]) {
      const Eigen::Index width = first_value_[s + 1] - first_value_[s];
      values.middleCols(at, width) = values.middleCols(first_value_[s - 1] - first_value_[first], width);
      before = nullptr;
      continue;
    }
    if (harmonic == nullptr) {
      double basis[shapes::kMaxBasisCount];
      const int width = shapes::BasisCount(shapes_[s]);
      for (int i = 0; i < n; ++i) {
        shapes::Basis(shapes_[s], linearised_.StateAt(begin + i), basis);
        for (int b = 0; b < width; ++b) values(i, at + b) = basis[b];
      }
      before = nullptr;
      continue;
    }
    if (before == nullptr || before->axis != harmonic->axis) {
      take_positions(harmonic->axis);
      values.col(at) = (harmonic->frequency * position).cos();
      values.col(at + 1) = (harmonic->frequency * position).sin();
      step = NAN;
    } else {
      const double next = harmonic->frequency - before->frequency;
      constexpr double kSameStep = 1e-9;  // of the step: a hundredth of a micrometre over a machine's travel
      if (!(std::abs(next - step) <= kSameStep * std::abs(next))) {
        step = next;
        for (int i = 0; i < n; ++i) turn[i] = std::polar(1.0, step * position[i]);
      }
      for (int i = 0; i < n; ++i) {
        const std::complex<double> value = std::complex<double>(values(i, at - 2), values(i, at - 1)) * turn[i];
        values(i, at) = value.real();
        values(i, at + 1) = value.imag();
      }
    }
    before = harmonic;
  }
}

Eigen::MatrixXd Shaped::Columns(int group) const {
  const size_t s = shape_of_[group];
  Eigen::MatrixXd columns(linearised_.count(), first_value_[s + 1] - first_value_[s]);
  Fill(s, s + 1, 0, columns);
  columns.array().colwise() *= linearised_.sensitivity.col(items_[group].sensitivity).array();
  return columns;
}

std::unique_ptr<objective::Source> Shaped::Moved(int group, double place) const {
  if (!(groups_[group].reach > 0.0)) return nullptr;
  ShapedItem item = items_[group];
  item.shape = AtPlace(item.shape, place);
  item.group.place = place;
  return std::make_unique<Shaped>(linearised_, std::vector<ShapedItem>{item});
}

std::unique_ptr<objective::Source> Shaped::Resized(int group, double size) const {
  if (!(groups_[group].size_reach > 0.0)) return nullptr;
  ShapedItem item = items_[group];
  item.group.size = size;
  item.shape = AsIn(item.group, item.shape);
  return std::make_unique<Shaped>(linearised_, std::vector<ShapedItem>{item});
}

void Shaped::AddProducts(int begin, const Eigen::MatrixXd& u, Eigen::Ref<Eigen::MatrixXd> products) const {
  constexpr int kRowsAtOnce = 256;  // rows x columns of a block stay in cache
  const Eigen::Index k = u.cols();
  const auto count = static_cast<Eigen::Index>(sensitivities_.size());
  Eigen::MatrixXd values(kRowsAtOnce, first_value_.back()), seen(kRowsAtOnce, count * k);
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(first_value_.back(), count * k);
  for (Eigen::Index at = 0; at < u.rows(); at += kRowsAtOnce) {
    const Eigen::Index n = std::min<Eigen::Index>(kRowsAtOnce, u.rows() - at);
    Fill(0, shapes_.size(), begin + static_cast<int>(at), values.topRows(n));
    for (Eigen::Index c = 0; c < count; ++c) {
      const auto its = linearised_.sensitivity.col(sensitivities_[c]).segment(begin + at, n);
      for (Eigen::Index j = 0; j < k; ++j) seen.col(c * k + j).head(n) = its.cwiseProduct(u.col(j).segment(at, n));
    }
    sums.noalias() += values.topRows(n).transpose() * seen.topRows(n);
  }
  Eigen::Index at = 0;
  for (size_t i = 0; i < items_.size(); ++i) {
    const Eigen::Index width = groups_[i].columns;
    products.middleRows(at, width) +=
        sums.block(first_value_[shape_of_[i]], static_cast<Eigen::Index>(sensitivity_of_[i]) * k, width, k);
    at += width;
  }
}

std::optional<size_t> Shaped::FinerOf(size_t item) const {
  const size_t shape = shape_of_[item];
  if (!is_beginning_[shape]) return std::nullopt;
  for (size_t other = item; other-- > 0 && shape_of_[other] + 1 >= shape;)
    if (shape_of_[other] + 1 == shape && sensitivity_of_[other] == sensitivity_of_[item]) return other;
  return std::nullopt;
}

std::vector<Eigen::MatrixXd> Shaped::Grams(const objective::Whitening& whitening) const {
  constexpr Eigen::Index kColumnsAtOnce = 16;  // all rows of them are held
  std::vector<Eigen::MatrixXd> grams;
  size_t item = 0;
  for (size_t s = 0, end = 0; s < shapes_.size(); s = end) {
    for (end = s + 1; end < shapes_.size() && first_value_[end + 1] - first_value_[s] <= kColumnsAtOnce;) ++end;
    Eigen::MatrixXd values, columns;  // when they are needed
    for (; item < items_.size() && shape_of_[item] < end; ++item) {
      if (const std::optional<size_t> finer = FinerOf(item)) {
        grams.push_back(grams[*finer].topLeftCorner(groups_[item].columns, groups_[item].columns));
        continue;
      }
      if (values.size() == 0) {
        values.resize(linearised_.count(), first_value_[end] - first_value_[s]);
        Fill(s, end, 0, values);
      }
      const Eigen::Index first = first_value_[shape_of_[item]] - first_value_[s];
      columns = values.middleCols(first, groups_[item].columns);
      columns.array().colwise() *= linearised_.sensitivity.col(items_[item].sensitivity).array();
      whitening.Apply(0, columns);
      grams.emplace_back(columns.transpose() * columns);
    }
  }
  return grams;
}

}  // namespace axiscal::effects
