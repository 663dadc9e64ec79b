#include "core/instruments/touch/touch_model.h"

#include <Eigen/Geometry>

namespace axiscal::touch {

std::vector<instruments::SetupParameter> SetupParameters() {
  constexpr double kPlaceMm = 5.0;    // docs/formats.md
  constexpr double kTurnRad = 0.020;  // the same, for an artefact of half a metre
  return {{"artefact_x", kPlaceMm, true, false}, {"artefact_y", kPlaceMm, true, false},
          {"artefact_z", kPlaceMm, true, false}, {"artefact_a", kTurnRad, true, true},
          {"artefact_b", kTurnRad, true, true},  {"artefact_c", kTurnRad, true, true}};
}

void Evaluate(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out) {
  const Touches& touches = run.touches;
  const Feature& feature = touches.features[touches.feature_of[reading]];
  const double* positions = run.PositionsOf(reading);
  const machine::ChainPose<double> pose = machine::EvaluateChain<double>(machine, positions, errors);
  const Eigen::Vector3d stylus_mm = pose.bed_from_table.Inverse() * (pose.bed_from_tool * run.tip_mm);
  const Eigen::Matrix3d turn = geometry::RotationXyz(setup[3], setup[4], setup[5]);
  const Eigen::Vector3d origin_mm = touches.centre_mm + Eigen::Vector3d(setup[0], setup[1], setup[2]);
  Eigen::Vector3d contact_mm = origin_mm + turn * (feature.point_mm - touches.centre_mm);
  Eigen::Vector3d normal = turn * feature.normal;
  double gap_mm = normal.dot(stylus_mm - contact_mm) - touches.stylus_radius_mm;
  if (feature.is_sphere) {
    // A turn of a sphere about its centre changes nothing.
    const double distance_mm = (stylus_mm - contact_mm).norm();
    normal = (stylus_mm - contact_mm) / distance_mm;
    gap_mm = distance_mm - (feature.radius_mm + touches.stylus_radius_mm);
  } else {
    // The point of the plane below the stylus centre: a turn of the normal about it does not change the gap.
    contact_mm = stylus_mm - (gap_mm + touches.stylus_radius_mm) * normal;
  }
  machine::EvaluateRelativePoint(machine, positions, errors, run.tip_mm, contact_mm, &out->point);
  out->predicted_mm.resize(1);
  out->predicted_mm[0] = gap_mm;
  out->by_error.noalias() = (pose.bed_from_table.rotation * normal).transpose() * out->point.sensitivity;
  const double ca = std::cos(setup[3]), sa = std::sin(setup[3]), cb = std::cos(setup[4]), sb = std::sin(setup[4]);
  const Eigen::Vector3d torque_mm = (contact_mm - origin_mm).cross(normal);
  const int feature_offsets = FeatureOffsets(run);
  out->by_setup.setZero(1, kPlaceOffsets + feature_offsets);
  if (feature_offsets > 0) {
    const int at = kPlaceOffsets + touches.feature_of[reading];
    out->predicted_mm[0] -= setup[at];
    out->by_setup(0, at) = -1.0;
  }
  out->by_setup.leftCols<3>() = -normal.transpose();
  out->by_setup(0, 3) = -torque_mm.x();
  out->by_setup(0, 4) = -torque_mm.dot(Eigen::Vector3d(0, ca, sa));
  out->by_setup(0, 5) = -torque_mm.dot(Eigen::Vector3d(sb, -sa * cb, ca * cb));
}

Eigen::Vector3d NormalAt(const machine::Machine& machine, const Feature& feature, const Eigen::Vector3d& tip_mm,
                         const double* positions) {
  const auto pose = machine::EvaluateChain<double>(machine, positions, {});
  if (!feature.is_sphere) return pose.bed_from_table.rotation * feature.normal;
  return (pose.bed_from_tool * tip_mm - pose.bed_from_table * feature.point_mm).normalized();
}

Eigen::Vector3d NominalNormal(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading) {
  return NormalAt(machine, run.touches.features[run.touches.feature_of[reading]], run.tip_mm, run.PositionsOf(reading));
}

}  // namespace axiscal::touch
