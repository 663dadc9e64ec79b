#include "core/instruments/direction/direction_model.h"

#include <Eigen/Geometry>
#include <limits>

namespace axiscal::direction {

std::vector<instruments::SetupParameter> SetupParameters() {
  return {{"zero", std::numeric_limits<double>::infinity(), true, false}};
}

// With d M = [w] M, w the small turn that an error adds in the reference's axes: d v = (tr(M) I - M) w / 2.
void Evaluate(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out) {
  const double* const positions = run.PositionsOf(reading);
  const bool is_on_bed = run.direction.is_on_bed;
  machine::EvaluatePlaces(machine, positions, errors, run.tip_mm, Eigen::Vector3d::Zero(), &out->point);
  const machine::RelativePoint& point = out->point;
  const machine::ChainPose<double> nominal =
      machine::EvaluateChain<double>(machine, positions, machine::JointErrors<double>());
  const auto tool_in_reference = [&](const machine::ChainPose<double>& pose) {
    return is_on_bed ? Eigen::Matrix3d(pose.bed_from_tool.rotation)
                     : Eigen::Matrix3d(pose.bed_from_table.rotation.transpose() * pose.bed_from_tool.rotation);
  };
  const Eigen::Matrix3d turned = tool_in_reference(point.pose) * tool_in_reference(nominal).transpose();
  const Eigen::Vector3d sine(turned(2, 1) - turned(1, 2), turned(0, 2) - turned(2, 0), turned(1, 0) - turned(0, 1));
  out->predicted_mm.resize(1);
  out->predicted_mm[0] = 0.5 * kLeverMm * sine.dot(run.direction.about) + setup[0];
  out->by_setup.setOnes(1, 1);
  const Eigen::Matrix3d reference_from_bed =
      is_on_bed ? Eigen::Matrix3d::Identity() : Eigen::Matrix3d(point.pose.bed_from_table.rotation.transpose());
  const Eigen::RowVector3d by_turn = 0.5 * kLeverMm * run.direction.about.transpose() *
                                     (turned.trace() * Eigen::Matrix3d::Identity() - turned) * reference_from_bed;
  out->by_error.setZero(1, machine::kComponents * machine.joint_count());
  for (int joint = 0; joint < machine.joint_count(); ++joint) {
    const machine::JointPlace& place = point.places[joint];
    if (is_on_bed && place.sign < 0.0) continue;  // the table does not carry the reference
    out->by_error.block<1, 3>(0, machine::kComponents * joint + 3) =
        place.sign * by_turn * place.bed_from_parent * point.turns[joint].axes;
  }
}

}  // namespace axiscal::direction
