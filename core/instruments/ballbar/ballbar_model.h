// Ball bar (ISO 230-4): one reading is the change of length between the tool ball and the table ball,
//   dL = |tool ball - table ball| - bar length.
// Setup: table ball (x, y, z, table frame at home), run-out of the tool ball (two directions across the tool), length
// of the bar; all mm.
#ifndef AXISCAL_CORE_INSTRUMENTS_BALLBAR_BALLBAR_MODEL_H_
#define AXISCAL_CORE_INSTRUMENTS_BALLBAR_BALLBAR_MODEL_H_

#include "core/instruments/evaluation.h"

namespace axiscal::ballbar {

std::vector<instruments::SetupParameter> SetupParameters();

// Unit directions of the run-out, across the tool, machine frame at home: x and y for a tool along z. Columns.
Eigen::Matrix<double, 3, 2> RunOutDirections(const machine::Machine& machine);

template <typename T, typename Errors = machine::JointErrors<T>>
void Predict(const machine::Machine& machine, const instruments::MeasuringRun& run, const T* positions,
             const Errors& errors, const T* setup, T* predicted_mm) {
  const machine::ChainPose<T> pose = machine::EvaluateChain<T>(machine, positions, errors);
  const Eigen::Matrix<double, 3, 2> across = RunOutDirections(machine);
  const geometry::Vector3<T> run_out = across.col(0).cast<T>() * setup[3] + across.col(1).cast<T>() * setup[4];
  const geometry::Vector3<T> ball_offset(setup[0], setup[1], setup[2]);
  const geometry::Vector3<T> tool_ball = pose.bed_from_tool * geometry::Vector3<T>(run.tip_mm.cast<T>() + run_out);
  const geometry::Vector3<T> table_ball =
      pose.bed_from_table * geometry::Vector3<T>(run.ball_mm.cast<T>() + ball_offset);
  predicted_mm[0] = (tool_ball - table_ball).norm() - (run.bar_length_mm + setup[5]);
}

void Evaluate(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out);

}  // namespace axiscal::ballbar

#endif  // AXISCAL_CORE_INSTRUMENTS_BALLBAR_BALLBAR_MODEL_H_
