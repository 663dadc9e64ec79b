// Touch probe on spheres, planes, columns and blocks: at the latched axis positions the stylus ball touches the
// feature,
//   distance of the stylus centre from the surface - stylus radius = 0,
// so the reading is that gap (mm, > 0: the ball stands off the surface), and it is measured as 0. The distance is taken
// along the feature's own normal at the point of contact, never along the commanded direction (Yao 2022, ch. 5: 3.4 deg
// off normal); only the displacement along the normal counts (Ibaraki, eq 9).
// Setup: the artefact's place (x, y, z mm) and turn (Rot_x Rot_y Rot_z, rad) about the mean of its features' points,
// table frame; where the header says how well its features are known, how far each stands out along its normal (of a
// sphere, its radius), mm.
#ifndef AXISCAL_CORE_INSTRUMENTS_TOUCH_TOUCH_MODEL_H_
#define AXISCAL_CORE_INSTRUMENTS_TOUCH_TOUCH_MODEL_H_

#include "core/instruments/distortion.h"
#include "core/instruments/evaluation.h"

namespace axiscal::touch {

inline constexpr int kPlaceOffsets = 6;  // of the artefact

// Of the artefact's place.
std::vector<instruments::SetupParameter> SetupParameters();

// How far each feature stands out, behind the place's, in the features' order: as many as there are features, or none.
inline int FeatureOffsets(const instruments::MeasuringRun& run) {
  return instruments::OwnSetupCount(run) - static_cast<int>(run.free_datum.size()) - kPlaceOffsets;
}

template <typename T, typename Errors = machine::JointErrors<T>>
void Predict(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading, const T* positions,
             const Errors& errors, const T* setup, T* predicted_mm) {
  using std::sqrt;
  const Feature& feature = run.touches.features[run.touches.feature_of[reading]];
  const machine::ChainPose<T> pose = machine::EvaluateChain<T>(machine, positions, errors);
  const geometry::Vector3<T> stylus =
      pose.bed_from_table.Inverse() * (pose.bed_from_tool * geometry::Vector3<T>(run.tip_mm.cast<T>()));
  const geometry::Matrix3<T> turn = geometry::RotationXyz<T>(setup[3], setup[4], setup[5]);
  const Eigen::Vector3d lever_mm = feature.point_mm - run.touches.centre_mm;
  geometry::Vector3<T> point = turn * geometry::Vector3<T>(lever_mm.cast<T>());
  for (int k = 0; k < 3; ++k) point[k] += run.touches.centre_mm[k] + setup[k];
  const geometry::Vector3<T> off = stylus - point;
  if (feature.is_sphere) {
    predicted_mm[0] = sqrt(off.squaredNorm()) - (feature.radius_mm + run.touches.stylus_radius_mm);
  } else {
    const geometry::Vector3<T> normal = turn * geometry::Vector3<T>(feature.normal.cast<T>());
    predicted_mm[0] = normal.dot(off) - run.touches.stylus_radius_mm;
  }
  if (FeatureOffsets(run) > 0) predicted_mm[0] -= setup[kPlaceOffsets + run.touches.feature_of[reading]];
}

void Evaluate(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out);

// The feature's outward unit normal at the point that the stylus touches at these positions (mm or rad per axis), in
// the bed's axes, on the nominal machine with the feature in its nominal place.
Eigen::Vector3d NormalAt(const machine::Machine& machine, const Feature& feature, const Eigen::Vector3d& tip_mm,
                         const double* positions);
Eigen::Vector3d NominalNormal(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading);

}  // namespace axiscal::touch

#endif  // AXISCAL_CORE_INSTRUMENTS_TOUCH_TOUCH_MODEL_H_
