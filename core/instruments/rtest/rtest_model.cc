#include "core/instruments/rtest/rtest_model.h"

namespace axiscal::rtest {

std::vector<instruments::SetupParameter> SetupParameters() {
  constexpr double kBallMm = 0.060;  // formats.md, "Measuring session"
  return {{"ball_x", kBallMm, true, false}, {"ball_y", kBallMm, true, false}, {"ball_z", kBallMm, true, false}};
}

void Evaluate(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out) {
  const Eigen::Vector3d ball_mm = run.ball_mm + Eigen::Vector3d(setup[0], setup[1], setup[2]);
  machine::EvaluateRelativePoint(machine, run.PositionsOf(reading), errors, run.tip_mm, ball_mm, &out->point);
  // d = R^T (tip - ball). A turn of the table's branch also turns R; its part of the derivative is the displacement
  // itself (0.1 mm at most) turned, which the relative sensitivity, taken at the ball, leaves out: 1e-4 of the rest.
  const Eigen::Matrix3d table_from_bed = out->point.pose.bed_from_table.rotation.transpose();
  out->predicted_mm = table_from_bed * (out->point.tip_in_bed_mm - out->point.ball_in_bed_mm);
  out->by_error.noalias() = table_from_bed * out->point.sensitivity;
  out->by_setup = -Eigen::Matrix3d::Identity();
}

}  // namespace axiscal::rtest
