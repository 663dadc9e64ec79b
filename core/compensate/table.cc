#include "core/compensate/table.h"

#include <Eigen/Dense>
#include <algorithm>

#include "core/base/units.h"

namespace axiscal::compensate {
namespace {

using machine::Machine;

constexpr int kMaxIterations = 30;
constexpr double kConvergedMm = 1e-7;

// Where a position stands between two nodes: index of the lower one and the upper one's weight.
struct Between {
  size_t lower = 0;
  double weight = 0.0;
};

Between Find(const std::vector<double>& nodes, double position) {
  if (nodes.size() < 2 || position <= nodes.front()) return {0, 0.0};
  if (position >= nodes.back()) return {nodes.size() - 2, 1.0};
  const size_t upper = static_cast<size_t>(std::upper_bound(nodes.begin(), nodes.end(), position) - nodes.begin());
  return {upper - 1, (position - nodes[upper - 1]) / (nodes[upper] - nodes[upper - 1])};
}

double Interpolate(const TableBlock& block, const std::vector<double>& values, const Pose& pose) {
  const size_t dimensions = block.arguments.size();
  std::vector<Between> between(dimensions);
  for (size_t d = 0; d < dimensions; ++d)
    between[d] = Find(block.arguments[d].nodes, pose.position[block.arguments[d].axis]);
  double sum = 0.0;
  for (size_t corner = 0; corner < (size_t{1} << dimensions); ++corner) {
    double weight = 1.0;
    size_t index = 0, stride = 1;
    for (size_t d = 0; d < dimensions; ++d) {
      const bool upper = (corner >> d) & 1;
      weight *= upper ? between[d].weight : 1.0 - between[d].weight;
      index += stride * (between[d].lower + (upper ? 1 : 0));
      stride *= block.arguments[d].nodes.size();
    }
    if (weight != 0.0) sum += weight * values[index];
  }
  return sum;
}

Positions WithCorrections(const Table& table, const Pose& pose) {
  Positions positions = pose.position;
  for (const TableBlock& block : table.blocks) {
    for (const TableColumn& column : block.columns) positions[column.target] += ValueAt(block, column, pose);
  }
  return positions;
}

machine::JointErrors<double> ErrorsOf(const Table& table, const Pose& pose) {
  machine::JointErrors<double> errors;
  for (const TableBlock& block : table.blocks) {
    for (const TableColumn& column : block.columns)
      errors[column.target / machine::kComponents][column.target % machine::kComponents] +=
          ValueAt(block, column, pose);
  }
  return errors;
}

Eigen::Vector3d Tip(const Machine& machine, const Positions& positions, const machine::JointErrors<double>& errors,
                    const Eigen::Vector3d& tip_mm) {
  return machine::TipInTable<double>(machine::EvaluateChain<double>(machine, positions.data(), errors), tip_mm);
}

// Columns: the tool point's motion per mm of each linear axis. The tool point is affine in the linear axes where errors
// are constant, so differences over a millimetre are exact to rounding.
Eigen::MatrixXd LinearColumns(const Machine& model, const Positions& positions,
                              const machine::JointErrors<double>& errors, const Eigen::Vector3d& tip_mm,
                              const std::vector<int>& linear) {
  const Eigen::Vector3d here = Tip(model, positions, errors, tip_mm);
  Eigen::MatrixXd columns(3, linear.size());
  for (size_t k = 0; k < linear.size(); ++k) {
    Positions moved = positions;
    moved[linear[k]] += 1.0;
    columns.col(static_cast<Eigen::Index>(k)) = Tip(model, moved, errors, tip_mm) - here;
  }
  return columns;
}

// The controller's own inversion: its model of the machine (`model`, with the table's errors) reaches what the nominal
// machine would.
absl::StatusOr<Positions> Invert(const Table& table, const Machine& nominal, const Machine& model,
                                 const Eigen::Vector3d& tip_mm, const Pose& pose) {
  std::vector<int> linear;
  for (int i = 0; i < nominal.axis_count(); ++i) {
    if (nominal.axes[i].kind == machine::AxisKind::kLinear) linear.push_back(i);
  }
  const Eigen::Vector3d wanted = Tip(nominal, pose.position, {}, tip_mm);
  Pose commanded = pose;
  for (int i = 0; i < kMaxIterations && !linear.empty(); ++i) {
    const machine::JointErrors<double> errors = ErrorsOf(table, commanded);
    const Eigen::Vector3d lacking = wanted - Tip(model, commanded.position, errors, tip_mm);
    if (lacking.norm() < kConvergedMm) return commanded.position;
    const Eigen::MatrixXd columns = LinearColumns(model, commanded.position, errors, tip_mm, linear);
    const Eigen::VectorXd change = columns.completeOrthogonalDecomposition().solve(lacking);
    for (size_t k = 0; k < linear.size(); ++k) commanded.position[linear[k]] += change[static_cast<Eigen::Index>(k)];
  }
  return absl::FailedPreconditionError(absl::StrCat(
      "machine '", nominal.id, "': no linear-axis positions bring the tool point to where the table asks"));
}

}  // namespace

double ValueAt(const TableBlock& block, const TableColumn& column, const Pose& pose) {
  const double forward = Interpolate(block, column.forward, pose);
  if (column.reverse.empty() || block.arguments.empty()) return forward;
  const double sense = pose.sense[block.arguments[0].axis];
  if (sense > 0) return forward;
  const double reverse = Interpolate(block, column.reverse, pose);
  return sense < 0 ? reverse : 0.5 * (forward + reverse);
}

absl::StatusOr<Positions> CommandedWith(const Table& table, const Machine& machine, const Eigen::Vector3d& tool_tip_mm,
                                        const Pose& pose) {
  if (table.kind == TableKind::kCorrections) return WithCorrections(table, pose);
  if (table.kind == TableKind::kErrors) return Invert(table, machine, machine, tool_tip_mm, pose);
  Machine model = machine;
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (machine.axes[i].kind == machine::AxisKind::kRotary) model.axes[i].point_mm = table.points_mm[i];
  }
  return Invert(table, machine, model, tool_tip_mm, pose);
}

std::string TargetName(const Table& table, const TableBlock& block, const TableColumn& column, const Machine& machine) {
  if (table.kind == TableKind::kCorrections) return machine.axes[column.target].name;
  const auto component = static_cast<machine::Component>(column.target % machine::kComponents);
  return machine::ToString(
      {component, machine::JointName(machine, column.target / machine::kComponents), block.arguments.empty()});
}

bool IsAngle(const Table& table, const TableColumn& column, const Machine& machine) {
  if (table.kind == TableKind::kCorrections) return machine.axes[column.target].kind == machine::AxisKind::kRotary;
  return machine::IsAngle(static_cast<machine::Component>(column.target % machine::kComponents));
}

}  // namespace axiscal::compensate
