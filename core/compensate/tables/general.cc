// The general table: CSV with ISO 230-1 names as columns and axis positions as arguments, units in the header.
//
//   # block: X                                            one block per set of arguments; `constant` has none
//   X_mm,sense,EXX_um,EYX_um,EBX_urad                     arguments, then errors = actual - nominal
//   -200.0000,1,-2.0131,0.4012,11.1000                    sense 1: while the first argument's axis rises, -1: falls;
//   -200.0000,-1,1.9869,0.4012,11.1000                    blocks without that column hold for both
// An error is the sum over the blocks that name it: linear between the rows (over several arguments multilinear), the
// end's value beyond them. `0` in a name (EX0C) marks a constant (docs/formats.md).
#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/compensate/tables/format.h"
#include "core/compensate/tables/text.h"

namespace axiscal::tables {
namespace {

using compensate::Table;
using compensate::TableBlock;
using compensate::TableColumn;
using machine::Machine;

constexpr double kStepUm = 1e-3, kStepUrad = 1e-3;
constexpr int kGeneralDecimals = 3;

std::string Quoted(const std::string& name) { return "'" + name + "'"; }

void WriteRow(const Machine& machine, const TableBlock& block, size_t node, const char* sense, bool reverse,
              const Table& table, std::string* text) {
  std::string row;
  size_t rest = node;
  for (const compensate::TableArgument& argument : block.arguments) {
    const double position = argument.nodes[rest % argument.nodes.size()];
    rest /= argument.nodes.size();
    absl::StrAppend(&row, row.empty() ? "" : ",", Fixed(position / FileUnit(machine.axes[argument.axis]), 4));
  }
  if (sense != nullptr) absl::StrAppend(&row, ",", sense);
  for (const TableColumn& column : block.columns) {
    const double factor = IsAngle(table, column, machine) ? base::kUradPerRad : base::kUmPerMm;
    const std::vector<double>& values = reverse && !column.reverse.empty() ? column.reverse : column.forward;
    absl::StrAppend(&row, row.empty() ? "" : ",", Fixed(values[node] * factor, kGeneralDecimals));
  }
  absl::StrAppend(text, row, "\n");
}

absl::StatusOr<std::string> WriteGeneral(const Machine& machine, const Content& content) {
  std::string text;
  for (const std::string& note : content.notes) absl::StrAppend(&text, "# ", note, "\n");
  for (const TableBlock& block : content.table.blocks) {
    std::string name, heading;
    size_t nodes = 1;
    bool by_sense = false;
    for (const compensate::TableArgument& argument : block.arguments) {
      const machine::Axis& axis = machine.axes[argument.axis];
      absl::StrAppend(&name, name.empty() ? "" : " ", axis.name);
      absl::StrAppend(&heading, heading.empty() ? "" : ",", axis.name, "_", UnitName(axis));
      nodes *= argument.nodes.size();
    }
    for (const TableColumn& column : block.columns) by_sense |= !column.reverse.empty();
    if (by_sense) heading += ",sense";
    for (const TableColumn& column : block.columns) {
      absl::StrAppend(&heading, heading.empty() ? "" : ",", TargetName(content.table, block, column, machine),
                      IsAngle(content.table, column, machine) ? "_urad" : "_um");
    }
    absl::StrAppend(&text, "# block: ", name.empty() ? "constant" : name, "\n", heading, "\n");
    for (size_t node = 0; node < nodes; ++node) {
      WriteRow(machine, block, node, by_sense ? "1" : nullptr, false, content.table, &text);
      if (by_sense) WriteRow(machine, block, node, "-1", true, content.table, &text);
    }
  }
  return text;
}

// Reads one block: its heading, then rows until the next block.
class BlockReader {
 public:
  explicit BlockReader(const Machine& machine) : machine_(machine) {}

  absl::Status Heading(const std::string& line, size_t number) {
    const std::vector<std::string> names = Split(line, ',');
    for (const std::string& name : names) {
      const size_t bar = name.rfind('_');
      const std::string stem = name.substr(0, bar), unit = bar == std::string::npos ? "" : name.substr(bar + 1);
      if (name == "sense" && !by_sense_ && block_.columns.empty() && !block_.arguments.empty()) {
        by_sense_ = true;
        continue;
      }
      if (const int axis = machine::FindAxis(machine_, stem); axis >= 0) {
        if (unit != UnitName(machine_.axes[axis]) || by_sense_ || !block_.columns.empty())
          return BadLine(number, name, Quoted(stem + "_" + UnitName(machine_.axes[axis])) + " before sense and errors");
        for (const compensate::TableArgument& argument : block_.arguments) {
          if (argument.axis == axis) return BadLine(number, name, "every column once");
        }
        block_.arguments.push_back({axis, {}});
        continue;
      }
      RETURN_IF_ERROR(ErrorColumn(name, stem, unit, number));
    }
    if (block_.columns.empty()) return BadLine(number, line, "at least one error: EXX_um");
    return absl::OkStatus();
  }

