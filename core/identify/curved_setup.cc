#include "core/identify/curved_setup.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

#include "core/identify/errors_of_run.h"
#include "core/identify/rows.h"
#include "core/identify/whitening.h"
#include "core/instruments/distortion.h"

namespace axiscal::identify {
namespace {

using instruments::MeasuringRun;

// Offsets of a group that rest on their weak prior.
std::vector<int> RestingOnPrior(const Problem& problem, size_t group, const Covariance& covariance) {
  constexpr double kHalf = 0.5;
  std::vector<int> offsets;
  if (problem.runs[problem.groups[group].runs[0]].kind != instruments::Kind::kTouch) return offsets;
  const int own = instruments::OwnSetupCount(problem.runs[problem.groups[group].runs[0]]);
  for (int i = 0; i < own; ++i) {
    const instruments::SetupParameter& parameter = problem.groups[group].parameters[static_cast<size_t>(i)];
    if (!parameter.is_weak || parameter.held || !std::isfinite(parameter.prior_sigma)) continue;
    if (covariance.setup_sigma[group][i] > kHalf * parameter.prior_sigma) offsets.push_back(i);
  }
  return offsets;
}

// Takes the rows of a run (VisitRows) and sums J' D. Column q of D is what u_k u_j does to a reading, the offsets being
// `root` u beside the solution; pairs k <= j in the order (0, 0), (0, 1) ... (1, 1) ...
class CurvatureSink {
 public:
  CurvatureSink(const SolvedProblem& solved, int run, const Eigen::MatrixXd& root)
      : problem_(solved.problem),
        run_(run),
        setup_(solved.solution.linearised.setup[solved.problem.group_of_run[run]]),
        root_(root),
        errors_(problem_, solved.solution.linearised),
        parameters_(static_cast<Eigen::Index>(solved.parameters.size())),
        row_(setup_.size() + parameters_ + 1 + Pairs()),
        whiteners_(Run().row_count, SeriesWhitener(problem_.noise[run], row_.size())),
        sum_(Eigen::MatrixXd::Zero(setup_.size() + parameters_, Pairs())) {}

  Eigen::VectorBlock<Eigen::RowVectorXd> NextRow() { return row_.head(row_.size()); }

  template <typename Row>
  void Close(int reading, int r, const instruments::Evaluation&, Row& row) {
    if (reading != evaluated_) EvaluateMoved(reading);
    row.tail(Pairs()) = curvature_.row(r);
    whiteners_[static_cast<size_t>(r)].Apply(reading, row);
    const Eigen::Index unknowns = setup_.size() + parameters_;
    sum_.noalias() += row.head(unknowns).transpose() * row.tail(Pairs());
  }

  const Eigen::MatrixXd& sum() const { return sum_; }

 private:
  const MeasuringRun& Run() const { return problem_.runs[static_cast<size_t>(run_)]; }
  Eigen::Index Pairs() const { return root_.cols() * (root_.cols() + 1) / 2; }

  // Central differences of the exact first derivatives, over a standard uncertainty to either side.
  void EvaluateMoved(int reading) {
    evaluated_ = reading;
    const Eigen::Index m = root_.cols();
    curvature_.setZero(Run().row_count, Pairs());
    const RowWeight* const weight = problem_.WeightOf(static_cast<size_t>(run_), reading);
    std::vector<Eigen::MatrixXd> by_pair;
    for (Eigen::Index k = 0; k < m; ++k) {
      Eigen::MatrixXd change = BySetup(reading, setup_ + root_.col(k)) - BySetup(reading, setup_ - root_.col(k));
      if (weight != nullptr) change = *weight * change;
      by_pair.push_back(0.5 * change * root_);
    }
    Eigen::Index column = 0;
    for (Eigen::Index k = 0; k < m; ++k) {
      for (Eigen::Index j = k; j < m; ++j, ++column)
        curvature_.col(column) = (k == j ? 0.5 : 1.0) * by_pair[static_cast<size_t>(k)].col(j);
    }
  }

  Eigen::MatrixXd BySetup(int reading, const Eigen::VectorXd& setup) {
    const auto errors_at = [&](const shapes::State& at) -> const machine::JointErrors<double>& {
      return errors_.At(at);
    };
    if (Run().path_readings != nullptr) {
      instruments::EvaluateAlongPath(*problem_.machine, Run(), reading, errors_at, setup.data(), &evaluation_,
                                     [](const shapes::State&, const instruments::Evaluation&, double) {});
    } else {
      instruments::Evaluate(*problem_.machine, Run(), reading, errors_at(Run().StateOf(reading)), setup.data(),
                            &evaluation_);
    }
    return evaluation_.by_setup;
  }

  const Problem& problem_;
  const int run_;
  const Eigen::VectorXd& setup_;
  const Eigen::MatrixXd& root_;  // setup offsets x unknowns u
  ErrorsOfRun errors_;
  const Eigen::Index parameters_;
  Eigen::RowVectorXd row_;
  std::vector<SeriesWhitener> whiteners_;
  Eigen::MatrixXd curvature_, sum_;
  instruments::Evaluation evaluation_;
  int evaluated_ = -1;
};

// A square root of the covariance of `offsets`, with rows for all offsets of the group.
Eigen::MatrixXd RootOf(const Eigen::MatrixXd& covariance, const std::vector<int>& offsets) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance(offsets, offsets));
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(covariance.rows(), static_cast<Eigen::Index>(offsets.size()));
  root(offsets, Eigen::all) = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  return root;
}

}  // namespace

Eigen::MatrixXd CurvedSetupCovariance(const SolvedProblem& solved, const Covariance& covariance) {
  const Problem& problem = solved.problem;
  const auto p = static_cast<Eigen::Index>(solved.parameters.size());
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(p, p);
  for (size_t g = 0; g < problem.groups.size(); ++g) {
    const std::vector<int> offsets = RestingOnPrior(problem, g, covariance);
    if (offsets.empty()) continue;
    const Eigen::MatrixXd root = RootOf(covariance.setup[g], offsets);
    const Eigen::Index m = root.cols(), pairs = m * (m + 1) / 2;
    std::vector<Eigen::MatrixXd> by_change;
    for (const SetupGroup& group : problem.groups)
      by_change.push_back(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(group.parameters.size()) + p, pairs));
    for (const int run : problem.groups[g].runs) {
      CurvatureSink sink(solved, run, root);
      VisitRows(problem, run, solved.solution.linearised, solved.parameters, &sink);
      by_change[g] += sink.sum();
    }
    const Eigen::MatrixXd moves =
        StepsOf(problem, solved.solution.linearised, solved.solution.normal, solved.held, by_change)[g];
    // Of u' Q u with u ~ N(0, 1): entry (k, k) of Q is column (k, k), (k, j) half of column (k, j).
    Eigen::VectorXd means = Eigen::VectorXd::Zero(p);
    Eigen::Index column = 0;
    for (Eigen::Index k = 0; k < m; ++k) {
      for (Eigen::Index j = k; j < m; ++j, ++column) {
        const Eigen::VectorXd move = moves.col(column);
        if (k == j) means += move;
        out += (k == j ? 2.0 : 1.0) * move * move.transpose();
      }
    }
    out += means * means.transpose();
  }
  return out;
}

}  // namespace axiscal::identify
