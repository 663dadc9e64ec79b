#include "core/instruments/rtest/rtest_model.h"

#include <Eigen/Geometry>

namespace axiscal::rtest {

std::vector<instruments::SetupParameter> SetupParameters() {
  constexpr double kBallMm = 0.060;  // docs/formats.md
  return {{"ball_x", kBallMm, true, false}, {"ball_y", kBallMm, true, false}, {"ball_z", kBallMm, true, false}};
}

void Evaluate(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out) {
  const Eigen::Vector3d ball_mm = run.ball_mm + Eigen::Vector3d(setup[0], setup[1], setup[2]);
  machine::EvaluateRelativePoint(machine, run.PositionsOf(reading), errors, run.tip_mm, ball_mm, &out->point);
  machine::RelativePoint& point = out->point;
  const Eigen::Vector3d displacement_mm = point.tip_in_bed_mm - point.ball_in_bed_mm;
  // d = R^T (tip - ball): an error of the table's branch moves the ball and turns R, together as if the ball stood
  // where the tool does.
  const auto turn_too = [&](int joint) {
    auto block = point.sensitivity.middleCols<machine::kComponents>(machine::kComponents * joint);
    const Eigen::Matrix3d axes = block.leftCols<3>() * point.turns[joint].axes;
    for (int k = 0; k < 3; ++k) block.col(3 + k) += axes.col(k).cross(displacement_mm);
  };
  for (const int axis : machine.work_branch) turn_too(axis);
  turn_too(machine.work_joint());
  const Eigen::Matrix3d table_from_bed = point.pose.bed_from_table.rotation.transpose();
  out->predicted_mm = table_from_bed * displacement_mm;
  out->by_error.noalias() = table_from_bed * point.sensitivity;
  out->by_setup = -Eigen::Matrix3d::Identity();
}

}  // namespace axiscal::rtest
