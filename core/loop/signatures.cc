#include "core/loop/signatures.h"

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/loop/signature_scan.h"

namespace axiscal::loop {
namespace {

constexpr int kRowsAtOnce = 256;  // rows x columns of a block stay in cache

int ColumnOf(const Candidate& candidate) {
  return machine::kComponents * candidate.term.joint + static_cast<int>(candidate.term.component);
}

// An artefact may slip along what its session does not see.
void LeaveOut(int column, Projection* projection) {
  projection->own.row(column).setZero();
  projection->own.col(column).setZero();
  projection->with_residual[column] = 0.0;
}

}  // namespace

// Pivoted elimination; columns that are a combination of others in this data take no part.
double Gain(const Projection& projection, Eigen::Vector3d* amplitude) {
  const int n = projection.columns;
  Eigen::Matrix3d own = projection.own;
  Eigen::Vector3d right = projection.with_residual;
  constexpr double kRegular = 1e-9;
  const double least = kRegular * own.diagonal().head(n).maxCoeff();
  std::array<int, 3> order = {0, 1, 2};
  double gain = 0.0;
  int rank = 0;
  for (; rank < n; ++rank) {
    const auto largest = std::max_element(order.begin() + rank, order.begin() + n,
                                          [&own](int a, int b) { return own(a, a) < own(b, b); });
    std::iter_swap(order.begin() + rank, largest);
    const int pivot = order[rank];
    if (!(own(pivot, pivot) > least)) break;
    gain += right[pivot] * right[pivot] / own(pivot, pivot);
    for (int i = rank + 1; i < n; ++i) {
      const double share = own(order[i], pivot) / own(pivot, pivot);
      right[order[i]] -= share * right[pivot];
      for (int k = rank + 1; k < n; ++k) own(order[i], order[k]) -= share * own(pivot, order[k]);
    }
  }
  amplitude->setZero();
  for (int i = rank - 1; i >= 0; --i) {
    double value = -right[order[i]];
    for (int k = i + 1; k < rank; ++k) value -= own(order[i], order[k]) * (*amplitude)[order[k]];
    (*amplitude)[order[i]] = value / own(order[i], order[i]);
  }
  return gain;
}

int Signatures::ColumnsOf(const Candidate& candidate) const {
  return candidate.family == Family::kStep ? 3 : shapes::BasisCount(candidate.term.shape);
}

template <typename Visit>
void Signatures::ForEachBlock(const std::vector<const Candidate*>& candidates, Eigen::Index width, Visit visit) const {
  Eigen::MatrixXd raw(kRowsAtOnce + 1, width), whitened(kRowsAtOnce, width);
  Eigen::VectorXd innovation(width);  // of the row above
  for (const Series& rows : series_) {
    innovation.setZero();
    for (int begin = rows.begin; begin < rows.end; begin += kRowsAtOnce) {
      const int count = std::min(kRowsAtOnce, rows.end - begin);
      // The row above, where the noise remembers it.
      const int above = begin > rows.begin && !is_white_ ? 1 : 0;
      FillRaw(candidates, begin - above, raw.topRows(count + above));
      const auto weight = weight_.segment(begin, count);
      for (Eigen::Index c = 0; c < width; ++c) {
        auto out = whitened.col(c).head(count).array();
        out = raw.col(c).segment(above, count).array();
        if (!is_white_) {
          const int first = 1 - above;  // a series' first row has no neighbour
          out.tail(count - first) -=
              correlation_.segment(begin + first, count - first) * raw.col(c).head(count - first).array();
        }
        for (int k = 0; has_echo_ && k < count; ++k) {
          out[k] += echo_[begin + k] * innovation[c];
          innovation[c] = out[k];
        }
        out *= weight;
      }
      visit(rows, begin, whitened.topRows(count));
    }
  }
}

Eigen::ArrayXd Signatures::ByRawRow(const Eigen::VectorXd& whitened) const {
  Eigen::ArrayXd dual = weight_ * whitened.array();
  for (Eigen::Index k = dual.size() - 1; has_echo_ && k > 0; --k) dual[k - 1] += echo_[k] * dual[k];
  const Eigen::Index n = dual.size();
  const Eigen::ArrayXd below = correlation_.tail(n - 1) * dual.tail(n - 1);
  dual.head(n - 1) -= below;
  return dual;
}

std::vector<Projection> Signatures::Project(const std::vector<Candidate>& candidates) const {
  std::vector<Projection> projections(candidates.size());
  ProjectPending(candidates, &projections);
  return projections;
}

std::vector<Projection> Signatures::ProjectWorthy(const std::vector<Candidate>& candidates,
                                                  const std::map<Family, double>& worth, double share) const {
  std::vector<Projection> projections(candidates.size());
  if (row_count() == 0) return projections;
  const std::vector<ScanBounds> bounds =
      Scan(candidates, {bounding_weight_, bounding_correlation_, bounding_excess_}, ByRawRow(residual_), sensitivity_,
           [this](int row) { return StateAt(row); });
  for (size_t i = 0; i < candidates.size(); ++i) projections[i].is_screened = IsScan(candidates[i].family);
  ProjectPending(candidates, &projections);
  double best = 0.0;
  Eigen::Vector3d amplitude;
  for (size_t i = 0; i < candidates.size(); ++i) {
    best = std::max(best, bounds[i].least);
    if (projections[i].columns > 0 && projections[i].visible > kVisible)
      best = std::max(best, Gain(projections[i], &amplitude));
  }
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (bounds[i].most >= worth.at(candidates[i].family) && bounds[i].most >= share * best)
      projections[i].is_screened = false;
  }
  ProjectPending(candidates, &projections);
  return projections;
}

