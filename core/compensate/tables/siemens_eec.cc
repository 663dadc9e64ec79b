// Siemens SINUMERIK 840D, encoder (leadscrew) error compensation EEC: $AA_ENC_COMP[encoder, N, axis] at MIN + N * STEP.
// The value is added to the actual position of the axis, so a positive one moves it negative: it is the error, actual -
// nominal (Function Manual K3, "Leadscrew error and measuring system error compensation"). MD38000 says how many points
// are reserved; linear between them.
#include "core/compensate/tables/format.h"
#include "core/compensate/tables/siemens.h"
#include "core/compensate/tables/text.h"

namespace axiscal::tables {
namespace {

using compensate::Table;
using compensate::TableBlock;
using machine::Machine;

constexpr int kMaxEecPoints = 5000;

absl::StatusOr<std::string> WriteEec(const Machine& machine, const Content& content) {
  std::string text = "%_N_AX_EEC_INI\nCHANDATA(1)\n";
  for (const std::string& note : content.notes) absl::StrAppend(&text, "; ", note, "\n");
  for (size_t b = 0; b < content.table.blocks.size(); ++b) {
    const TableBlock& block = content.table.blocks[b];
    const machine::Axis& axis = machine.axes[block.columns[0].target];
    const double unit = FileUnit(axis);
    const std::vector<double>& nodes = block.arguments[0].nodes;
    const int decimals = DecimalsOf(content.value_steps[b] / unit);
    absl::StrAppend(&text, "; axis ", axis.name, ": set MD38000 $MA_MM_ENC_COMP_MAX_POINTS[0,", axis.name,
                    "] = ", nodes.size(), " or more before, MD32700 $MA_ENC_COMP_ENABLE[0] = 1 after loading\n",
                    "; values are errors, actual - nominal: a positive one moves the axis negative\n");
    for (size_t n = 0; n < nodes.size(); ++n) {
      absl::StrAppend(&text, "$AA_ENC_COMP[0,", n, ",", axis.name,
                      "]=", Fixed(-block.columns[0].forward[n] / unit, decimals), "\n");
    }
    absl::StrAppend(&text, "$AA_ENC_COMP_STEP[0,", axis.name, "]=", Fixed((nodes[1] - nodes[0]) / unit, 4),
                    "\n$AA_ENC_COMP_MIN[0,", axis.name, "]=", Fixed(nodes.front() / unit, 4), "\n$AA_ENC_COMP_MAX[0,",
                    axis.name, "]=", Fixed(nodes.back() / unit, 4), "\n$AA_ENC_COMP_IS_MODULO[0,", axis.name, "]=0\n");
  }
  return text + "M17\n";
}

absl::StatusOr<Table> ReadEec(const Machine& machine, const std::string& text) {
  ASSIGN_OR_RETURN(const std::vector<Assignment> assignments, ReadAssignments(text));
  std::vector<std::pair<int, SiemensTable>> found;  // by axis, in the order of the file
  for (const Assignment& assignment : assignments) {
    if (assignment.indices.empty()) return BadLine(assignment.line, assignment.name, "an axis as last index");
    ASSIGN_OR_RETURN(const int axis, AxisNamed(machine, assignment.indices.back(), assignment.line));
    const bool is_value = assignment.name == "$AA_ENC_COMP";
    if (assignment.indices.size() != (is_value ? 3u : 2u) || assignment.indices[0] != "0")
      return BadLine(assignment.line, assignment.name, is_value ? "[0,number,axis]" : "[0,axis]");
    if (found.empty() || found.back().first != axis) {
      for (const auto& [known, table] : found) {
        if (known == axis) return BadLine(assignment.line, assignment.indices.back(), "the axis' lines in one place");
      }
      found.push_back({axis, {}});
    }
    SiemensTable& table = found.back().second;
    if (is_value) {
      ASSIGN_OR_RETURN(const int n, IndexOf(assignment, 1));
      if (n >= kMaxEecPoints) return BadLine(assignment.line, assignment.indices[1], "a number below 5000");
      RETURN_IF_ERROR(table.SetValue(n, assignment));
    } else if (assignment.name == "$AA_ENC_COMP_STEP") {
      RETURN_IF_ERROR(table.Set(&table.step, assignment));
    } else if (assignment.name == "$AA_ENC_COMP_MIN") {
      RETURN_IF_ERROR(table.Set(&table.min, assignment));
    } else if (assignment.name == "$AA_ENC_COMP_MAX") {
      RETURN_IF_ERROR(table.Set(&table.max, assignment));
    } else if (assignment.name != "$AA_ENC_COMP_IS_MODULO" || assignment.value != "0") {
      return BadLine(assignment.line, assignment.name, "$AA_ENC_COMP, _STEP, _MIN, _MAX or _IS_MODULO = 0");
    }
  }
  Table read;
  for (const auto& [axis, table] : found) {
    const double unit = FileUnit(machine.axes[axis]);
    ASSIGN_OR_RETURN(std::vector<double> nodes, table.Nodes("$AA_ENC_COMP of " + machine.axes[axis].name));
    for (double& node : nodes) node *= unit;
    TableBlock block;
    block.arguments = {{axis, std::move(nodes)}};
    block.columns.push_back({axis, {}, {}});
    for (const std::optional<double>& value : table.values) block.columns[0].forward.push_back(-*value * unit);
    read.blocks.push_back(std::move(block));
  }
  if (read.blocks.empty()) return absl::InvalidArgumentError("no $AA_ENC_COMP in the file");
  return read;
}

}  // namespace

Format SiemensEecFormat() {
  Format format;
  format.name = "siemens-eec";
  format.title = "Siemens SINUMERIK encoder error compensation, $AA_ENC_COMP";
  format.values = "errors, actual - nominal: a positive value moves the axis negative; mm, deg";
  format.limits.max_points = kMaxEecPoints;
  format.limits.equal_steps = true;
  format.limits.is_resolution_free = true;
  format.limits.value_step_mm = 1e-4;
  format.limits.value_step_deg = 1e-5;
  format.assumed = "written as the maker's manual is understood, not tried on a control";
  format.cannot_carry = {"backlash (MD32450 $MA_BACKLASH, or siemens-cec)",
                         "errors across the axis or over another one", "orientation of the tool"};
  format.write = WriteEec;
  format.read = ReadEec;
  return format;
}

}  // namespace axiscal::tables
