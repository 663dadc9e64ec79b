// ISG volumetric compensation: the six error components of each axis over its own position, and constant parts, CSV
// with values in mm and rad; the control inverts its chain. Column layout as docs/tables.md says; it is assumed.
//   axis,position,EX_mm,EY_mm,EZ_mm,EA_rad,EB_rad,EC_rad
//   C,,0.0531000,0.0000000,...                  location errors, no position
//   X,-300.0000,-0.0030000,...                  positions in mm or deg, rising
#include "core/compensate/tables/format.h"
#include "core/compensate/tables/text.h"

namespace axiscal::tables {
namespace {

using compensate::Table;
using compensate::TableBlock;
using machine::Machine;

constexpr char kHeading[] = "axis,position,EX_mm,EY_mm,EZ_mm,EA_rad,EB_rad,EC_rad";
constexpr double kStepMm = 1e-7, kStepRad = 1e-9;
constexpr int kMaxIsgPoints = 1000;

absl::StatusOr<std::string> WriteIsg(const Machine& machine, const Content& content) {
  std::string text;
  for (const std::string& note : content.notes) absl::StrAppend(&text, "# ", note, "\n");
  absl::StrAppend(&text, kHeading, "\n");
  for (const TableBlock& block : content.table.blocks) {
    const bool is_constant = block.arguments.empty();
    const std::string name = machine::JointName(machine, block.columns[0].target / machine::kComponents);
    const size_t count = is_constant ? 1 : block.arguments[0].nodes.size();
    for (size_t n = 0; n < count; ++n) {
      absl::StrAppend(&text, name, ",");
      if (!is_constant) {
        const compensate::TableArgument& argument = block.arguments[0];
        absl::StrAppend(&text, Fixed(argument.nodes[n] / FileUnit(machine.axes[argument.axis]), 4));
      }
      for (const compensate::TableColumn& column : block.columns) {
        const bool is_angle = IsAngle(content.table, column, machine);
        absl::StrAppend(&text, ",", Fixed(column.forward[n], DecimalsOf(is_angle ? kStepRad : kStepMm)));
      }
      text += "\n";
    }
  }
  return text;
}

absl::StatusOr<Table> ReadIsg(const Machine& machine, const std::string& text) {
  Table table;
  table.kind = compensate::TableKind::kErrors;
  bool has_heading = false;
  std::string last;
  const std::vector<std::string> lines = Lines(text);
  for (size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].empty() || lines[i][0] == '#') continue;
    if (!has_heading) {
      if (lines[i] != kHeading) return BadLine(i + 1, lines[i], kHeading);
      has_heading = true;
      continue;
    }
    const std::vector<std::string> cells = Split(lines[i], ',');
    if (cells.size() != 8) return BadLine(i + 1, lines[i], "8 cells");
    ASSIGN_OR_RETURN(const int axis, AxisNamed(machine, cells[0], i + 1));
    const bool is_constant = cells[1].empty();
    const std::string group = cells[0] + (is_constant ? "" : ":");
    if (group != last) {
      TableBlock block;
      if (!is_constant) block.arguments = {{axis, {}}};
      for (int k = 0; k < machine::kComponents; ++k) block.columns.push_back({axis * machine::kComponents + k, {}, {}});
      for (const TableBlock& known : table.blocks) {
        if (known.columns[0].target == block.columns[0].target && known.arguments.empty() == is_constant)
          return BadLine(i + 1, lines[i], "the rows of an axis in one place");
      }
      table.blocks.push_back(std::move(block));
      last = group;
    } else if (is_constant) {
      return BadLine(i + 1, lines[i], "one row of constants per axis");
    }
    TableBlock& block = table.blocks.back();
    for (size_t k = 1; k < cells.size(); ++k) {
      if (k == 1 && is_constant) continue;
      const std::optional<double> value = ParseFixed(cells[k]);
      if (!value) return BadLine(i + 1, cells[k], "a decimal number");
      if (k > 1) {
        block.columns[k - 2].forward.push_back(*value);
        continue;
      }
      const double position = *value * FileUnit(machine.axes[axis]);
      RETURN_IF_ERROR(CheckIncreasing(block.arguments[0].nodes, position, i + 1));
      block.arguments[0].nodes.push_back(position);
    }
  }
  if (table.blocks.empty()) return absl::InvalidArgumentError("no row of an axis in the file");
  return table;
}

}  // namespace

Format IsgVolumetricFormat() {
  Format format;
  format.name = "isg-volumetric";
  format.title = "ISG volumetric compensation, CSV: error components of each axis over its own position";
  format.values = "errors, actual - nominal; mm, rad";
  format.layout = Layout::kComponents;
  format.limits.max_points = kMaxIsgPoints;
  format.limits.whole_axes = true;
  format.limits.value_step_mm = kStepMm;
  format.limits.value_step_deg = kStepRad;
  format.assumed = "the columns: no source was at hand. Arrange them as the control's manual says";
  format.cannot_carry = {"backlash", "errors of an axis over the position of another",
                         "errors of spindle, tool and workpiece"};
  format.write = WriteIsg;
  format.read = ReadIsg;
  return format;
}

}  // namespace axiscal::tables