// All that are neither projected (columns > 0) nor screened out.
void Signatures::ProjectPending(const std::vector<Candidate>& candidates, std::vector<Projection>* projections) const {
  if (row_count() == 0) return;
  // A slip touches one run only: those of a run and carrier go together, all others over all rows.
  constexpr int kColumnsAtOnce = 96, kSlipColumnsAtOnce = 3072;
  std::vector<const Candidate*> some;
  std::vector<Projection*> theirs;
  int width = 0;
  const auto flush = [&] {
    if (!some.empty()) ProjectFully(some, theirs);
    some.clear();
    theirs.clear();
    width = 0;
  };
  for (size_t i = 0; i < candidates.size(); ++i) {
    if ((*projections)[i].is_screened || (*projections)[i].columns > 0) continue;
    const int most = candidates[i].family == Family::kStep ? kSlipColumnsAtOnce : kColumnsAtOnce;
    const bool is_alike =
        !some.empty() && some.front()->run == candidates[i].run && some.front()->carrier == candidates[i].carrier;
    if (width >= most || !is_alike) flush();
    some.push_back(&candidates[i]);
    theirs.push_back(&(*projections)[i]);
    width += ColumnsOf(candidates[i]);
  }
  flush();
}

void Signatures::FillRaw(const std::vector<const Candidate*>& candidates, int begin,
                         Eigen::Ref<Eigen::MatrixXd> columns) const {
  const Eigen::Index count = columns.rows();
  Eigen::MatrixXd basis(count, shapes::kMaxBasisCount);
  const shapes::Shape* filled = nullptr;  // neighbouring candidates share a shape
  Eigen::Index at = 0;
  for (const Candidate* candidate : candidates) {
    const int width = ColumnsOf(*candidate);
    if (candidate->family == Family::kStep) {
      const Eigen::Ref<const Eigen::MatrixXd> source = SlipOf(*candidate, begin, count);
      for (Eigen::Index i = 0; i < count; ++i) {
        const bool is_after = run_[begin + i] == candidate->run && reading_[begin + i] >= candidate->first_reading;
        for (int b = 0; b < width; ++b) columns(i, at + b) = is_after ? source(i, b) : 0.0;
      }
    } else {
      if (filled == nullptr || !(*filled == candidate->term.shape)) {
        double values[shapes::kMaxBasisCount];
        for (Eigen::Index i = 0; i < count; ++i) {
          shapes::Basis(candidate->term.shape, StateAt(begin + static_cast<int>(i)), values);
          for (int b = 0; b < width; ++b) basis(i, b) = values[b];
        }
        filled = &candidate->term.shape;
      }
      if (shapes::IsAlongApproach(candidate->term.shape)) {
        for (Eigen::Index i = 0; i < count; ++i) {
          const shapes::State state = StateAt(begin + static_cast<int>(i));
          const double along = machine::AlongApproach(state.approach, &sensitivity_(begin + i, ColumnOf(*candidate)),
                                                      sensitivity_.outerStride());
          for (int b = 0; b < width; ++b) columns(i, at + b) = basis(i, b) * along;
        }
        at += width;
        continue;
      }
      const auto sensitivity = sensitivity_.col(ColumnOf(*candidate)).segment(begin, count);
      for (int b = 0; b < width; ++b) columns.col(at + b) = basis.col(b).cwiseProduct(sensitivity);
    }
    at += width;
  }
}

