// Length (draw wire, distance of a tracker, interferometer, straightness optics): how far the target on the tool has
// gone from what stands on the table or beside the machine.
//   from an anchor    L = (1 + scale) |target - anchor| + zero
//   along a beam      L = (1 + scale) u . target + zero,     u: a direction that does not move with the target
// A beam that is tilted by a reads along the motion cos a of it. No reading tells that from the scale, so tilts act to
// first order here (u + a x u), and what the cosine leaves open belongs into the scale's sigma.
// The anchor or the direction stands on the table (`anchor_on: table`) or on the bed. A beam along the motion measures
// positioning, one across it straightness. A reading is the whole length where the zero is known (`zero_sigma_um`);
// else it counts from anywhere. Setup, anchor: its place (x, y, z, mm), the target's on the tool (x, y, z, machine axes
// at home, mm), zero (mm), scale (mm per metre); beam: two tilts of u (rad, about the axes across it), the target,
// zero, scale.
#ifndef AXISCAL_CORE_INSTRUMENTS_LENGTH_LENGTH_MODEL_H_
#define AXISCAL_CORE_INSTRUMENTS_LENGTH_LENGTH_MODEL_H_

#include <Eigen/Geometry>

#include "core/instruments/evaluation.h"

namespace axiscal::length {

inline constexpr double kPerMetre = 1e-3;  // a scale of 1 mm per metre
inline constexpr char kScaleName[] = "scale";

std::vector<instruments::SetupParameter> SetupParameters();
std::vector<instruments::SetupParameter> BeamSetupParameters();

// Unit vectors across a direction, about which it tilts: columns.
Eigen::Matrix<double, 3, 2> AcrossOf(const Eigen::Vector3d& direction);

// Where a session does not state how well its zero is known, the zero starts from the median of what its readings are
// off what the nominal machine would read.
bool HasStatedZero(const instruments::MeasuringRun& run);
double StartingZero(const machine::Machine& machine, const instruments::MeasuringRun& run);

template <typename T, typename Errors = machine::JointErrors<T>>
void Predict(const machine::Machine& machine, const instruments::MeasuringRun& run, const T* positions,
             const Errors& errors, const T* setup, T* predicted_mm) {
  using Vector = geometry::Vector3<T>;
  const machine::ChainPose<T> pose = machine::EvaluateChain<T>(machine, positions, errors);
  const T* const target = setup + (run.length.is_beam ? 2 : 3);
  const Vector tip_mm(run.tip_mm.x() + target[0], run.tip_mm.y() + target[1], run.tip_mm.z() + target[2]);
  const Vector tip_in_bed_mm = pose.bed_from_tool * tip_mm;
  T length_mm;
  if (run.length.is_beam) {
    const Eigen::Matrix<double, 3, 2> across = AcrossOf(run.length.beam);
    const Eigen::Vector3d by_a = across.col(0).cross(run.length.beam), by_b = across.col(1).cross(run.length.beam);
    const Vector tilted = run.length.beam.cast<T>() + by_a.cast<T>() * setup[0] + by_b.cast<T>() * setup[1];
    const Vector seen_mm =
        run.length.is_on_bed
            ? tip_in_bed_mm
            : Vector(pose.bed_from_table.rotation.transpose() * (tip_in_bed_mm - pose.bed_from_table.translation_mm));
    length_mm = tilted.dot(seen_mm);
  } else {
    const Vector anchor_mm(run.ball_mm.x() + setup[0], run.ball_mm.y() + setup[1], run.ball_mm.z() + setup[2]);
    length_mm = (run.length.is_on_bed ? Vector(tip_in_bed_mm - anchor_mm)
                                      : Vector(tip_in_bed_mm - pose.bed_from_table * anchor_mm))
                    .norm();
  }
  predicted_mm[0] = length_mm * (T(1.0) + kPerMetre * target[4]) + run.length.zero_mm + target[3];
}

void Evaluate(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out);

}  // namespace axiscal::length

#endif  // AXISCAL_CORE_INSTRUMENTS_LENGTH_LENGTH_MODEL_H_
