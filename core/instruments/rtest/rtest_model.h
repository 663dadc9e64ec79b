// R-test (ISO 10791-6, Annex): three displacements of the tool's sphere against the table's sensor nest,
//   d = tool point - table ball, in the table's frame.
// Setup: table ball (x, y, z, table frame at home), mm.
#ifndef AXISCAL_CORE_INSTRUMENTS_RTEST_RTEST_MODEL_H_
#define AXISCAL_CORE_INSTRUMENTS_RTEST_RTEST_MODEL_H_

#include "core/instruments/evaluation.h"

namespace axiscal::rtest {

std::vector<instruments::SetupParameter> SetupParameters();

template <typename T, typename Errors = machine::JointErrors<T>>
void Predict(const machine::Machine& machine, const instruments::MeasuringRun& run, const T* positions,
             const Errors& errors, const T* setup, T* predicted_mm) {
  const machine::ChainPose<T> pose = machine::EvaluateChain<T>(machine, positions, errors);
  const geometry::Vector3<T> ball(run.ball_mm.x() + setup[0], run.ball_mm.y() + setup[1], run.ball_mm.z() + setup[2]);
  const geometry::Vector3<T> displacement = machine::TipInTable(pose, run.tip_mm) - ball;
  for (int k = 0; k < 3; ++k) predicted_mm[k] = displacement[k];
}

void Evaluate(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out);

}  // namespace axiscal::rtest

#endif  // AXISCAL_CORE_INSTRUMENTS_RTEST_RTEST_MODEL_H_