void Signatures::SumColumns(const std::vector<const Candidate*>& candidates,
                            const std::vector<Projection*>& projections, Eigen::MatrixXd* coefficients) const {
  ForEachBlock(candidates, coefficients->cols(), [&](const Series& rows, int first, const auto& whitened) {
    nuisance_.Accumulate(rows.group, first, whitened, coefficients);
    const Eigen::VectorXd right = whitened.transpose() * residual_.segment(first, whitened.rows());
    Eigen::Index at = 0;
    for (size_t i = 0; i < candidates.size(); ++i) {
      const int own = ColumnsOf(*candidates[i]);
      for (int a = 0; a < own; ++a) {
        projections[i]->with_residual[a] += right[at + a];
        for (int b = 0; b <= a; ++b) projections[i]->own(a, b) += whitened.col(at + a).dot(whitened.col(at + b));
      }
      at += own;
    }
  });
}

void Signatures::ProjectFully(const std::vector<const Candidate*>& candidates,
                              const std::vector<Projection*>& projections) const {
  // Squares of sigmas per mm or rad: a turn about the line through the point, and nothing more.
  constexpr double kRounding = 1e-6;
  Eigen::Index width = 0;
  for (const Candidate* candidate : candidates) width += ColumnsOf(*candidate);
  Eigen::MatrixXd coefficients = Eigen::MatrixXd::Zero(nuisance_.size(), width);
  for (Projection* out : projections) *out = {};
  const bool are_slips = candidates.front()->family == Family::kStep;
  are_slips ? SumSlips(candidates, projections, &coefficients) : SumColumns(candidates, projections, &coefficients);
  nuisance_.Finish(&coefficients);
  Eigen::Index at = 0;
  for (size_t i = 0; i < candidates.size(); ++i) {
    Projection& out = *projections[i];
    out.columns = ColumnsOf(*candidates[i]);
    Eigen::Vector3d visible = Eigen::Vector3d::Zero();
    for (int a = 0; a < out.columns; ++a) {
      for (int b = 0; b <= a; ++b) {
        const double squares = out.own(a, b);
        out.own(a, b) = out.own(b, a) = squares - coefficients.col(at + a).dot(coefficients.col(at + b));
        if (a == b && squares > kRounding) visible[a] = out.own(a, a) / squares;
      }
    }
    at += out.columns;
    const bool is_slip = candidates[i]->family == Family::kStep;
    out.visible = is_slip ? visible.maxCoeff() : visible.head(out.columns).minCoeff();
    for (int a = 0; is_slip && a < out.columns; ++a) {
      if (visible[a] <= kVisible) LeaveOut(a, &out);
      out.own(a, a) += 1.0 / (instruments::kSlipSigmaMm * instruments::kSlipSigmaMm);  // as in the fit
    }
  }
}

