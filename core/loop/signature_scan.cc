#include "core/loop/signature_scan.h"

#include <cmath>

#include "core/loop/signatures.h"
#include "core/loop/trig_sums.h"

namespace axiscal::loop {
namespace {

// Of fine structure hardly anything is projected off; of what is as wide as this share of an axis' range nearly all may
// be.
constexpr double kLeastVisible = 0.2, kLeastVisibleWide = 0.01, kWide = 0.03;

// One member: products of its columns with the residual, with each other, with a constant (whitened).
struct Products {
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  Eigen::Matrix2d gram = Eigen::Matrix2d::Zero();
  Eigen::Vector2d level = Eigen::Vector2d::Zero();
};

// One joint at a time: for all of them together, what it sums up would be most of the loop's memory.
class Scanner {
 public:
  Scanner(const ScanNoise& noise, const Eigen::ArrayXd& by_raw_row, const Eigen::MatrixXd& sensitivity,
          const std::function<shapes::State(int row)>& state_of)
      : n_(by_raw_row.size()),
        is_white_((noise.correlation == 0.0).all()),
        excess_(noise.excess),
        sensitivity_(sensitivity),
        by_raw_row_(by_raw_row),
        state_of_(state_of) {
    // |W x|^2 = sum_k d_k x_k^2 - 2 sum_k o_k x_k x_(k-1)
    off_ = noise.weight.square() * noise.correlation;
    diagonal_ = noise.weight.square();
    diagonal_.head(n_ - 1) += off_.tail(n_ - 1) * noise.correlation.tail(n_ - 1);
  }

  // Members of one family of one axis' own errors, at evenly spaced frequencies.
  void Harmonics(const std::vector<Candidate>& candidates, const std::vector<size_t>& first_of, double step,
                 std::vector<ScanBounds>* bounds) {
    const Candidate& lowest = candidates[first_of.front()];
    const auto& harmonic = std::get<shapes::Harmonic>(lowest.term.shape);
    const int count = static_cast<int>(first_of.size()) - 1;
    LookAt(lowest.term.joint);
    const Eigen::ArrayXd& positions = PositionsOf(harmonic.axis);
    const auto sums_at = [&](const Eigen::ArrayXd& at) { return TrigSums(at, harmonic.frequency, step, count); };
    const TrigSums plain = sums_at(positions);
    const Eigen::MatrixXcd right = plain.Of(with_residual_), level = plain.Of(with_constant_);
    // Products of cosines and sines are those of sums and differences of the angles.
    const Eigen::MatrixXcd twice = sums_at(2.0 * positions).Of(own_);
    const Eigen::RowVectorXd total = own_.colwise().sum();
    Eigen::MatrixXcd sum, difference;
    if (!is_white_) {
      sum = sums_at(positions.tail(n_ - 1) + positions.head(n_ - 1)).Of(neighbour_);
      difference = sums_at(positions.tail(n_ - 1) - positions.head(n_ - 1)).Of(neighbour_);
    }
    for (int m = 0; m < count; ++m) {
      for (size_t i = first_of[m]; i < first_of[m + 1]; ++i) {
        const int c = static_cast<int>(candidates[i].term.component);
        Products products;
        products.right = {right(m, c).real(), right(m, c).imag()};
        products.level = {level(m, c).real(), level(m, c).imag()};
        Eigen::Matrix2d& gram = products.gram;
        gram(0, 0) = 0.5 * (total[c] + twice(m, c).real());
        gram(1, 1) = 0.5 * (total[c] - twice(m, c).real());
        gram(0, 1) = 0.5 * twice(m, c).imag();
        if (!is_white_) {
          gram(0, 0) -= difference(m, c).real() + sum(m, c).real();
          gram(1, 1) -= difference(m, c).real() - sum(m, c).real();
          gram(0, 1) -= sum(m, c).imag();
        }
        gram(1, 0) = gram(0, 1);
        (*bounds)[i] = BoundsOf(products, 2, constant_[c], kLeastVisible);
      }
    }
  }

  // Members of one local shape of one column: only the readings near it count.
  void Place(const std::vector<Candidate>& candidates, size_t begin, size_t end, std::vector<ScanBounds>* bounds) {
    const auto& bump = std::get<shapes::Bump>(candidates[begin].term.shape);
    LookAt(candidates[begin].term.joint);
    const Eigen::ArrayXd& positions = PositionsOf(bump.axis);
    constexpr double kReach = 5.0;  // widths: exp(-25) of it is left there
    std::vector<Eigen::Index> rows;
    std::vector<double> basis;
    std::vector<shapes::AxisState> axes(bump.axis + 1);  // a local shape sees nothing but the position
    const shapes::State state = {.axes = axes};
    double value = 0.0;
    for (Eigen::Index k = 0; k < n_; ++k) {
      if (std::abs(positions[k] - bump.at) > kReach * bump.width) continue;
      axes[bump.axis].position = positions[k];
      bump.Basis<double>(state, nullptr, &value);
      rows.push_back(k);
      basis.push_back(value);
    }
    for (size_t i = begin; i < end; ++i) {
      const auto column = static_cast<Eigen::Index>(candidates[i].term.component);
      Products products;
      for (size_t r = 0; r < rows.size(); ++r) {
        products.right[0] += basis[r] * with_residual_(rows[r], column);
        products.level[0] += basis[r] * with_constant_(rows[r], column);
        products.gram(0, 0) += basis[r] * basis[r] * own_(rows[r], column);
        if (!is_white_ && r > 0 && rows[r - 1] == rows[r] - 1)
          products.gram(0, 0) -= 2.0 * basis[r] * basis[r - 1] * neighbour_(rows[r - 1], column);
      }
      const bool is_wide = bump.width > kWide * (positions.maxCoeff() - positions.minCoeff());
      (*bounds)[i] = BoundsOf(products, 1, constant_[column], is_wide ? kLeastVisibleWide : kLeastVisible);
    }
  }

