#include "core/loop/signatures.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/instruments/evaluation.h"

namespace axiscal::loop {
namespace {

using instruments::MeasuringRun;

// B with B' G B = 1 on the space that G sees.
Eigen::MatrixXd InverseRoot(const Eigen::MatrixXd& gram) {
  const Eigen::Index n = gram.rows();
  Eigen::VectorXd scale(n);
  for (Eigen::Index i = 0; i < n; ++i) scale[i] = gram(i, i) > 0.0 ? 1.0 / std::sqrt(gram(i, i)) : 0.0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * gram * scale.asDiagonal());
  constexpr double kSeen = 1e-11;
  Eigen::VectorXd root(n);
  for (Eigen::Index i = 0; i < n; ++i)
    root[i] = eigen.eigenvalues()[i] > kSeen ? 1.0 / std::sqrt(eigen.eigenvalues()[i]) : 0.0;
  return scale.asDiagonal() * eigen.eigenvectors() * root.asDiagonal();
}

double PriorPrecision(const instruments::SetupParameter& parameter) {
  return std::isfinite(parameter.prior_sigma) ? 1.0 / (parameter.prior_sigma * parameter.prior_sigma) : 0.0;
}

}  // namespace

Signatures::Signatures(const identify::Problem& problem, const identify::Point& point,
                       const std::vector<identify::Parameter>& parameters)
    : problem_(problem) {
  const machine::Machine& machine = *problem.machine;
  int setup_width = 3;
  for (const identify::SetupGroup& group : problem.groups)
    setup_width = std::max<int>(setup_width, static_cast<int>(group.parameters.size()));
  int count = 0;
  for (const auto& used : problem.is_used) count += static_cast<int>(std::count(used.begin(), used.end(), true));
  const int p = static_cast<int>(parameters.size());
  weight_.resize(count);
  correlation_.setZero(count);
  sensitivity_.resize(count, machine::kComponents * machine.joint_count());
  setup_raw_.resize(count, 3);
  setup_ = Eigen::MatrixXd::Zero(count, setup_width);
  errors_.resize(count, p);
  residual_.resize(count);
  run_.resize(count);
  reading_.resize(count);

  machine::ErrorModel model = point.model;
  model.terms.insert(model.terms.end(), problem.fixed_model.terms.begin(), problem.fixed_model.terms.end());
  int first = 0;
  instruments::Evaluation evaluation;
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const MeasuringRun& run = problem.runs[i];
    const int group = problem.group_of_run[i], s = static_cast<int>(run.setup.size());
    // Rows of one series stand together, so that the neighbour in time is the row above.
    std::vector<int> next(run.row_count, first), last_reading(run.row_count, -1);
    for (int row = 1; row < run.row_count; ++row) {
      next[row] = next[row - 1];
      for (int k = 0; k < run.reading_count(); ++k)
        next[row] += problem.is_used[i][static_cast<size_t>(k) * run.row_count + row - 1];
    }
    for (int k = 0; k < run.reading_count(); ++k) {
      const shapes::State state = run.StateOf(k);
      instruments::Evaluate(machine, run, k, machine::ErrorsAt(machine, model, state), point.setup[group].data(),
                            &evaluation);
      for (int row = 0; row < run.row_count; ++row) {
        if (!problem.is_used[i][static_cast<size_t>(k) * run.row_count + row]) continue;
        const int at = next[row]++;
        run_[at] = static_cast<int>(i);
        reading_[at] = k;
        const double correlation = last_reading[row] < 0 ? 0.0 : std::pow(problem.noise[i].ar1, k - last_reading[row]);
        correlation_[at] = correlation;
        weight_[at] = 1.0 / (problem.noise[i].sigma_mm * std::sqrt(1.0 - correlation * correlation));
        last_reading[row] = k;
        sensitivity_.row(at) = evaluation.by_error.row(row);
        setup_raw_.row(at) = evaluation.by_setup.row(row).head<3>();
        setup_.row(at).head(s) = evaluation.by_setup.row(row);
        residual_[at] = evaluation.predicted_mm[row] - run.measured_mm(row, k);
        double values[shapes::kMaxBasisCount];
        for (int j = 0; j < p; ++j) {
          const machine::ErrorTerm& term = point.model.terms[parameters[j].term];
          const int column = machine::kComponents * term.joint + static_cast<int>(term.component);
          double slope = 0.0;
          if (parameters[j].is_nonlinear) {
            shapes::BasisSlope(term.shape, state, values);
            for (int b = 0; b < shapes::BasisCount(term.shape); ++b) slope += term.amplitude[b] * values[b];
          } else {
            shapes::Basis(term.shape, state, values);
            slope = values[parameters[j].basis];
          }
          errors_(at, j) = evaluation.by_error(row, column) * slope;
        }
      }
    }
    const int end = next[run.row_count - 1];
    rows_.push_back({first, end, group});
    first = end;
  }
  Whiten(setup_);
  Whiten(errors_);
  Whiten(residual_);

  // Orthonormal nuisance basis: per group the setups with their priors' rows, then the errors beside them.
  const int groups = static_cast<int>(problem.groups.size());
  std::vector<Eigen::MatrixXd> gram(groups);
  for (int g = 0; g < groups; ++g) {
    const int s = static_cast<int>(problem.groups[g].parameters.size());
    gram[g] = Eigen::MatrixXd::Zero(s, s);
    for (int k = 0; k < s; ++k) gram[g](k, k) = PriorPrecision(problem.groups[g].parameters[k]);
  }
  for (const Rows& rows : rows_) {
    const int s = static_cast<int>(gram[rows.group].rows());
    const auto block = setup_.block(rows.begin, 0, rows.end - rows.begin, s);
    gram[rows.group] += block.transpose() * block;
  }
  Eigen::MatrixXd reduced = errors_.transpose() * errors_;
  setup_error_.resize(groups);
  for (int g = 0; g < groups; ++g) {
    setup_basis_.push_back(InverseRoot(gram[g]));
    setup_error_[g] = Eigen::MatrixXd::Zero(gram[g].rows(), p);
  }
  for (const Rows& rows : rows_) {
    const int n = rows.end - rows.begin, s = static_cast<int>(gram[rows.group].rows());
    setup_error_[rows.group] += setup_basis_[rows.group].transpose() *
                                (setup_.block(rows.begin, 0, n, s).transpose() * errors_.middleRows(rows.begin, n));
  }
  for (int g = 0; g < groups; ++g) reduced -= setup_error_[g].transpose() * setup_error_[g];
  error_basis_ = p > 0 ? InverseRoot(reduced) : Eigen::MatrixXd(0, 0);

  // The residual has prior rows too: offset / prior sigma.
  residual_nuisance_ = NuisanceOf(residual_);
  double squares = residual_.squaredNorm();
  Eigen::VectorXd prior_part = Eigen::VectorXd::Zero(residual_nuisance_.size());
  int at = 0;
  Eigen::VectorXd error_correction = Eigen::VectorXd::Zero(p);
  for (int g = 0; g < groups; ++g) {
    const int s = static_cast<int>(gram[g].rows());
    Eigen::VectorXd pull(s);
    for (int k = 0; k < s; ++k) {
      const double precision = PriorPrecision(problem.groups[g].parameters[k]);
      pull[k] = point.setup[g][k] * precision;
      squares += point.setup[g][k] * point.setup[g][k] * precision;
    }
    prior_part.segment(at, s) = setup_basis_[g].transpose() * pull;
    error_correction -= setup_error_[g].transpose() * prior_part.segment(at, s);
    at += s;
  }
  if (p > 0) prior_part.tail(p) = error_basis_.transpose() * error_correction;
  residual_nuisance_ += prior_part;
  residual_squares_ = squares - residual_nuisance_.squaredNorm();
  degrees_of_freedom_ = std::max(1, count - p);
}

