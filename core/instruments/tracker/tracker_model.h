// Laser tracker: a target's place in the tracker's frame,  p = tracker_from_machine(t) * place.
// A target on the tool goes with the tool point; a reference target stands beside the machine, and what it seems to do
// the tracker does. Setup (mm and rad): pose of the tracker's frame at the first look at reference targets, or of the
// whole session (three translations, three rotations about its x, y, z, on top of the run's starting pose); each
// target's place on the tool and each reference's beside the machine, less the nominal one (x, y, z, machine frame at
// home); the pose at each further look less that at the first one. Nothing is known of any of it beforehand but that
// the tracker moves little.
#ifndef AXISCAL_CORE_INSTRUMENTS_TRACKER_TRACKER_MODEL_H_
#define AXISCAL_CORE_INSTRUMENTS_TRACKER_TRACKER_MODEL_H_

#include <algorithm>

#include "core/instruments/evaluation.h"

namespace axiscal::tracker {

// Setup offsets before the targets' and before the moves.
inline constexpr int kPoseOffsets = 6;
inline int TargetCount(const Targets& targets) {
  return static_cast<int>(std::max<size_t>(1, targets.on_tool.size()) + targets.references.size());
}
inline int FirstMove(const Targets& targets) { return kPoseOffsets + 3 * TargetCount(targets); }

std::vector<instruments::SetupParameter> SetupParameters();
std::vector<instruments::SetupParameter> SetupParametersOf(const Targets& targets);

// The rigid transform that brings the nominal places of targets on the tool nearest to the measured ones (Horn/Kabsch,
// least squares).
geometry::Rigid<double> StartingPose(const machine::Machine& machine, const instruments::MeasuringRun& run);

// The place of the reading's target in the setup.
int TargetOf(const instruments::MeasuringRun& run, int reading);
// Its nominal place, machine frame at home.
const Eigen::Vector3d& NominalPlace(const instruments::MeasuringRun& run, int reading);

// How much of each look's pose (from the second on) the tracker has at a time: targets.Moves() numbers, two of which
// are not 0. The pose is the sum of share x pose.
void PoseShares(const Targets& targets, double time_s, double* shares);

template <typename T, typename Errors = machine::JointErrors<T>>
void Predict(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading, const T* positions,
             const Errors& errors, const T* setup, T* predicted_mm) {
  const T* const at = setup + TargetOf(run, reading);
  const Eigen::Vector3d& nominal_mm = NominalPlace(run, reading);
  geometry::Vector3<T> place(nominal_mm.x() + at[0], nominal_mm.y() + at[1], nominal_mm.z() + at[2]);
  if (!run.targets.IsReference(reading))
    place = machine::EvaluateChain<T>(machine, positions, errors).bed_from_tool * place;
  T pose[kPoseOffsets];
  for (int i = 0; i < kPoseOffsets; ++i) pose[i] = setup[i];
  double shares[kMostPoses];
  PoseShares(run.targets, run.time_s[static_cast<size_t>(reading)], shares);
  const T* move = setup + FirstMove(run.targets);
  for (int k = 0; k < run.targets.Moves(); ++k, move += kPoseOffsets) {
    for (int i = 0; i < kPoseOffsets; ++i) pose[i] += shares[k] * move[i];
  }
  const geometry::Vector3<T> in_start =
      run.tracker_from_machine.rotation.cast<T>() * place + run.tracker_from_machine.translation_mm.cast<T>();
  const geometry::Vector3<T> turned = geometry::RotationXyz<T>(pose[3], pose[4], pose[5]) * in_start;
  for (int k = 0; k < 3; ++k) predicted_mm[k] = turned[k] + pose[k];
}

void Evaluate(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out);

}  // namespace axiscal::tracker

#endif  // AXISCAL_CORE_INSTRUMENTS_TRACKER_TRACKER_MODEL_H_
