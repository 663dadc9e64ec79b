#include "core/compensate/tables/read_back.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace axiscal::tables {
namespace {

using compensate::Table;
using compensate::TableBlock;
using compensate::TableColumn;

constexpr double kReadBack = 1e-9;  // mm or rad: rounding of units

bool Same(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](double x, double y) {
           return std::abs(x - y) <= kReadBack * std::max(1.0, std::abs(x));
         });
}

bool SameColumn(const TableColumn& a, const TableColumn& b) {
  // A file may state both senses of a column that has none.
  const std::vector<double>& reverse_a = a.reverse.empty() ? a.forward : a.reverse;
  const std::vector<double>& reverse_b = b.reverse.empty() ? b.forward : b.reverse;
  return a.target == b.target && Same(a.forward, b.forward) && Same(reverse_a, reverse_b);
}

bool SameBlock(const TableBlock& a, const TableBlock& b) {
  const auto same_argument = [](const compensate::TableArgument& x, const compensate::TableArgument& y) {
    return x.axis == y.axis && Same(x.nodes, y.nodes);
  };
  return std::equal(a.arguments.begin(), a.arguments.end(), b.arguments.begin(), b.arguments.end(), same_argument) &&
         std::equal(a.columns.begin(), a.columns.end(), b.columns.begin(), b.columns.end(), SameColumn);
}

// Across an axis only: the place of a point along its rotary axis is not in every format and changes nothing.
bool SamePoints(const Table& a, const Table& b, const machine::Machine& machine, double step) {
  for (int i = 0; i < machine.axis_count(); ++i) {
    const machine::Axis& axis = machine.axes[i];
    if (axis.kind != machine::AxisKind::kRotary) continue;
    if (axis.direction.cross(a.points_mm.at(i) - b.points_mm.at(i)).norm() > 2.0 * step) return false;
  }
  return true;
}

}  // namespace

absl::StatusOr<Table> ReadBack(const Plan& plan, const Table& written, const std::string& text) {
  absl::StatusOr<Table> read = plan.format.read(plan.machine, text);
  bool is_same = read.ok() && read->kind == written.kind;
  if (is_same && written.kind == compensate::TableKind::kPoints)
    is_same = SamePoints(written, *read, plan.machine, plan.format.limits.value_step_mm);
  else if (is_same)
    is_same =
        std::equal(written.blocks.begin(), written.blocks.end(), read->blocks.begin(), read->blocks.end(), SameBlock);
  if (is_same) return read;
  return absl::InternalError(absl::StrCat("the table does not read back as it was written", read.ok() ? "" : ": ",
                                          read.ok() ? "" : read.status().message()));
}

}  // namespace axiscal::tables
