// Direction (autocollimator, telescope, level): how the tool is turned about one axis, against the table or the bed.
//   M = R_ref^T R_tool (R_ref^T R_tool of the nominal machine at the same commands)^T
//   reading = 1000 mm (a . v(M)) + zero,    v(M) = half of (M32 - M23, M13 - M31, M21 - M12)
// v is the axis of the turn times its sine: the turn itself to 1e-7 of a milliradian. The unit is that of a
// level, mm per metre: 1 um is 1 urad. `about: x y z` is a, in machine axes at home, right-handed; it is
// carried by the table (`reference: table`) or stands on the bed, as a level's gravity does. Setup: zero, of which
// nothing is known. Where the instrument's own axis is off by some mrad its channels mix by as much of a reading, which
// is within its resolution.
#ifndef AXISCAL_CORE_INSTRUMENTS_DIRECTION_DIRECTION_MODEL_H_
#define AXISCAL_CORE_INSTRUMENTS_DIRECTION_DIRECTION_MODEL_H_

#include "core/instruments/evaluation.h"

namespace axiscal::direction {

inline constexpr double kLeverMm = 1000.0;

std::vector<instruments::SetupParameter> SetupParameters();

template <typename T, typename Errors = machine::JointErrors<T>>
void Predict(const machine::Machine& machine, const instruments::MeasuringRun& run, const T* positions,
             const Errors& errors, const T* setup, T* predicted_mm) {
  using Matrix = Eigen::Matrix<T, 3, 3>;
  const machine::ChainPose<T> actual = machine::EvaluateChain<T>(machine, positions, errors);
  const machine::ChainPose<T> nominal = machine::EvaluateChain<T>(machine, positions, machine::JointErrors<T>());
  const auto tool_in_reference = [&](const machine::ChainPose<T>& pose) {
    return run.direction.is_on_bed ? Matrix(pose.bed_from_tool.rotation)
                                   : Matrix(pose.bed_from_table.rotation.transpose() * pose.bed_from_tool.rotation);
  };
  const Matrix turned = tool_in_reference(actual) * tool_in_reference(nominal).transpose();
  const geometry::Vector3<T> sine(turned(2, 1) - turned(1, 2), turned(0, 2) - turned(2, 0),
                                  turned(1, 0) - turned(0, 1));
  predicted_mm[0] = 0.5 * kLeverMm * sine.dot(run.direction.about.cast<T>()) + setup[0];
}

void Evaluate(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out);

}  // namespace axiscal::direction

#endif  // AXISCAL_CORE_INSTRUMENTS_DIRECTION_DIRECTION_MODEL_H_