std::vector<double> Signatures::CorrelationsWith(const Candidate& reference,
                                                 const std::vector<Candidate>& candidates) const {
  constexpr Eigen::Index kColumnsAtOnce = 96;
  const Eigen::Index m = ColumnsOf(reference);
  std::vector<double> correlations;
  while (correlations.size() < candidates.size()) {
    std::vector<const Candidate*> some = {&reference};
    Eigen::Index width = m;
    for (size_t i = correlations.size(); i < candidates.size() && width < kColumnsAtOnce; ++i) {
      some.push_back(&candidates[i]);
      width += ColumnsOf(candidates[i]);
    }
    // Inner products after projection: of each with itself, of the reference with all.
    std::vector<Eigen::MatrixXd> own;
    for (const Candidate* one : some) own.push_back(Eigen::MatrixXd::Zero(ColumnsOf(*one), ColumnsOf(*one)));
    Eigen::MatrixXd with_reference = Eigen::MatrixXd::Zero(m, width);
    const auto add = [&](const auto& columns, double sign) {
      with_reference.noalias() += sign * columns.leftCols(m).transpose() * columns;
      Eigen::Index at = 0;
      for (Eigen::MatrixXd& gram : own) {
        const auto its = columns.middleCols(at, gram.cols());
        gram.noalias() += sign * its.transpose() * its;
        at += gram.cols();
      }
    };
    Eigen::MatrixXd coefficients = Eigen::MatrixXd::Zero(nuisance_.size(), width);
    ForEachBlock(some, width, [&](const Series& rows, int first, const auto& whitened) {
      nuisance_.Accumulate(rows.group, first, whitened, &coefficients);
      add(whitened, 1.0);
    });
    nuisance_.Finish(&coefficients);
    add(coefficients, -1.0);
    const Eigen::MatrixXd root = InverseRoot(own[0]);
    Eigen::Index at = m;
    for (size_t i = 1; i < own.size(); ++i) {
      const Eigen::Index n = own[i].cols();
      const Eigen::MatrixXd cross = root.transpose() * with_reference.middleCols(at, n) * InverseRoot(own[i]);
      correlations.push_back(Eigen::JacobiSVD<Eigen::MatrixXd>(cross).singularValues()[std::min(m, n) - 1]);
      at += n;
    }
  }
  return correlations;
}

double Signatures::RmsOf(const Candidate& candidate, const Eigen::Ref<const Eigen::VectorXd>& amplitude) const {
  Eigen::MatrixXd columns(row_count(), ColumnsOf(candidate));
  FillRaw({&candidate}, 0, columns);
  return row_count() > 0
             ? (columns * amplitude.head(columns.cols())).norm() / std::sqrt(static_cast<double>(row_count()))
             : 0.0;
}

Eigen::MatrixXd Signatures::SensitivitySquares() const {
  Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(problem_.runs.size()), sensitivity_.cols());
  for (int row = 0; row < row_count(); ++row)
    squares.row(run_[row]) += weight_[row] * weight_[row] * sensitivity_.row(row).cwiseAbs2();
  return squares;
}

double Signatures::LargestValue(const machine::ErrorTerm& term, const Eigen::Vector3d& amplitude) const {
  constexpr int kLooks = 100;
  double largest = 0.0, basis[shapes::kMaxBasisCount];
  for (int row = 0; row < row_count(); row += std::max(1, row_count() / kLooks)) {
    shapes::Basis(term.shape, StateAt(row), basis);
    double value = 0.0;
    for (int b = 0; b < shapes::BasisCount(term.shape); ++b) value += amplitude[b] * basis[b];
    largest = std::max(largest, std::abs(value));
  }
  return largest;
}

}  // namespace axiscal::loop
