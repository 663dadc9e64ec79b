// Laser tracker: the tool point in the tracker's frame,  p = tracker_from_machine * tool point.
// Setup: pose of the tracker's frame (three translations mm, three rotations rad about its x, y, z, on top of the run's
// starting pose) and the target's place on the tool (x, y, z, machine frame at home, mm). Nothing is known of either
// beforehand.
#ifndef AXISCAL_CORE_INSTRUMENTS_TRACKER_TRACKER_MODEL_H_
#define AXISCAL_CORE_INSTRUMENTS_TRACKER_TRACKER_MODEL_H_

#include "core/instruments/evaluation.h"

namespace axiscal::tracker {

std::vector<instruments::SetupParameter> SetupParameters();

// The rigid transform that brings the nominal tool points nearest to the measured ones (Horn/Kabsch, least squares).
geometry::Rigid<double> StartingPose(const machine::Machine& machine, const instruments::MeasuringRun& run);

template <typename T, typename Errors = machine::JointErrors<T>>
void Predict(const machine::Machine& machine, const instruments::MeasuringRun& run, const T* positions,
             const Errors& errors, const T* setup, T* predicted_mm) {
  const machine::ChainPose<T> pose = machine::EvaluateChain<T>(machine, positions, errors);
  const geometry::Vector3<T> target(run.tip_mm.x() + setup[6], run.tip_mm.y() + setup[7], run.tip_mm.z() + setup[8]);
  const geometry::Vector3<T> in_start = run.tracker_from_machine.rotation.cast<T>() * (pose.bed_from_tool * target) +
                                        run.tracker_from_machine.translation_mm.cast<T>();
  const geometry::Vector3<T> turned = geometry::RotationXyz<T>(setup[3], setup[4], setup[5]) * in_start;
  for (int k = 0; k < 3; ++k) predicted_mm[k] = turned[k] + setup[k];
}

void Evaluate(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out);

}  // namespace axiscal::tracker

#endif  // AXISCAL_CORE_INSTRUMENTS_TRACKER_TRACKER_MODEL_H_
