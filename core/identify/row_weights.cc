#include "core/identify/row_weights.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

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

// What a term of unit amplitude adds to the rows of a reading at a state.
Eigen::VectorXd RowsOf(const machine::ErrorTerm& unit, const shapes::State& state,
                       const instruments::Evaluation& evaluation) {
  machine::JointErrors<double> errors;
  machine::AddErrors(unit, state, &errors);
  return evaluation.by_error.middleCols(machine::kComponents * unit.joint, machine::kComponents) * errors[unit.joint];
}

// Rows of a reading, moved by one standard deviation of a source: column i by the term's basis function i.
Eigen::MatrixXd DeviationsOf(const Problem& problem, const MeasuringRun& run, int reading, const Source& source,
                             const machine::ErrorModel& model, const double* setup) {
  if (source.is_reading) return source.sigma() * Eigen::MatrixXd::Identity(run.row_count, run.row_count);
  const int count = shapes::BasisCount(source.term.shape);
  Eigen::MatrixXd deviations = Eigen::MatrixXd::Zero(run.row_count, count);
  const auto add = [&](const shapes::State& state, const instruments::Evaluation& evaluation, double weight) {
    for (int i = 0; i < count; ++i) {
      machine::ErrorTerm unit = source.term;
      unit.amplitude.fill(0.0);
      unit.amplitude[i] = weight * source.sigma();
      deviations.col(i) += RowsOf(unit, state, evaluation);
    }
  };
  machine::JointErrors<double> errors;
  const auto errors_at = [&](const shapes::State& state) -> const machine::JointErrors<double>& {
    return errors = machine::ErrorsAt(*problem.machine, model, state);
  };
  instruments::Evaluation evaluation;
  if (run.path_readings != nullptr) {
    instruments::EvaluateAlongPath(*problem.machine, run, reading, errors_at, setup, &evaluation, add);
    return deviations;
  }
  const shapes::State state = run.StateOf(reading);
  instruments::Evaluate(*problem.machine, run, reading, errors_at(state), setup, &evaluation);
  add(state, evaluation, 1.0);
  return deviations;
}

}  // namespace

void WeighRows(const Budget& budget, const machine::ErrorModel& model, Problem* problem) {
  const Point point = StartingPoint(*problem, model);
  problem->row_weights.assign(problem->runs.size(), {});
  for (size_t i = 0; i < problem->runs.size(); ++i) {
    const MeasuringRun& run = problem->runs[i];
    const std::vector<const Source*> sources = SourcesOfReadings(budget, run.session);
    if (sources.empty()) continue;
    const Eigen::VectorXd setup = SetupOf(*problem, point, i);
    const double sigma_mm = problem->noise[i].sigma_mm;
    const double own = budget.with_reading_noise ? 1.0 : 0.0;
    std::vector<RowWeight> covariances;
    double largest = 0.0;
    for (int k = 0; k < run.reading_count(); ++k) {
      RowWeight& covariance = covariances.emplace_back(RowWeight::Identity(run.row_count, run.row_count));
      covariance *= own;
      for (const Source* const source : sources) {
        const Eigen::MatrixXd deviations = DeviationsOf(*problem, run, k, *source, model, setup.data()) / sigma_mm;
        covariance += deviations * deviations.transpose();
      }
      largest = std::max(largest, covariance.diagonal().maxCoeff());
    }
    if (largest == 0.0) continue;
    // Along a direction that no source moves, readings without scatter of their own would weigh without limit.
    constexpr double kLeastShare = 1e-6;  // of the largest variance: a thousandth of the scatter
    for (RowWeight& covariance : covariances) {
      if (!budget.with_reading_noise) covariance.diagonal().array() += kLeastShare * largest;
      problem->row_weights[i].push_back(Eigen::SelfAdjointEigenSolver<RowWeight>(covariance).operatorInverseSqrt());
    }
  }
}

}  // namespace axiscal::identify
