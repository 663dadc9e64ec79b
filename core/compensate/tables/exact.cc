// The exact values that tables are sampled from, besides correction_target.h.
#include "core/compensate/tables/sample.h"
#include "core/machine/chain.h"

namespace axiscal::tables {

using machine::ErrorModel;
using machine::ErrorTerm;
using machine::Machine;

double ComponentAt(const Machine& machine, const ErrorModel& errors, const compensate::Options& options, int target,
                   int argument, double position, double sense) {
  std::array<shapes::AxisState, machine::kMaxAxes> axes;
  if (argument >= 0) {
    axes[argument].position = position;
    axes[argument].sense = sense;
  }
  shapes::State state;
  state.axes = {axes.data(), static_cast<size_t>(machine.axis_count())};
  if (options.time_s) state.time_s = *options.time_s;
  if (options.temperature_celsius) state.temperature_celsius = *options.temperature_celsius;
  double sum = 0.0, basis[shapes::kMaxBasisCount];
  for (const ErrorTerm& term : errors.terms) {
    if (term.joint * machine::kComponents + static_cast<int>(term.component) != target) continue;
    if (shapes::VariableAxis(term.shape).value_or(-1) != argument) continue;
    shapes::Basis(term.shape, state, basis);
    for (int i = 0; i < shapes::BasisCount(term.shape); ++i) sum += term.amplitude[i] * basis[i];
  }
  return sum;
}

std::vector<Eigen::Vector3d> PointsOf(const Plan& plan, const ErrorModel& errors) {
  const Machine& machine = plan.machine;
  ErrorModel constant;
  for (const ErrorTerm& term : errors.terms) {
    if (!shapes::VariableAxis(term.shape)) constant.terms.push_back(term);
  }
  shapes::State state;
  if (plan.request.state.time_s) state.time_s = *plan.request.state.time_s;
  if (plan.request.state.temperature_celsius) state.temperature_celsius = *plan.request.state.temperature_celsius;
  const machine::JointErrors<double> at_home = machine::ErrorsAt(machine, constant, state);
  std::vector<Eigen::Vector3d> points(static_cast<size_t>(machine.axis_count()), Eigen::Vector3d::Zero());
  Eigen::Vector3d tip_shift = Eigen::Vector3d::Zero();
  for (const std::vector<int>* branch : {&machine.tool_branch, &machine.work_branch}) {
    geometry::Rigid<double> bed;
    for (const int axis : *branch) {
      machine::AppendError<double>(at_home[axis], ErrorPoint(machine, axis), &bed);
      points[axis] = bed * machine.axes[axis].point_mm;
    }
    if (branch != &machine.tool_branch) continue;
    machine::AppendError<double>(at_home[machine.tool_joint()], Eigen::Vector3d::Zero(), &bed);
    tip_shift = bed * plan.request.state.tool_tip_mm - plan.request.state.tool_tip_mm;
  }
  // Axis positions say where the tool point is: a shift of the tool point alone is the opposite shift of all axes.
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (machine.axes[i].kind == machine::AxisKind::kRotary) points[i] -= tip_shift;
  }
  return points;
}

}  // namespace axiscal::tables
