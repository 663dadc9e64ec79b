#include "core/instruments/ballbar/ballbar_model.h"

#include <Eigen/Geometry>

namespace axiscal::ballbar {

std::vector<instruments::SetupParameter> SetupParameters() {
  constexpr double kBallMm = 0.060, kRunOutMm = 0.003, kBarMm = 0.002;  // docs/formats.md
  return {{"ball_x", kBallMm, true, false},       {"ball_y", kBallMm, true, false},
          {"ball_z", kBallMm, true, false},       {"run_out_x", kRunOutMm, false, false},
          {"run_out_y", kRunOutMm, false, false}, {"bar_length", kBarMm, false, false}};
}

Eigen::Matrix<double, 3, 2> RunOutDirections(const machine::Machine& machine) {
  // The two machine axes that stand most across the tool, made exactly so.
  int along = 0;
  machine.tool_direction.cwiseAbs().maxCoeff(&along);
  Eigen::Matrix<double, 3, 2> directions;
  int column = 0;
  for (int k = 0; k < 3; ++k) {
    if (k == along) continue;
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(k);
    if (machine.tool_direction[k] == 0.0) {
      directions.col(column++) = axis;
      continue;
    }
    directions.col(column++) = (axis - axis.dot(machine.tool_direction) * machine.tool_direction).normalized();
  }
  return directions;
}

void Evaluate(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out) {
  const Eigen::Matrix<double, 3, 2> across = RunOutDirections(machine);
  const Eigen::Vector3d tip_mm = run.tip_mm + across.col(0) * setup[3] + across.col(1) * setup[4];
  const Eigen::Vector3d ball_mm = run.ball_mm + Eigen::Vector3d(setup[0], setup[1], setup[2]);
  machine::EvaluatePlaces(machine, run.PositionsOf(reading), errors, tip_mm, ball_mm, &out->point);
  const Eigen::Vector3d bar_mm = out->point.tip_in_bed_mm - out->point.ball_in_bed_mm;
  const double length_mm = bar_mm.norm();
  const Eigen::Vector3d along = bar_mm / length_mm;
  out->predicted_mm.resize(1);
  out->predicted_mm[0] = length_mm - (run.bar_length_mm + setup[5]);
  out->by_error.resize(1, machine::kComponents * machine.joint_count());
  machine::SensitivityAlong(machine, out->point, along, out->by_error.data());
  out->by_setup.resize(1, 6);
  out->by_setup.leftCols<3>() = -along.transpose() * out->point.pose.bed_from_table.rotation;
  out->by_setup.middleCols<2>(3) = along.transpose() * out->point.pose.bed_from_tool.rotation * across;
  out->by_setup(0, 5) = -1.0;
}

}  // namespace axiscal::ballbar
