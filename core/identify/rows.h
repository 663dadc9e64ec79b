// The linearised rows of one run: what the normal equations sum up and what the loop's signatures keep. One place that
// knows how an error term, a setup offset and a reading become a row.
#ifndef AXISCAL_CORE_IDENTIFY_ROWS_H_
#define AXISCAL_CORE_IDENTIFY_ROWS_H_

#include <vector>

#include "core/identify/errors_of_run.h"
#include "core/identify/problem.h"
#include "core/instruments/evaluation.h"

namespace axiscal::identify {

// Where in Evaluation::by_error each parameter of a model acts.
class ParameterColumns {
 public:
  ParameterColumns(const machine::ErrorModel& model, const std::vector<Parameter>& parameters) {
    for (const Parameter& parameter : parameters) {
      const machine::ErrorTerm& term = model.terms[parameter.term];
      column_.push_back(machine::kComponents * term.joint + static_cast<int>(term.component));
      is_along_approach_.push_back(shapes::IsAlongApproach(term.shape));
    }
  }

  int operator[](size_t i) const { return column_[i]; }
  // d(row r)/d(parameter i), mm per mm or rad. `slopes`: ErrorsOfRun's at `state`.
  double Slope(const instruments::Evaluation& evaluation, int r, const shapes::State& state,
               const Eigen::VectorXd& slopes, size_t i) const {
    const double* const by_error = &evaluation.by_error(r, column_[i]);
    const double slope = slopes[static_cast<Eigen::Index>(i)];
    if (!is_along_approach_[i]) return *by_error * slope;
    return machine::AlongApproach(state.approach, by_error, evaluation.by_error.outerStride()) * slope;
  }

 private:
  std::vector<int> column_;
  std::vector<bool> is_along_approach_;
};

// Which readings of a run are visited, of every `period` the first `stretch`: all of them where both are the same.
struct ReadingSample {
  int stretch = 1, period = 1;

  bool Has(int reading) const { return reading % period < stretch; }
  // The reading before a stretch is not known, so that the first of it is not whitened as it would be.
  bool IsFirstOfStretch(int reading) const { return stretch < period && reading % period == 0; }
};

// Setup offsets of a run's group.
inline int SetupCount(const Problem& problem, int run) {
  return static_cast<int>(problem.groups[static_cast<size_t>(problem.group_of_run[run])].parameters.size());
}

// VisitRows for readings taken along a path (eccentricities): each is a sum over states, and so are its slopes.
template <typename Sink>
void VisitPathRows(const Problem& problem, int run_index, const Point& point, const std::vector<Parameter>& parameters,
                   const ParameterColumns& column, const ReadingSample& sample, Sink* sink) {
  const instruments::MeasuringRun& run = problem.runs[run_index];
  const Eigen::VectorXd setup = SetupOf(problem, point, static_cast<size_t>(run_index));
  const std::vector<Eigen::Index>& offsets = problem.offsets_of_run[static_cast<size_t>(run_index)];
  const int setup_count = SetupCount(problem, run_index), count = static_cast<int>(parameters.size());
  ErrorsOfRun errors_of_run(problem, point, parameters);
  const Eigen::VectorXd& slopes = errors_of_run.slopes();
  Eigen::VectorXd by_parameter(count);
  instruments::Evaluation evaluation;
  for (int k = 0; k < run.reading_count(); ++k) {
    if (!sample.Has(k) || !problem.is_used[run_index][k]) continue;
    by_parameter.setZero();
    instruments::EvaluateAlongPath(
        *problem.machine, run, k,
        [&](const shapes::State& state) -> const machine::JointErrors<double>& { return errors_of_run.At(state); },
        setup.data(), &evaluation,
        // Along a path nothing is touched: terms along an approach have no part.
        [&](const shapes::State&, const instruments::Evaluation& one, double weight) {
          for (int i = 0; i < count; ++i) by_parameter[i] += weight * one.by_error(0, column[i]) * slopes[i];
        });
    const RowWeight* const weight = problem.WeightOf(run_index, k);
    const double scale = weight != nullptr ? (*weight)(0, 0) : 1.0;
    evaluation.by_error *= scale;
    auto row = sink->NextRow();
    row.head(setup_count).setZero();
    row(offsets) = scale * evaluation.by_setup.row(0);
    // Of terms that are alike all along the path, what cancels is zero.
    for (int i = 0; i < count; ++i)
      row[setup_count + i] = errors_of_run.is_constant() ? evaluation.by_error(0, column[i]) : scale * by_parameter[i];
    row[setup_count + count] = scale * (evaluation.predicted_mm[0] - run.measured_mm(0, k));
    sink->Close(k, 0, evaluation, row);
  }
}

// For every used row of the readings of `sample` of a run in time order: `sink.NextRow()` gives the storage of one row,
// which is filled with
//   setup offsets of the run's group | errors (`parameters`) | predicted - measured           mm per mm or rad; mm
// and handed back, raw, by `sink.Close(reading, row, evaluation, stored row)`. Rows start at the front of the storage.
template <typename Sink>
void VisitRows(const Problem& problem, int run_index, const Point& point, const std::vector<Parameter>& parameters,
               Sink* sink, const ReadingSample& sample = {}) {
  const instruments::MeasuringRun& run = problem.runs[run_index];
  const machine::Machine& machine = *problem.machine;
  const Eigen::VectorXd setup = SetupOf(problem, point, static_cast<size_t>(run_index));
  const std::vector<Eigen::Index>& offsets = problem.offsets_of_run[static_cast<size_t>(run_index)];
  const int setup_count = SetupCount(problem, run_index), count = static_cast<int>(parameters.size());
  const ParameterColumns column(point.model, parameters);
  ErrorsOfRun errors_of_run(problem, point, parameters);
  const Eigen::VectorXd& slopes = errors_of_run.slopes();
  instruments::Evaluation evaluation;
  if (run.path_readings != nullptr) {
    VisitPathRows(problem, run_index, point, parameters, column, sample, sink);
    return;
  }
  for (int k = 0; k < run.reading_count(); ++k) {
    if (!sample.Has(k)) continue;
    const shapes::State state = run.StateOf(k);
    const machine::JointErrors<double>& errors = errors_of_run.At(state);
    instruments::Evaluate(machine, run, k, errors, setup.data(), &evaluation);
    instruments::Reading residual_mm = evaluation.predicted_mm - run.measured_mm.col(k);
    if (const RowWeight* const weight = problem.WeightOf(run_index, k)) {
      residual_mm = *weight * residual_mm;
      evaluation.by_error = *weight * evaluation.by_error;
      evaluation.by_setup = *weight * evaluation.by_setup;
    }
    for (int r = 0; r < run.row_count; ++r) {
      if (!problem.is_used[run_index][static_cast<size_t>(k) * run.row_count + r]) continue;
      auto row = sink->NextRow();
      row.head(setup_count).setZero();
      row(offsets) = evaluation.by_setup.row(r);
      for (int i = 0; i < count; ++i) row[setup_count + i] = column.Slope(evaluation, r, state, slopes, i);
      row[setup_count + count] = residual_mm[r];
      sink->Close(k, r, evaluation, row);
    }
  }
}

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_ROWS_H_
