#include "core/identify/row_weights.h"

#include <Eigen/Eigenvalues>

#include "core/instruments/evaluation.h"

namespace axiscal::identify {
namespace {

using instruments::MeasuringRun;

std::vector<const Source*> SourcesOfReadings(const Budget& budget, const std::string& session) {
  std::vector<const Source*> sources;
  for (const Source& source : budget.sources) {
    if (source.drawn_per == DrawnPer::kReading && source.ActsIn(session)) sources.push_back(&source);
  }
  return sources;
}

// Covariance of the rows of one reading over sigma^2.
RowWeight RelativeCovariance(const std::vector<const Source*>& sources, const MeasuringRun& run, double sigma_mm,
                             const shapes::State& state, const instruments::Evaluation& evaluation) {
  RowWeight covariance = RowWeight::Identity(run.row_count, run.row_count);
  for (const Source* const source : sources) {
    const double share = source->sigma() / sigma_mm;
    if (source->is_reading) {
      covariance.diagonal().array() += share * share;
      continue;
    }
    const int column = machine::kComponents * source->term.joint + static_cast<int>(source->term.component);
    double basis[shapes::kMaxBasisCount];
    shapes::Basis(source->term.shape, state, basis);
    for (int i = 0; i < shapes::BasisCount(source->term.shape); ++i) {
      const Eigen::VectorXd rows = evaluation.by_error.col(column) * (basis[i] * share);
      covariance += rows * rows.transpose();
    }
  }
  return covariance;
}

}  // namespace

void WeighRows(const Budget& budget, const machine::ErrorModel& model, Problem* problem) {
  const Point point = StartingPoint(*problem, model);
  problem->row_weights.assign(problem->runs.size(), {});
  for (size_t i = 0; i < problem->runs.size(); ++i) {
    const MeasuringRun& run = problem->runs[i];
    const std::vector<const Source*> sources = SourcesOfReadings(budget, run.session);
    if (sources.empty()) continue;
    instruments::Evaluation evaluation;
    for (int k = 0; k < run.reading_count(); ++k) {
      const shapes::State state = run.StateOf(k);
      instruments::Evaluate(*problem->machine, run, k, machine::ErrorsAt(*problem->machine, model, state),
                            point.setup[problem->group_of_run[i]].data(), &evaluation);
      const RowWeight covariance = RelativeCovariance(sources, run, problem->noise[i].sigma_mm, state, evaluation);
      problem->row_weights[i].push_back(Eigen::SelfAdjointEigenSolver<RowWeight>(covariance).operatorInverseSqrt());
    }
  }
}

}  // namespace axiscal::identify