int Signatures::ColumnsOf(const Candidate& candidate) const {
  return candidate.family == Family::kStep ? 3 : shapes::BasisCount(candidate.term.shape);
}

void Signatures::FillRaw(const Candidate& candidate, Eigen::Ref<Eigen::MatrixXd> columns) const {
  if (candidate.family == Family::kStep) {
    columns.setZero();
    const Rows& rows = rows_[candidate.run];
    for (int at = rows.begin; at < rows.end; ++at) {
      if (reading_[at] >= candidate.first_reading) columns.row(at).head<3>() = setup_raw_.row(at);
    }
    return;
  }
  const int column = machine::kComponents * candidate.term.joint + static_cast<int>(candidate.term.component);
  double values[shapes::kMaxBasisCount];
  const int count = shapes::BasisCount(candidate.term.shape);
  for (int at = 0; at < row_count(); ++at) {
    shapes::Basis(candidate.term.shape, problem_.runs[run_[at]].StateOf(reading_[at]), values);
    for (int b = 0; b < count; ++b) columns(at, b) = values[b] * sensitivity_(at, column);
  }
}

void Signatures::Whiten(Eigen::Ref<Eigen::MatrixXd> columns) const {
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    auto x = columns.col(c);
    for (Eigen::Index at = x.size() - 1; at > 0; --at) x[at] = weight_[at] * (x[at] - correlation_[at] * x[at - 1]);
    if (x.size() > 0) x[0] *= weight_[0];
  }
}

Eigen::MatrixXd Signatures::NuisanceOf(const Eigen::Ref<const Eigen::MatrixXd>& columns) const {
  const Eigen::Index width = columns.cols(), p = errors_.cols();
  Eigen::Index total = p;
  std::vector<Eigen::Index> offset;
  for (const Eigen::MatrixXd& basis : setup_basis_) {
    offset.push_back(total - p);
    total += basis.rows();
  }
  Eigen::MatrixXd raw = Eigen::MatrixXd::Zero(total, width);
  for (const Rows& rows : rows_) {
    const Eigen::Index s = setup_basis_[rows.group].rows(), n = rows.end - rows.begin;
    raw.middleRows(offset[rows.group], s).noalias() +=
        setup_.block(rows.begin, 0, n, s).transpose() * columns.middleRows(rows.begin, n);
  }
  for (size_t g = 0; g < setup_basis_.size(); ++g) {
    const Eigen::Index s = setup_basis_[g].rows();
    raw.middleRows(offset[g], s) = (setup_basis_[g].transpose() * raw.middleRows(offset[g], s)).eval();
  }
  if (p > 0) {
    Eigen::MatrixXd errors = errors_.transpose() * columns;
    for (size_t g = 0; g < setup_basis_.size(); ++g) {
      errors.noalias() -= setup_error_[g].transpose() * raw.middleRows(offset[g], setup_basis_[g].rows());
    }
    raw.bottomRows(p) = error_basis_.transpose() * errors;
  }
  return raw;
}

