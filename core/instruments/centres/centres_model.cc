#include "core/instruments/centres/centres_model.h"

#include <Eigen/LU>
#include <Eigen/QR>

namespace axiscal::centres {
namespace {

// Adds the directions of one branch: each linear axis along its direction turned by the rotary axes before it.
void AddBranch(const machine::Machine& machine, const std::vector<int>& branch, const double* positions, double sign,
               const std::vector<int>& linear, Eigen::Matrix3Xd* directions) {
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  for (const int axis : branch) {
    const machine::Axis& a = machine.axes[axis];
    if (a.kind == machine::AxisKind::kRotary) {
      turned = turned * machine::MotionTransform<double>(a, positions[axis]).rotation;
      continue;
    }
    const auto at = std::find(linear.begin(), linear.end(), axis);
    directions->col(at - linear.begin()) = sign * (turned * a.direction);
  }
}

}  // namespace

std::vector<instruments::SetupParameter> SetupParameters() {
  constexpr double kSphereMm = 5.0;  // docs/formats.md
  return {{"ball_x", kSphereMm, true, false}, {"ball_y", kSphereMm, true, false}, {"ball_z", kSphereMm, true, false}};
}

std::vector<int> LinearAxes(const machine::Machine& machine) {
  std::vector<int> linear;
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (machine.axes[i].kind == machine::AxisKind::kLinear) linear.push_back(i);
  }
  return linear;
}

Eigen::Matrix3Xd LinearDirections(const machine::Machine& machine, const double* positions) {
  const std::vector<int> linear = LinearAxes(machine);
  Eigen::Matrix3Xd directions(3, linear.size());
  AddBranch(machine, machine.tool_branch, positions, 1.0, linear, &directions);
  AddBranch(machine, machine.work_branch, positions, -1.0, linear, &directions);
  return directions;
}

absl::Status SolveNominalCommands(const machine::Machine& machine, const Eigen::Vector3d& tip_mm,
                                  const Eigen::Vector3d& ball_mm, double* positions) {
  const std::vector<int> linear = LinearAxes(machine);
  for (const int axis : linear) positions[axis] = 0.0;
  const Eigen::Matrix3Xd directions = LinearDirections(machine, positions);
  const auto rank = [&] { return Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(directions).rank(); };
  if (linear.size() < 3 || rank() < 3) {  // of no columns the decomposition knows nothing
    return absl::FailedPreconditionError(
        absl::StrCat("machine '", machine.id, "': its linear axes do not reach three directions"));
  }
  const auto pose = machine::EvaluateChain<double>(machine, positions, {});
  const Eigen::VectorXd commands = Eigen::ColPivHouseholderQR<Eigen::MatrixXd>(directions)
                                       .solve(pose.bed_from_table * ball_mm - pose.bed_from_tool * tip_mm);
  for (size_t i = 0; i < linear.size(); ++i) positions[linear[i]] = commands[i];
  return absl::OkStatus();
}

void Evaluate(const machine::Machine& machine, const instruments::MeasuringRun& run, int reading,
              const machine::JointErrors<double>& errors, const double* setup, instruments::Evaluation* out) {
  out->predicted_mm.resize(3);
  Predict<double>(machine, run, run.PositionsOf(reading), errors, setup, out->predicted_mm.data());
  // The linear commands close the gap that an error opens, so the reading moves the other way:
  // dc = -N M^-1 d(gap), where N M^-1 is 1 but for the angle errors.
  const Eigen::Vector3d ball_mm = run.ball_mm + Eigen::Vector3d(setup[0], setup[1], setup[2]);
  machine::EvaluateRelativePoint(machine, run.PositionsOf(reading), errors, run.tip_mm, ball_mm, &out->point);
  out->by_error = -out->point.sensitivity;
  out->by_setup = out->point.pose.bed_from_table.rotation;
}

}  // namespace axiscal::centres
