// The reading that an instrument would give: reading = h(state; machine errors, setup). One function for all
// instruments and all uses (docs/architecture.md).
#ifndef AXISCAL_CORE_INSTRUMENTS_EVALUATION_H_
#define AXISCAL_CORE_INSTRUMENTS_EVALUATION_H_

#include <cmath>

#include "core/instruments/run.h"
#include "core/machine/chain.h"
#include "core/machine/joint_transforms.h"
#include "core/machine/sensitivity.h"

namespace axiscal::instruments {

using Reading = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxRows, 1>;  // row_count, mm

struct Evaluation {
  Reading predicted_mm;
  // row_count x 6 joint_count, column 6 j + c: d(predicted) per component c of joint j, mm per mm or rad.
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxRows,
                machine::kComponents * machine::kMaxJoints>
      by_error;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxRows, kMaxSetupParameters> by_setup;
  machine::RelativePoint point;  // working storage
};

// Predicted reading and its exact derivatives at the given errors and setup offsets (run.setup's order, mm and rad).
void Evaluate(const machine::Machine& machine, const MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, Evaluation* out);

// A reading that is taken along a path (run.path_readings) is a weighted sum of the ball bar's readings there, each
// with the errors of its own state, `errors_at(state)`. `visit(state, evaluation, weight)` is called for each. `out`
// is the sum. Derivatives that cancel along the path but for rounding are set to zero: the error moves no reading.
template <typename ErrorsAt, typename Visit>
void EvaluateAlongPath(const machine::Machine& machine, const MeasuringRun& run, int reading, ErrorsAt errors_at,
                       const double* setup, Evaluation* out, Visit visit) {
  const eccentricity::Reading& of = run.path_readings->readings[reading];
  const MeasuringRun& trace = run.path_readings->traces[of.trace];
  Evaluation one;
  Eigen::RowVectorXd by_error_size, by_setup_size;
  for (int n = 0; n < trace.reading_count(); ++n) {
    const shapes::State state = trace.StateOf(n);
    Evaluate(machine, trace, n, errors_at(state), setup, &one);
    visit(state, one, of.weight[n]);
    if (n == 0) {
      out->predicted_mm.setZero(1);
      out->by_error.setZero(1, one.by_error.cols());
      out->by_setup.setZero(1, one.by_setup.cols());
      by_error_size.setZero(one.by_error.cols());
      by_setup_size.setZero(one.by_setup.cols());
    }
    out->predicted_mm += of.weight[n] * one.predicted_mm;
    out->by_error += of.weight[n] * one.by_error;
    out->by_setup += of.weight[n] * one.by_setup;
    by_error_size += std::abs(of.weight[n]) * one.by_error.row(0).cwiseAbs();
    by_setup_size += std::abs(of.weight[n]) * one.by_setup.row(0).cwiseAbs();
  }
  constexpr double kRounding = 1e-9;  // of the commands' last digit and of a sum of hundreds
  for (Eigen::Index i = 0; i < by_error_size.size(); ++i)
    if (std::abs(out->by_error(0, i)) <= kRounding * by_error_size[i]) out->by_error(0, i) = 0.0;
  for (Eigen::Index i = 0; i < by_setup_size.size(); ++i)
    if (std::abs(out->by_setup(0, i)) <= kRounding * by_setup_size[i]) out->by_setup(0, i) = 0.0;
}

// The prediction alone, row_count values, templated for automatic derivatives (in instruments' headers; instantiated
// for double here).
void Predict(const machine::Machine& machine, const MeasuringRun& run, int reading,
             const machine::JointErrors<double>& errors, const double* setup, double* predicted_mm);
void Predict(const machine::Machine& machine, const MeasuringRun& run, int reading,
             const machine::JointTransforms& errors, const double* setup, double* predicted_mm);

// The prediction with the errors of the reading's own state, or along its path: `errors_at(state)` gives either form.
template <typename ErrorsAt>
void PredictWith(const machine::Machine& machine, const MeasuringRun& run, int reading, ErrorsAt errors_at,
                 const double* setup, double* predicted_mm) {
  if (run.path_readings == nullptr)
    return Predict(machine, run, reading, errors_at(run.StateOf(reading)), setup, predicted_mm);
  const eccentricity::Reading& of = run.path_readings->readings[reading];
  const MeasuringRun& trace = run.path_readings->traces[of.trace];
  predicted_mm[0] = 0.0;
  for (int n = 0; n < trace.reading_count(); ++n) {
    double one_mm = 0.0;
    Predict(machine, trace, n, errors_at(trace.StateOf(n)), setup, &one_mm);
    predicted_mm[0] += of.weight[n] * one_mm;
  }
}

}  // namespace axiscal::instruments

#endif  // AXISCAL_CORE_INSTRUMENTS_EVALUATION_H_