 private:
  void LookAt(int joint) {
    if (joint == joint_) return;
    joint_ = joint;
    const auto columns = sensitivity_.middleCols(machine::kComponents * joint, machine::kComponents).array();
    with_residual_ = columns.colwise() * by_raw_row_;
    own_ = columns.square().colwise() * diagonal_;
    // With a constant: the part that an axis at rest leaves in a signature, mostly a declared error's or the setup's.
    with_constant_ = own_;
    if (!is_white_) {
      neighbour_ = (columns.bottomRows(n_ - 1) * columns.topRows(n_ - 1)).colwise() * off_.tail(n_ - 1);
      with_constant_.topRows(n_ - 1) -= neighbour_;
      with_constant_.bottomRows(n_ - 1) -= neighbour_;
    }
    constant_ = with_constant_.colwise().sum();
  }

  const Eigen::ArrayXd& PositionsOf(int axis) {
    if (axis != axis_) {
      positions_.resize(n_);
      for (Eigen::Index k = 0; k < n_; ++k) positions_[k] = state_of_(static_cast<int>(k)).axes[axis].position;
      axis_ = axis;
    }
    return positions_;
  }

  ScanBounds BoundsOf(const Products& products, int width, double constant, double least_visible) const {
    Projection projection;
    projection.columns = width;
    projection.with_residual.head(2) = products.right;
    projection.own.topLeftCorner(2, 2) = products.gram;
    ScanBounds bounds;
    Eigen::Vector3d amplitude;
    bounds.least = Gain(projection, &amplitude) / excess_;
    if (constant > 0.0) {
      const Eigen::Vector2d part = products.level / std::sqrt(constant);
      constexpr double kRegularised = 1e-7;  // a signature that is constant altogether is left for projection
      projection.own.topLeftCorner(2, 2) -= (1.0 - kRegularised) * part * part.transpose();
    }
    bounds.most = Gain(projection, &amplitude) / least_visible;
    return bounds;
  }

  const Eigen::Index n_;
  const bool is_white_;
  const double excess_;
  const Eigen::MatrixXd& sensitivity_;
  const Eigen::ArrayXd& by_raw_row_;
  const std::function<shapes::State(int row)>& state_of_;
  Eigen::ArrayXd off_, diagonal_;
  int joint_ = -1;                                                   // of what follows
  Eigen::MatrixXd with_residual_, own_, neighbour_, with_constant_;  // rows x 6
  Eigen::RowVectorXd constant_;
  int axis_ = -1;  // of positions_
  Eigen::ArrayXd positions_;
};

bool IsHarmonic(const Candidate& candidate) { return std::holds_alternative<shapes::Harmonic>(candidate.term.shape); }

double FrequencyOf(const Candidate& candidate) { return std::get<shapes::Harmonic>(candidate.term.shape).frequency; }

}  // namespace

std::vector<ScanBounds> Scan(const std::vector<Candidate>& candidates, const ScanNoise& noise,
                             const Eigen::ArrayXd& by_raw_row, const Eigen::MatrixXd& sensitivity,
                             const std::function<shapes::State(int row)>& state_of) {
  std::vector<ScanBounds> bounds(candidates.size());
  Scanner scanner(noise, by_raw_row, sensitivity, state_of);
  // Members of one shape follow each other, and shapes of one scan by their frequency.
  const auto is_of_shape = [&](size_t i, size_t other) {
    return i < candidates.size() && candidates[i].family == candidates[other].family &&
           candidates[i].term.joint == candidates[other].term.joint &&
           candidates[i].term.shape == candidates[other].term.shape;
  };
  const auto end_of_shape = [&](size_t begin) {
    size_t end = begin + 1;
    while (is_of_shape(end, begin)) ++end;
    return end;
  };
  for (size_t begin = 0; begin < candidates.size();) {
    size_t end = end_of_shape(begin);
    if (!IsScan(candidates[begin].family)) {
      begin = end;
      continue;
    }
    if (!IsHarmonic(candidates[begin])) {
      scanner.Place(candidates, begin, end, &bounds);
      begin = end;
      continue;
    }
    std::vector<size_t> first_of = {begin, end};
    double step = 1.0;
    while (end < candidates.size() && candidates[end].family == candidates[begin].family &&
           candidates[end].term.joint == candidates[begin].term.joint) {
      const double next = FrequencyOf(candidates[end]) - FrequencyOf(candidates[first_of[first_of.size() - 2]]);
      if (first_of.size() == 2) step = next;
      constexpr double kSame = 1e-9;
      if (!(next > 0.0) || std::abs(next - step) > kSame * step) break;
      end = end_of_shape(end);
      first_of.push_back(end);
    }
    scanner.Harmonics(candidates, first_of, first_of.size() > 2 ? step : 1.0, &bounds);
    begin = end;
  }
  return bounds;
}

}  // namespace axiscal::loop
