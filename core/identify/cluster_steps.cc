#include "core/identify/cluster_steps.h"

#include <algorithm>

#include "core/identify/rows.h"
#include "core/identify/whitening.h"

namespace axiscal::identify {
namespace {

// Takes the rows of a run (VisitRows) and sums J' r of each of its clusters: a column each.
class ClusterSink {
 public:
  ClusterSink(const Problem& problem, int run, Eigen::Index parameters)
      : readings_(problem.runs[run].reading_count()),
        row_(parameters + 1),
        whiteners_(problem.runs[run].row_count, SeriesWhitener(problem.noise[run], parameters + 1)),
        sums_(Eigen::MatrixXd::Zero(parameters, std::min(kClustersPerRun, readings_))) {}

  Eigen::VectorBlock<Eigen::RowVectorXd> NextRow() { return row_.head(row_.size()); }

  template <typename Row>
  void Close(int reading, int r, const instruments::Evaluation&, Row& row) {
    whiteners_[static_cast<size_t>(r)].Apply(reading, row);
    const Eigen::Index p = sums_.rows();
    sums_.col(static_cast<Eigen::Index>(int64_t{reading} * sums_.cols() / readings_)) +=
        row[p] * row.head(p).transpose();
  }

  const Eigen::MatrixXd& sums() const { return sums_; }

 private:
  const int readings_;
  Eigen::RowVectorXd row_;
  std::vector<SeriesWhitener> whiteners_;
  Eigen::MatrixXd sums_;
};

}  // namespace

Eigen::MatrixXd ClusterSteps(const SolvedProblem& solved) {
  const Problem& problem = solved.problem;
  const auto p = static_cast<Eigen::Index>(solved.parameters.size());
  std::vector<Eigen::MatrixXd> by_change;
  for (const SetupGroup& group : problem.groups) {
    const Eigen::Index rows = static_cast<Eigen::Index>(group.parameters.size()) + p;
    Eigen::MatrixXd& sums = by_change.emplace_back(rows, 0);
    for (const int run : group.runs) {
      ClusterSink sink(problem, run, rows);
      VisitRows(problem, run, solved.solution.point, solved.parameters, &sink);
      const Eigen::Index before = sums.cols();
      sums.conservativeResize(Eigen::NoChange, before + sink.sums().cols());
      sums.rightCols(sink.sums().cols()) = sink.sums();
    }
  }
  const std::vector<Eigen::MatrixXd> of_group =
      StepsOf(problem, solved.solution.point, solved.solution.normal, solved.held, by_change);
  Eigen::Index count = 0;
  for (const Eigen::MatrixXd& steps : of_group) count += steps.cols();
  Eigen::MatrixXd all(p, count);
  Eigen::Index at = 0;
  for (const Eigen::MatrixXd& steps : of_group) {
    all.middleCols(at, steps.cols()) = steps;
    at += steps.cols();
  }
  return all;
}

Eigen::VectorXd DesignEffects(const SolvedProblem& solved, const Eigen::VectorXd& variance, int degrees_of_freedom) {
  // What the fit took from the residuals is given back, as in their own variance.
  const double given_back = static_cast<double>(solved.solution.normal.row_count) / std::max(1, degrees_of_freedom);
  const Eigen::VectorXd shown = given_back * ClusterSteps(solved).rowwise().squaredNorm();
  Eigen::VectorXd effects = Eigen::VectorXd::Ones(shown.size());
  for (Eigen::Index i = 0; i < shown.size(); ++i)
    if (variance[i] > 0.0) effects[i] = std::max(1.0, shown[i] / variance[i]);
  return effects;
}

}  // namespace axiscal::identify
