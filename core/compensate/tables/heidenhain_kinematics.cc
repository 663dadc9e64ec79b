// Heidenhain kinematics table: shifts (TRANS) and machine axes (MAXIS) in the order in which they stand from the bed to
// the table, or from the bed to the spindle. Layout as docs/tables.md says; it is assumed.
//   BEGIN TABLE.TAB MM
//   NR KEY AXIS COORD
//   0 TRANS X 0.0531
//   ...
//   3 MAXIS C 0
//   [END]
#include "core/compensate/tables/format.h"
#include "core/compensate/tables/text.h"

namespace axiscal::tables {
namespace {

using compensate::Table;
using machine::Machine;

constexpr char kLetters[] = "XYZ";
constexpr int kKinematicsDecimals = 4;

std::vector<int> RotaryOf(const Machine& machine, const std::vector<int>& branch) {
  std::vector<int> rotary;
  for (const int axis : branch) {
    if (machine.axes[axis].kind == machine::AxisKind::kRotary) rotary.push_back(axis);
  }
  return rotary;
}

void WriteBranch(const Machine& machine, const Content& content, const char* name, const std::vector<int>& branch,
                 std::string* text) {
  const std::vector<int> rotary = RotaryOf(machine, branch);
  if (rotary.empty()) return;
  absl::StrAppend(text, "BEGIN ", name, ".TAB MM\nNR KEY AXIS COORD\n");
  Eigen::Vector3d from = content.tool_tip_mm;
  int row = 0;
  for (const int axis : rotary) {
    const Eigen::Vector3d shift = content.table.points_mm.at(axis) - from;
    for (int k = 0; k < 3; ++k)
      absl::StrAppend(text, row++, " TRANS ", std::string(1, kLetters[k]), " ", Fixed(shift[k], kKinematicsDecimals),
                      "\n");
    absl::StrAppend(text, row++, " MAXIS ", machine.axes[axis].name, " 0\n");
    from = content.table.points_mm.at(axis);
  }
  absl::StrAppend(text, "[END]\n");
}

absl::StatusOr<std::string> WriteKinematics(const Machine& machine, const Content& content) {
  std::string text;
  WriteBranch(machine, content, "TABLE", machine.work_branch, &text);
  WriteBranch(machine, content, "HEAD", machine.tool_branch, &text);
  if (text.empty())
    return absl::FailedPreconditionError("machine '" + machine.id + "' has no rotary axis for a kinematics table");
  absl::StrAppend(&text, "; tool point at home: ", Fixed(content.tool_tip_mm.x(), kKinematicsDecimals), " ",
                  Fixed(content.tool_tip_mm.y(), kKinematicsDecimals), " ",
                  Fixed(content.tool_tip_mm.z(), kKinematicsDecimals),
                  "\n; shifts begin there, with all axes at zero\n");
  for (const std::string& note : content.notes) absl::StrAppend(&text, "; ", note, "\n");
  return text;
}

absl::StatusOr<Eigen::Vector3d> ReadTip(const std::vector<std::string>& lines) {
  const std::string start = "; tool point at home: ";
  for (size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].rfind(start, 0) != 0) continue;
    Eigen::Vector3d tip;
    const std::vector<std::string> words = Words(lines[i].substr(start.size()));
    for (size_t k = 0; k < 3; ++k) {
      const std::optional<double> number = words.size() == 3 ? ParseFixed(words[k]) : std::nullopt;
      if (!number) return BadLine(i + 1, lines[i], "three decimal numbers");
      tip[static_cast<Eigen::Index>(k)] = *number;
    }
    return tip;
  }
  return absl::InvalidArgumentError("no line '; tool point at home: X Y Z'");
}

absl::StatusOr<Table> ReadKinematics(const Machine& machine, const std::string& text) {
  const std::vector<std::string> lines = Lines(text);
  ASSIGN_OR_RETURN(const Eigen::Vector3d tip, ReadTip(lines));
  Table table;
  table.kind = compensate::TableKind::kPoints;
  table.points_mm.assign(static_cast<size_t>(machine.axis_count()), Eigen::Vector3d::Zero());
  std::vector<int> expected = RotaryOf(machine, machine.work_branch);
  const std::vector<int> head = RotaryOf(machine, machine.tool_branch);
  const size_t table_count = expected.size();
  expected.insert(expected.end(), head.begin(), head.end());
  size_t line = 0, row = 0;
  const auto next = [&](const std::string& wanted) -> absl::Status {
    if (line < lines.size() && lines[line] == wanted) return ++line, absl::OkStatus();
    return BadLine(line + 1, line < lines.size() ? lines[line] : "", wanted);
  };
  Eigen::Vector3d point = tip;
  for (size_t i = 0; i < expected.size(); ++i) {
    if (i == 0 || i == table_count) {
      if (i > 0) RETURN_IF_ERROR(next("[END]"));
      RETURN_IF_ERROR(next(i < table_count ? "BEGIN TABLE.TAB MM" : "BEGIN HEAD.TAB MM"));
      RETURN_IF_ERROR(next("NR KEY AXIS COORD"));
      point = tip;
      row = 0;
    }
    for (int k = 0; k < 3; ++k, ++row, ++line) {
      const std::vector<std::string> words = Words(line < lines.size() ? lines[line] : "");
      const std::optional<double> shift = words.size() == 4 ? ParseFixed(words[3]) : std::nullopt;
      const std::string wanted = absl::StrCat(row, " TRANS ", std::string(1, kLetters[k]));
      if (!shift || words[0] + " " + words[1] + " " + words[2] != wanted)
        return BadLine(line + 1, line < lines.size() ? lines[line] : "", wanted + " NUMBER");
      point[k] += *shift;
    }
    RETURN_IF_ERROR(next(absl::StrCat(row++, " MAXIS ", machine.axes[expected[i]].name, " 0")));
    table.points_mm[static_cast<size_t>(expected[i])] = point;
  }
  RETURN_IF_ERROR(next("[END]"));
  for (; line < lines.size(); ++line) {
    if (!lines[line].empty() && lines[line][0] != ';') return BadLine(line + 1, lines[line], "notes behind [END]");
  }
  return table;
}

}  // namespace

Format HeidenhainKinematicsFormat() {
  Format format;
  format.name = "heidenhain-kinematics";
  format.title = "Heidenhain kinematics table: where the rotary axes are";
  format.values = "shifts from axis to axis, mm, beginning at the tool point at home";
  format.layout = Layout::kPoints;
  format.limits.value_step_mm = 1e-4;
  format.assumed =
      "the layout of the list: no source was at hand. Take the numbers over into the control's own kinematics by hand";
  format.cannot_carry = {"tilts of the rotary axes and squareness", "errors that vary with a position",
                         "what moves all axes alike (datum)"};
  format.write = WriteKinematics;
  format.read = ReadKinematics;
  return format;
}

}  // namespace axiscal::tables
