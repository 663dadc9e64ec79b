// LinuxCNC's COMP_FILE: one joint, up to 256 lines `nominal forward-trim reverse-trim` (COMP_FILE_TYPE = 1), in
// ascending order, mm or deg. As LinuxCNC 2.9 computes (src/emc/motion: usrmotintf.cc usrmotLoadComp, command.c
// EMCMOT_SET_JOINT_COMP, control.c compute_screw_comp): trims are added to the command, linear between the nominals,
// the end's value beyond them; forward while the joint moves to higher positions.
//
// The first line that is not three numbers ends the table in silence, so notes stand behind the last point.
#include "core/base/units.h"
#include "core/compensate/tables/format.h"
#include "core/compensate/tables/text.h"

namespace axiscal::tables {
namespace {

using compensate::Table;
using compensate::TableBlock;
using machine::Machine;

constexpr int kMaxCompPoints = 256;  // EMCMOT_COMP_SIZE

absl::StatusOr<std::string> WriteComp(const Machine& machine, const Content& content) {
  const TableBlock& block = content.table.blocks.at(0);
  const int index = block.arguments[0].axis;
  const machine::Axis& axis = machine.axes[index];
  const double unit = FileUnit(axis);
  const std::vector<double>& forward = block.columns[0].forward;
  const std::vector<double>& reverse = block.columns[0].reverse.empty() ? forward : block.columns[0].reverse;
  const int decimals = DecimalsOf(content.value_steps[0] / unit);
  std::string text;
  for (size_t i = 0; i < forward.size(); ++i) {
    absl::StrAppend(&text, Fixed(block.arguments[0].nodes[i] / unit, 4), " ", Fixed(forward[i] / unit, decimals), " ",
                    Fixed(reverse[i] / unit, decimals), "\n");
  }
  absl::StrAppend(&text, "# axis: ", axis.name, "\n# ", forward.size(),
                  " points above: nominal position, forward trim, reverse trim, ", UnitName(axis),
                  "; trims are corrections, added to the command\n", "# INI, section [JOINT_n] of ", axis.name,
                  ": COMP_FILE = this file, COMP_FILE_TYPE = 1 (type 0 would turn every sign); BACKLASH is not used "
                  "beside it\n");
  for (const std::string& note : content.notes) absl::StrAppend(&text, "# ", note, "\n");
  return text;
}

absl::StatusOr<Table> ReadComp(const Machine& machine, const std::string& text) {
  const std::vector<std::string> lines = Lines(text);
  size_t count = 0;
  while (count < lines.size() && !lines[count].empty() && lines[count][0] != '#') ++count;
  std::string name;
  for (size_t i = count; i < lines.size(); ++i) {
    if (!lines[i].empty() && lines[i][0] != '#')
      return BadLine(i + 1, lines[i], "a note: LinuxCNC reads no point behind the first line that is none");
    if (lines[i].rfind("# axis: ", 0) == 0) name = Strip(lines[i].substr(8));
  }
  if (name.empty()) return absl::InvalidArgumentError("no line '# axis: NAME' behind the points");
  ASSIGN_OR_RETURN(const int axis, AxisNamed(machine, name, count + 1));
  if (count < 1) return BadLine(1, lines.empty() ? "" : lines[0], "nominal, forward trim, reverse trim");
  if (count > kMaxCompPoints)
    return BadLine(kMaxCompPoints + 1, lines[kMaxCompPoints], absl::StrCat("at most ", kMaxCompPoints, " points"));
  const double unit = FileUnit(machine.axes[axis]);
  TableBlock block;
  block.arguments = {{axis, {}}};
  block.columns.push_back({axis, {}, {}});
  for (size_t i = 0; i < count; ++i) {
    const std::vector<std::string> words = Words(lines[i]);
    std::vector<double> numbers;
    for (const std::string& word : words) {
      if (const std::optional<double> number = ParseFixed(word)) numbers.push_back(*number * unit);
    }
    if (words.size() != 3 || numbers.size() != 3)
      return BadLine(i + 1, lines[i], "three decimal numbers: nominal, forward trim, reverse trim");
    RETURN_IF_ERROR(CheckIncreasing(block.arguments[0].nodes, numbers[0], i + 1));
    block.arguments[0].nodes.push_back(numbers[0]);
    block.columns[0].forward.push_back(numbers[1]);
    block.columns[0].reverse.push_back(numbers[2]);
  }
  Table table;
  table.blocks.push_back(std::move(block));
  return table;
}

}  // namespace

Format LinuxcncCompFormat() {
  Format format;
  format.name = "linuxcnc-comp";
  format.title = "LinuxCNC COMP_FILE of a joint, COMP_FILE_TYPE = 1";
  format.values = "corrections, added to the command, forward and reverse; mm, deg";
  format.limits.max_points = kMaxCompPoints;
  format.limits.by_sense = true;
  format.limits.one_axis = true;
  format.cannot_carry = {"what an axis does across its own direction (straightness, squareness)",
                         "errors that depend on another axis", "orientation of the tool"};
  format.write = WriteComp;
  format.read = ReadComp;
  return format;
}

}  // namespace axiscal::tables