std::vector<Projection> Signatures::Project(const std::vector<Candidate>& candidates) const {
  std::vector<Projection> projections(candidates.size());
  constexpr int kBlock = 96;
  constexpr double kRounding =
      1e-6;  // squares of sigmas per mm or rad: a turn about the line through the point, and nothing more
  Eigen::MatrixXd columns(row_count(), kBlock + kMaxColumns);
  // Neighbouring candidates share a shape: its values are computed once for all components.
  Eigen::MatrixXd basis(row_count(), kMaxColumns);
  const shapes::Shape* basis_of = nullptr;
  for (size_t begin = 0; begin < candidates.size();) {
    int used = 0;
    size_t end = begin;
    while (end < candidates.size() && used < kBlock) {
      const Candidate& candidate = candidates[end];
      const int width = ColumnsOf(candidate);
      if (candidate.family == Family::kStep) {
        FillRaw(candidate, columns.middleCols(used, width));
      } else {
        if (basis_of == nullptr || !(*basis_of == candidate.term.shape)) {
          double values[shapes::kMaxBasisCount];
          for (int at = 0; at < row_count(); ++at) {
            shapes::Basis(candidate.term.shape, problem_.runs[run_[at]].StateOf(reading_[at]), values);
            for (int b = 0; b < width; ++b) basis(at, b) = values[b];
          }
          basis_of = &candidate.term.shape;
        }
        const int column = machine::kComponents * candidate.term.joint + static_cast<int>(candidate.term.component);
        for (int b = 0; b < width; ++b) columns.col(used + b) = basis.col(b).cwiseProduct(sensitivity_.col(column));
      }
      used += width;
      ++end;
    }
    Whiten(columns.leftCols(used));
    const Eigen::MatrixXd nuisance = NuisanceOf(columns.leftCols(used));
    const Eigen::VectorXd with_residual =
        columns.leftCols(used).transpose() * residual_ - nuisance.transpose() * residual_nuisance_;
    int at = 0;
    for (size_t i = begin; i < end; ++i) {
      Projection& out = projections[i];
      out.columns = ColumnsOf(candidates[i]);
      out.visible = 1.0;
      for (int a = 0; a < out.columns; ++a) {
        for (int b = 0; b <= a; ++b) {
          const double squares = columns.col(at + a).dot(columns.col(at + b));
          out.own(a, b) = out.own(b, a) = squares - nuisance.col(at + a).dot(nuisance.col(at + b));
          if (a == b) out.visible = std::min(out.visible, squares > kRounding ? out.own(a, a) / squares : 0.0);
        }
        out.with_residual[a] = with_residual[at + a];
      }
      at += out.columns;
    }
    begin = end;
  }
  return projections;
}

std::vector<double> Signatures::CorrelationsWith(const Candidate& reference,
                                                 const std::vector<Candidate>& candidates) const {
  const auto prepare = [this](const Candidate& candidate, Eigen::MatrixXd* columns, Eigen::MatrixXd* nuisance,
                              Eigen::MatrixXd* root) {
    *columns = Eigen::MatrixXd(row_count(), ColumnsOf(candidate));
    FillRaw(candidate, *columns);
    Whiten(*columns);
    *nuisance = NuisanceOf(*columns);
    *root = InverseRoot(columns->transpose() * *columns - nuisance->transpose() * *nuisance);
  };
  Eigen::MatrixXd columns, nuisance, root, other, other_nuisance, other_root;
  prepare(reference, &columns, &nuisance, &root);
  std::vector<double> correlations;
  for (const Candidate& candidate : candidates) {
    prepare(candidate, &other, &other_nuisance, &other_root);
    const Eigen::MatrixXd cross =
        root.transpose() * (columns.transpose() * other - nuisance.transpose() * other_nuisance) * other_root;
    const Eigen::VectorXd values = Eigen::JacobiSVD<Eigen::MatrixXd>(cross).singularValues();
    correlations.push_back(values.size() > 0 ? values[std::min(cross.rows(), cross.cols()) - 1] : 0.0);
  }
  return correlations;
}

double Signatures::RmsOf(const Candidate& candidate, const Eigen::Vector3d& amplitude) const {
  Eigen::MatrixXd columns(row_count(), ColumnsOf(candidate));
  FillRaw(candidate, columns);
  return row_count() > 0
             ? (columns * amplitude.head(columns.cols())).norm() / std::sqrt(static_cast<double>(row_count()))
             : 0.0;
}

}  // namespace axiscal::loop
