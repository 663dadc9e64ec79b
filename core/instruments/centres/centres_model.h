// Sphere centres from a touch probe's cycle: at each rotary position the controller reports the nominal tool point,
// from axis positions and the coded tool, at which the real stylus centre meets the sphere's centre:
//   c = tool point turned by the rotary axes + linear motion of the tool - linear motion of the table, mm
// (Fang 2022, ch. 4; Yao 2022, ch. 5). Setup: the sphere (x, y, z, table frame at home), mm. A session holds rotary
// columns only; the linear commands follow from the condition that the two centres meet.
#ifndef AXISCAL_CORE_INSTRUMENTS_CENTRES_CENTRES_MODEL_H_
#define AXISCAL_CORE_INSTRUMENTS_CENTRES_CENTRES_MODEL_H_

#include <Eigen/LU>
#include <vector>

#include "core/instruments/evaluation.h"

namespace axiscal::centres {

std::vector<instruments::SetupParameter> SetupParameters();

// d(tool point - table point)/d(command) of each linear axis of the nominal machine, in the bed's axes: 3 x linear
// axes. Linear axes inside a rotary axis move along turned directions.
Eigen::Matrix3Xd LinearDirections(const machine::Machine& machine, const double* positions);
std::vector<int> LinearAxes(const machine::Machine& machine);

// Nominal linear commands at which the nominal tool point meets `ball_mm` at the given rotary positions.
// FAILED_PRECONDITION when the linear axes do not span three directions there.
absl::Status SolveNominalCommands(const machine::Machine& machine, const Eigen::Vector3d& tip_mm,
                                  const Eigen::Vector3d& ball_mm, double* positions);

template <typename T, typename Errors = machine::JointErrors<T>>
void Predict(const machine::Machine& machine, const instruments::MeasuringRun& run, const T* nominal_positions,
             const Errors& errors, const T* setup, T* predicted_mm) {
  std::vector<T> positions(nominal_positions, nominal_positions + machine.axis_count());
  std::vector<double> at(machine.axis_count());
  for (int i = 0; i < machine.axis_count(); ++i) {
    if constexpr (std::is_same_v<T, double>) {
      at[i] = positions[i];
    } else {
      at[i] = positions[i].a;
    }
  }
  const Eigen::Matrix3Xd directions = LinearDirections(machine, at.data());
  const Eigen::MatrixXd commands_from_gap = directions.transpose() * (directions * directions.transpose()).inverse();
  const std::vector<int> linear = LinearAxes(machine);
  const geometry::Vector3<T> ball(run.ball_mm.x() + setup[0], run.ball_mm.y() + setup[1], run.ball_mm.z() + setup[2]);
  constexpr int kIterations = 6;  // each one multiplies the gap by the angle errors' size, 1e-3 at most
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const machine::ChainPose<T> pose = machine::EvaluateChain<T>(machine, positions.data(), errors);
    const geometry::Vector3<T> gap =
        pose.bed_from_tool * geometry::Vector3<T>(run.tip_mm.cast<T>()) - pose.bed_from_table * ball;
    for (size_t i = 0; i < linear.size(); ++i) {
      for (int k = 0; k < 3; ++k) positions[linear[i]] -= commands_from_gap(i, k) * gap[k];
    }
  }
  // What the controller reports: the nominal tool point of those commands.
  std::vector<T> rotary_only(positions);
  for (const int axis : linear) rotary_only[axis] = T(0.0);
  const machine::ChainPose<T> turned = machine::EvaluateChain<T>(machine, rotary_only.data(), {});
  geometry::Vector3<T> reported = turned.bed_from_tool * geometry::Vector3<T>(run.tip_mm.cast<T>());
  for (size_t i = 0; i < linear.size(); ++i) {
    for (int k = 0; k < 3; ++k) reported[k] += directions(k, i) * positions[linear[i]];
  }
  for (int k = 0; k < 3; ++k) predicted_mm[k] = reported[k];
}

void Evaluate(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out);

}  // namespace axiscal::centres

#endif  // AXISCAL_CORE_INSTRUMENTS_CENTRES_CENTRES_MODEL_H_
