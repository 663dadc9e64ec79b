// Compensation tables as data: functions that are linear between the nodes of a grid of axis positions, as controllers
// interpolate them, and the commands that a controller with such a table gives.
//
// Every table format is read into this form, so that one evaluation on the machine's chain judges all of them.
// Lengths mm, angles rad. Beyond the ends of its grid a function keeps its last value, as controllers do.
#ifndef AXISCAL_CORE_COMPENSATE_TABLE_H_
#define AXISCAL_CORE_COMPENSATE_TABLE_H_

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/compensate/compensator.h"

namespace axiscal::compensate {

using Positions = std::array<double, machine::kMaxAxes>;  // per axis of the machine, mm or rad

enum class TableKind {
  kCorrections,  // added to the command: correction = -error
  kErrors,       // ISO 230-1 error components of joints, error = actual - nominal: the controller inverts its chain
  kPoints,       // points on the rotary axes, for the controller's kinematic transformation
};

// The nodes along one axis, increasing.
struct TableArgument {
  int axis = 0;
  std::vector<double> nodes;
};

struct TableColumn {
  // kCorrections: the axis whose command is corrected; kErrors: joint * machine::kComponents + component.
  int target = 0;
  // Per node, the first argument running fastest. `reverse` holds while the first argument's axis moves to lower
  // positions, `forward` otherwise; empty: both senses as `forward`.
  std::vector<double> forward, reverse;
};

struct TableBlock {
  std::vector<TableArgument> arguments;  // none: constants
  std::vector<TableColumn> columns;
};

struct Table {
  TableKind kind = TableKind::kCorrections;
  std::vector<TableBlock> blocks;
  // kPoints: a point on each rotary axis (unused for others), machine frame at home, in the machine's
  // order.
  std::vector<Eigen::Vector3d> points_mm;
};

// The value of a column at a pose. A sense of 0 is the mean of both.
double ValueAt(const TableBlock& block, const TableColumn& column, const Pose& pose);

// The axis positions that a controller with this table goes to when `pose` is commanded.
// kErrors and kPoints: the linear axes that bring the tool point, on the controller's model of the machine, to where
// the nominal machine would have it; FAILED_PRECONDITION when there are none.
absl::StatusOr<Positions> CommandedWith(const Table& table, const machine::Machine& machine,
                                        const Eigen::Vector3d& tool_tip_mm, const Pose& pose);

// "X" of an argument or corrected axis, "EXX" or "EA0B" of an error's column (`0`: no argument).
std::string TargetName(const Table& table, const TableBlock& block, const TableColumn& column,
                       const machine::Machine& machine);
// True where the column is in rad.
bool IsAngle(const Table& table, const TableColumn& column, const machine::Machine& machine);

}  // namespace axiscal::compensate

#endif  // AXISCAL_CORE_COMPENSATE_TABLE_H_