  absl::Status Row(const std::string& line, size_t number) {
    const std::vector<std::string> cells = Split(line, ',');
    const size_t senses = by_sense_ ? 1 : 0, arguments = block_.arguments.size();
    if (cells.size() != arguments + senses + block_.columns.size())
      return BadLine(number, line, absl::StrCat(arguments + senses + block_.columns.size(), " cells"));
    std::vector<double> numbers;
    for (const std::string& cell : cells) {
      const std::optional<double> value = ParseFixed(Strip(cell));
      if (!value) return BadLine(number, cell, "a decimal number");
      numbers.push_back(*value);
    }
    const bool reverse = by_sense_ && numbers[arguments] < 0;
    if (by_sense_ && (std::abs(numbers[arguments]) != 1.0 || reverse != (rows_ % 2 == 1)))
      return BadLine(number, cells[arguments], rows_ % 2 == 1 ? "-1, behind the row of sense 1" : "1");
    std::vector<double> position(numbers.begin(), numbers.begin() + static_cast<long>(arguments));
    for (size_t d = 0; d < arguments; ++d) position[d] *= FileUnit(machine_.axes[block_.arguments[d].axis]);
    if (reverse && position != positions_.back()) return BadLine(number, line, "the positions of the row above");
    if (!reverse) positions_.push_back(position);
    for (size_t c = 0; c < block_.columns.size(); ++c) {
      std::vector<double>& values = reverse ? block_.columns[c].reverse : block_.columns[c].forward;
      values.push_back(numbers[arguments + senses + c] * units_[c]);
    }
    ++rows_;
    last_line_ = number;
    return absl::OkStatus();
  }

  // The block, once its rows are found to be a whole grid, the first argument running fastest.
  absl::StatusOr<TableBlock> Finish() {
    if (rows_ == 0 || (by_sense_ && rows_ % 2 == 1))
      return absl::InvalidArgumentError(absl::StrCat("line ", last_line_, ": the block ends too early"));
    size_t expected = 1;
    for (size_t d = 0; d < block_.arguments.size(); ++d) {
      std::vector<double>& nodes = block_.arguments[d].nodes;
      for (const std::vector<double>& position : positions_) nodes.push_back(position[d]);
      std::sort(nodes.begin(), nodes.end());
      nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
      expected *= nodes.size();
    }
    bool is_grid = positions_.size() == expected;
    for (size_t row = 0; is_grid && row < positions_.size(); ++row) {
      size_t rest = row;
      for (size_t d = 0; d < block_.arguments.size(); ++d) {
        const std::vector<double>& nodes = block_.arguments[d].nodes;
        is_grid &= positions_[row][d] == nodes[rest % nodes.size()];
        rest /= nodes.size();
      }
    }
    if (is_grid) return std::move(block_);
    return absl::InvalidArgumentError(
        absl::StrCat("line ", last_line_,
                     ": the rows of this block are no whole grid with increasing positions, the "
                     "first argument running fastest"));
  }

 private:
  absl::Status ErrorColumn(const std::string& name, const std::string& stem, const std::string& unit, size_t line) {
    const auto symbol = machine::ParseErrorSymbol(stem);
    const int joint = symbol.ok() ? machine::FindJoint(machine_, symbol->axis) : -1;
    if (joint < 0) return BadLine(line, name, "an axis of the machine with _mm or _deg, or an error with _um or _urad");
    const bool angle = machine::IsAngle(symbol->component);
    if (unit != (angle ? "urad" : "um")) return BadLine(line, name, Quoted(stem + (angle ? "_urad" : "_um")));
    if (symbol->is_constant != block_.arguments.empty())
      return BadLine(line, name, "names with 0 (EX0C) in the block of constants only");
    const int target = joint * machine::kComponents + static_cast<int>(symbol->component);
    for (const TableColumn& column : block_.columns) {
      if (column.target == target) return BadLine(line, name, "every column once");
    }
    block_.columns.push_back({target, {}, {}});
    units_.push_back(angle ? base::kRadPerUrad : base::kMmPerUm);
    return absl::OkStatus();
  }

  const Machine& machine_;
  TableBlock block_;
  bool by_sense_ = false;
  std::vector<double> units_;
  std::vector<std::vector<double>> positions_;
  size_t rows_ = 0, last_line_ = 0;
};

absl::StatusOr<Table> ReadGeneral(const Machine& machine, const std::string& text) {
  Table table;
  table.kind = compensate::TableKind::kErrors;
  const std::vector<std::string> lines = Lines(text);
  for (size_t i = 0; i < lines.size();) {
    if (lines[i].empty() || (lines[i][0] == '#' && lines[i].rfind("# block:", 0) != 0)) {
      ++i;
      continue;
    }
    if (lines[i][0] == '#') ++i;
    if (i == lines.size()) return BadLine(i, "", "a heading behind '# block:'");
    BlockReader reader(machine);
    RETURN_IF_ERROR(reader.Heading(lines[i], i + 1));
    for (++i; i < lines.size() && !lines[i].empty() && lines[i][0] != '#'; ++i)
      RETURN_IF_ERROR(reader.Row(lines[i], i + 1));
    ASSIGN_OR_RETURN(TableBlock block, reader.Finish());
    table.blocks.push_back(std::move(block));
  }
  return table;
}

}  // namespace

Format GeneralFormat() {
  Format format;
  format.name = "general";
  format.title = "General table: CSV, ISO 230-1 names as columns, axis positions as arguments";
  format.values = "errors, actual - nominal; um, urad";
  format.layout = Layout::kComponents;
  format.limits.max_points = 20000;
  format.limits.by_sense = true;
  format.limits.value_step_mm = kStepUm * base::kMmPerUm;
  format.limits.value_step_deg = kStepUrad * base::kRadPerUrad;
  format.write = WriteGeneral;
  format.read = ReadGeneral;
  return format;
}

}  // namespace axiscal::tables
