#include "core/instruments/tracker/tracker_model.h"

#include <Eigen/Geometry>
#include <limits>

namespace axiscal::tracker {

std::vector<instruments::SetupParameter> SetupParameters() {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  return {
      {"frame_x", kUnknown, true, false},  {"frame_y", kUnknown, true, false},  {"frame_z", kUnknown, true, false},
      {"frame_a", kUnknown, true, true},   {"frame_b", kUnknown, true, true},   {"frame_c", kUnknown, true, true},
      {"target_x", kUnknown, true, false}, {"target_y", kUnknown, true, false}, {"target_z", kUnknown, true, false}};
}

geometry::Rigid<double> StartingPose(const machine::Machine& machine, const instruments::MeasuringRun& run) {
  Eigen::Matrix3Xd nominal_mm(3, run.reading_count());
  for (int k = 0; k < run.reading_count(); ++k) {
    nominal_mm.col(k) = machine::EvaluateChain<double>(machine, run.PositionsOf(k), {}).bed_from_tool * run.tip_mm;
  }
  const Eigen::Matrix4d pose = Eigen::umeyama(nominal_mm, Eigen::Matrix3Xd(run.measured_mm), /*with_scaling=*/false);
  return {pose.topLeftCorner<3, 3>(), pose.topRightCorner<3, 1>()};
}

void Evaluate(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out) {
  const Eigen::Vector3d target_mm = run.tip_mm + Eigen::Vector3d(setup[6], setup[7], setup[8]);
  machine::EvaluateRelativePoint(machine, run.PositionsOf(reading), errors, target_mm, Eigen::Vector3d::Zero(),
                                 &out->point);
  // The tracker does not stand on the table: the work branch has no part in its reading.
  for (const int axis : machine.work_branch) out->point.sensitivity.middleCols<6>(6 * axis).setZero();
  out->point.sensitivity.middleCols<6>(6 * machine.work_joint()).setZero();

  const double ca = std::cos(setup[3]), sa = std::sin(setup[3]), cb = std::cos(setup[4]), sb = std::sin(setup[4]);
  const Eigen::Matrix3d turn = geometry::RotationXyz(setup[3], setup[4], setup[5]);
  const Eigen::Matrix3d tracker_from_bed = turn * run.tracker_from_machine.rotation;
  const Eigen::Vector3d turned_mm = turn * (run.tracker_from_machine * out->point.tip_in_bed_mm);
  out->predicted_mm = turned_mm + Eigen::Vector3d(setup[0], setup[1], setup[2]);
  out->by_error.noalias() = tracker_from_bed * out->point.sensitivity;
  out->by_setup.resize(3, 9);
  out->by_setup.leftCols<3>().setIdentity();
  out->by_setup.col(3) = Eigen::Vector3d::UnitX().cross(turned_mm);
  out->by_setup.col(4) = Eigen::Vector3d(0, ca, sa).cross(turned_mm);
  out->by_setup.col(5) = Eigen::Vector3d(sb, -sa * cb, ca * cb).cross(turned_mm);
  out->by_setup.rightCols<3>() = tracker_from_bed * out->point.pose.bed_from_tool.rotation;
}

}  // namespace axiscal::tracker
