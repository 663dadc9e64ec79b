// Heidenhain .COM: the error of an axis over its own position, at equal steps of a power of two times 0.0001 mm (or
// deg) from a datum; a .CMA names the .COM of each axis. Layout and sign as docs/tables.md says; they are assumed.
//   BEGIN X.COM DATUM:-300.0000 DIST:22
//   NR X=F(X)
//   0 -0.0030
//   [END]
#include <cmath>

#include "core/compensate/tables/format.h"
#include "core/compensate/tables/text.h"

namespace axiscal::tables {
namespace {

using compensate::Table;
using compensate::TableBlock;
using machine::Machine;

constexpr int kMaxComPoints = 256;
constexpr double kUnit = 1e-4;  // mm or deg

absl::StatusOr<std::string> WriteCom(const Machine& machine, const Content& content) {
  const TableBlock& block = content.table.blocks.at(0);
  const machine::Axis& axis = machine.axes[block.columns[0].target];
  const double unit = FileUnit(axis);
  const std::vector<double>& nodes = block.arguments[0].nodes;
  const long exponent = std::lround(std::log2((nodes[1] - nodes[0]) / unit / kUnit));
  std::string text = absl::StrCat("BEGIN ", axis.name, ".COM DATUM:", Fixed(nodes[0] / unit, 4), " DIST:", exponent,
                                  "\nNR ", axis.name, "=F(", axis.name, ")\n");
  for (size_t n = 0; n < nodes.size(); ++n)
    absl::StrAppend(&text, n, " ", Fixed(-block.columns[0].forward[n] / unit, 4), "\n");
  absl::StrAppend(&text, "[END]\n; the .CMA names this file in column ", axis.name, ": ", axis.name, ".COM\n");
  for (const std::string& note : content.notes) absl::StrAppend(&text, "; ", note, "\n");
  return text;
}

absl::StatusOr<Table> ReadCom(const Machine& machine, const std::string& text) {
  const std::vector<std::string> lines = Lines(text);
  const std::vector<std::string> head = Words(lines.empty() ? "" : lines[0]);
  const bool is_head = head.size() == 4 && head[0] == "BEGIN" && head[1].size() > 4 &&
                       head[1].substr(head[1].size() - 4) == ".COM" && head[2].rfind("DATUM:", 0) == 0 &&
                       head[3].rfind("DIST:", 0) == 0;
  const std::optional<double> datum = is_head ? ParseFixed(head[2].substr(6)) : std::nullopt;
  const std::optional<double> exponent = is_head ? ParseFixed(head[3].substr(5)) : std::nullopt;
  if (!datum || !exponent || *exponent != std::round(*exponent) || *exponent < 0 || *exponent > 40)
    return BadLine(1, lines.empty() ? "" : lines[0], "BEGIN AXIS.COM DATUM:NUMBER DIST:EXPONENT");
  const std::string name = head[1].substr(0, head[1].size() - 4);
  ASSIGN_OR_RETURN(const int axis, AxisNamed(machine, name, 1));
  if (lines.size() < 2 || lines[1] != "NR " + name + "=F(" + name + ")")
    return BadLine(2, lines.size() < 2 ? "" : lines[1], "NR " + name + "=F(" + name + ")");
  const double unit = FileUnit(machine.axes[axis]);
  TableBlock block;
  block.columns.push_back({axis, {}, {}});
  size_t i = 2;
  for (; i < lines.size() && lines[i] != "[END]"; ++i) {
    const std::vector<std::string> words = Words(lines[i]);
    const std::optional<double> value = words.size() == 2 ? ParseFixed(words[1]) : std::nullopt;
    if (!value || words[0] != absl::StrCat(i - 2))
      return BadLine(i + 1, lines[i], absl::StrCat(i - 2, " and a decimal number"));
    if (i - 2 == kMaxComPoints) return BadLine(i + 1, lines[i], "at most 256 points");
    block.columns[0].forward.push_back(-*value * unit);
  }
  const size_t count = block.columns[0].forward.size();
  if (i == lines.size() || count < 2) return BadLine(i, "", "two points or more, then [END]");
  for (++i; i < lines.size(); ++i) {
    if (!lines[i].empty() && lines[i][0] != ';') return BadLine(i + 1, lines[i], "notes behind [END]");
  }
  block.arguments = {{axis, EqualNodes(*datum * unit, std::ldexp(kUnit, static_cast<int>(*exponent)) * unit, count)}};
  Table table;
  table.blocks.push_back(std::move(block));
  return table;
}

}  // namespace

Format HeidenhainComFormat() {
  Format format;
  format.name = "heidenhain-com";
  format.title = "Heidenhain axis error compensation table .COM";
  format.values = "errors, actual - nominal; mm, deg";
  format.limits.max_points = kMaxComPoints;
  format.limits.equal_steps = true;
  format.limits.power_of_two_steps = true;
  format.limits.one_axis = true;
  format.limits.value_step_mm = kUnit;
  format.limits.value_step_deg = kUnit;
  format.assumed = "layout and sign: no source was at hand. Compare them with a table of the control";
  format.cannot_carry = {"backlash (machine parameter)", "errors across the axis or over another one",
                         "orientation of the tool"};
  format.write = WriteCom;
  format.read = ReadCom;
  return format;
}

}  // namespace axiscal::tables
