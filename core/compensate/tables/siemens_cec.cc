// Siemens SINUMERIK 840D, cross-error compensation CEC: table t holds $AN_CEC[t, N] at MIN + N * STEP of its input
// axis, for its output axis; $AN_CEC_DIRECTION 1 acts while the input axis moves to higher positions, -1 to lower ones,
// 0 always: backlash and other errors by sense of motion are pairs of tables. Values of all active tables of an axis
// add up. Sign as of EEC: a positive total moves the output axis negative, so values are errors (docs/tables.md).
#include "core/compensate/tables/format.h"
#include "core/compensate/tables/siemens.h"
#include "core/compensate/tables/text.h"

namespace axiscal::tables {
namespace {

using compensate::Table;
using compensate::TableBlock;
using machine::Machine;

constexpr int kMaxCecPoints = 2000, kMaxTables = 62;

void WriteTable(const Machine& machine, const TableBlock& block, const std::vector<double>& values, double step,
                int number, int direction, std::string* text) {
  const machine::Axis& input = machine.axes[block.arguments[0].axis];
  const machine::Axis& output = machine.axes[block.columns[0].target];
  const std::vector<double>& nodes = block.arguments[0].nodes;
  const double unit = FileUnit(input), value_unit = FileUnit(output);
  absl::StrAppend(text, "; table ", number, ": ", output.name, " over ", input.name,
                  direction == 0  ? ""
                  : direction > 0 ? " while it rises"
                                  : " while it falls",
                  "; set MD18342 $MN_MM_CEC_MAX_POINTS[", number, "] = ", nodes.size(), " or more before loading\n");
  for (size_t n = 0; n < nodes.size(); ++n) {
    absl::StrAppend(text, "$AN_CEC[", number, ",", n,
                    "]=", Fixed(-values[n] / value_unit, DecimalsOf(step / value_unit)), "\n");
  }
  const std::string of = absl::StrCat("[", number, "]=");
  absl::StrAppend(text, "$AN_CEC_INPUT_AXIS", of, "(", input.name, ")\n$AN_CEC_OUTPUT_AXIS", of, "(", output.name,
                  ")\n$AN_CEC_STEP", of, Fixed((nodes[1] - nodes[0]) / unit, 4));
  absl::StrAppend(text, "\n$AN_CEC_MIN", of, Fixed(nodes.front() / unit, 4), "\n$AN_CEC_MAX", of,
                  Fixed(nodes.back() / unit, 4), "\n$AN_CEC_DIRECTION", of, direction, "\n$AN_CEC_MULT_BY_TABLE", of,
                  "0\n$AN_CEC_IS_MODULO", of, "0\n");
}

absl::StatusOr<std::string> WriteCec(const Machine& machine, const Content& content) {
  std::string text = "%_N_NC_CEC_INI\nCHANDATA(1)\n";
  for (const std::string& note : content.notes) absl::StrAppend(&text, "; ", note, "\n");
  absl::StrAppend(&text,
                  "; after loading: SD41300 $SN_CEC_TABLE_ENABLE of each table and MD32710 $MA_CEC_ENABLE of the "
                  "output axes = 1\n");
  int number = 0;
  for (size_t b = 0; b < content.table.blocks.size(); ++b) {
    const TableBlock& block = content.table.blocks[b];
    const compensate::TableColumn& column = block.columns[0];
    const double step = content.value_steps[b];
    WriteTable(machine, block, column.forward, step, number++, column.reverse.empty() ? 0 : 1, &text);
    if (!column.reverse.empty()) WriteTable(machine, block, column.reverse, step, number++, -1, &text);
  }
  if (number > kMaxTables) {
    return absl::FailedPreconditionError(
        absl::StrCat("the corrections need ", number, " tables, siemens-cec has ", kMaxTables, ": choose with axes"));
  }
  return text + "M17\n";
}

struct CecTable {
  SiemensTable numbers;
  int input = -1, output = -1;
  std::optional<double> direction;
};

absl::Status ReadAxis(const Machine& machine, const Assignment& assignment, int* axis) {
  const std::string& value = assignment.value;
  if (value.size() < 3 || value.front() != '(' || value.back() != ')')
    return BadLine(assignment.line, value, "an axis in parentheses");
  if (*axis >= 0) return BadLine(assignment.line, assignment.name, "every value once");
  ASSIGN_OR_RETURN(*axis, AxisNamed(machine, value.substr(1, value.size() - 2), assignment.line));
  return absl::OkStatus();
}

absl::Status ReadInto(const Machine& machine, const Assignment& assignment, CecTable* table) {
  const std::string& name = assignment.name;
  if (assignment.indices.size() != (name == "$AN_CEC" ? 2u : 1u))
    return BadLine(assignment.line, name, name == "$AN_CEC" ? "[table,number]" : "[table]");
  if (name == "$AN_CEC") {
    ASSIGN_OR_RETURN(const int n, IndexOf(assignment, 1));
    if (n >= kMaxCecPoints) return BadLine(assignment.line, assignment.indices[1], "a number below 2000");
    return table->numbers.SetValue(n, assignment);
  }
  if (name == "$AN_CEC_INPUT_AXIS") return ReadAxis(machine, assignment, &table->input);
  if (name == "$AN_CEC_OUTPUT_AXIS") return ReadAxis(machine, assignment, &table->output);
  if (name == "$AN_CEC_STEP") return table->numbers.Set(&table->numbers.step, assignment);
  if (name == "$AN_CEC_MIN") return table->numbers.Set(&table->numbers.min, assignment);
  if (name == "$AN_CEC_MAX") return table->numbers.Set(&table->numbers.max, assignment);
  if (name == "$AN_CEC_DIRECTION") return table->numbers.Set(&table->direction, assignment);
  if ((name == "$AN_CEC_MULT_BY_TABLE" || name == "$AN_CEC_IS_MODULO") && assignment.value == "0")
    return absl::OkStatus();
  return BadLine(assignment.line, name, "$AN_CEC and its fields, _MULT_BY_TABLE and _IS_MODULO = 0");
}

// The tables of an axis by sense of motion are one block.
absl::Status Append(const Machine& machine, const CecTable& table, bool* is_open, Table* read) {
  const std::string name = "a table of $AN_CEC";
  if (table.input < 0 || table.output < 0 || !table.direction)
    return absl::InvalidArgumentError(name + " lacks _INPUT_AXIS, _OUTPUT_AXIS or _DIRECTION");
  ASSIGN_OR_RETURN(std::vector<double> nodes, table.numbers.Nodes(name));
  for (double& node : nodes) node *= FileUnit(machine.axes[table.input]);
  std::vector<double> values;
  for (const std::optional<double>& value : table.numbers.values)
    values.push_back(-*value * FileUnit(machine.axes[table.output]));
  const double direction = *table.direction;
  if (direction == -1.0) {
    if (!*is_open || read->blocks.back().arguments[0].axis != table.input ||
        read->blocks.back().arguments[0].nodes != nodes || read->blocks.back().columns[0].target != table.output)
      return absl::InvalidArgumentError(name +
                                        " of direction -1 stands alone, expected its pair of direction 1 before it");
    read->blocks.back().columns[0].reverse = std::move(values);
    *is_open = false;
    return absl::OkStatus();
  }
  if (*is_open || (direction != 0.0 && direction != 1.0))
    return absl::InvalidArgumentError(name +
                                      " of direction 1 stands alone, expected its pair of direction -1 behind it");
  TableBlock block;
  block.arguments = {{table.input, std::move(nodes)}};
  block.columns.push_back({table.output, std::move(values), {}});
  read->blocks.push_back(std::move(block));
  *is_open = direction == 1.0;
  return absl::OkStatus();
}

absl::StatusOr<Table> ReadCec(const Machine& machine, const std::string& text) {
  ASSIGN_OR_RETURN(const std::vector<Assignment> assignments, ReadAssignments(text));
  std::vector<CecTable> tables;
  for (const Assignment& assignment : assignments) {
    ASSIGN_OR_RETURN(const int number, IndexOf(assignment, 0));
    if (number >= kMaxTables) return BadLine(assignment.line, assignment.indices[0], "a table below 62");
    const auto index = static_cast<size_t>(number);
    if (index > tables.size()) return BadLine(assignment.line, assignment.indices[0], "tables in order from 0");
    if (index == tables.size()) tables.emplace_back();
    RETURN_IF_ERROR(ReadInto(machine, assignment, &tables[index]));
  }
  Table read;
  bool is_open = false;
  for (const CecTable& table : tables) RETURN_IF_ERROR(Append(machine, table, &is_open, &read));
  if (tables.empty() || is_open) return absl::InvalidArgumentError("no whole $AN_CEC table in the file");
  return read;
}

}  // namespace

Format SiemensCecFormat() {
  Format format;
  format.name = "siemens-cec";
  format.title = "Siemens SINUMERIK cross-error compensation, $AN_CEC: any axis over any axis, pairs by direction";
  format.values = "errors, actual - nominal: a positive value moves the axis negative; mm, deg";
  format.layout = Layout::kAnyAxis;
  format.limits.max_points = kMaxCecPoints;
  format.limits.equal_steps = true;
  format.limits.by_sense = true;
  format.limits.is_resolution_free = true;
  format.limits.value_step_mm = 1e-4;
  format.limits.value_step_deg = 1e-5;
  format.assumed =
      "the sign is that of siemens-eec; written as the maker's manual is understood, not tried on a control";
  format.cannot_carry = {"errors that two axes make together (angles with a lever along another axis)",
                         "more than 62 tables"};
  format.write = WriteCec;
  format.read = ReadCec;
  return format;
}

}  // namespace axiscal::tables
