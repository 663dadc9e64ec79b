// The reading that an instrument would give: reading = h(state; machine errors, setup) (design.md, "One measurement
// equation").
#ifndef AXISCAL_CORE_INSTRUMENTS_EVALUATION_H_
#define AXISCAL_CORE_INSTRUMENTS_EVALUATION_H_

#include "core/instruments/run.h"
#include "core/machine/chain.h"
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

// The prediction alone, row_count values, templated for automatic derivatives (in instruments' headers; instantiated
// for double here).
void Predict(const machine::Machine& machine, const MeasuringRun& run, int reading,
             const machine::JointErrors<double>& errors, const double* setup, double* predicted_mm);

}  // namespace axiscal::instruments

#endif  // AXISCAL_CORE_INSTRUMENTS_EVALUATION_H_
