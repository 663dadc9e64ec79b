// Fanuc three-dimensional error compensation: the corrections of three linear axes at the points of a grid over them,
// trilinear in between. Values are counts of detection units times a magnification, -128 to 127, zero at the reference
// point. Numbers of parameters and the layout of the data lines as docs/tables.md says; they are assumed.
//   N(20000 + point) P(first axis) Q(second) R(third), the first axis' position running fastest
#include <algorithm>
#include <cmath>

#include "core/compensate/tables/fanuc.h"
#include "core/compensate/tables/format.h"
#include "core/compensate/tables/text.h"

namespace axiscal::tables {
namespace {

using compensate::Table;
using compensate::TableBlock;
using machine::Machine;

constexpr int kMaxGridPoints = 25;  // along one axis
constexpr int kMostCount = 127, kMostGridMagnification = 100;
constexpr char kLetters[] = "NPQR";

size_t GridReferenceNode(const compensate::TableArgument& argument, const compensate::Pose& reference) {
  const double position = reference.position[argument.axis];
  const auto nearest = std::min_element(argument.nodes.begin(), argument.nodes.end(), [&](double a, double b) {
    return std::abs(a - position) < std::abs(b - position);
  });
  return static_cast<size_t>(nearest - argument.nodes.begin());
}

absl::Status FitGrid(const Machine& machine, Content* content) {
  TableBlock& block = content->table.blocks.at(0);
  size_t zero = 0, stride = 1;
  for (const compensate::TableArgument& argument : block.arguments) {
    zero += stride * GridReferenceNode(argument, content->reference);
    stride *= argument.nodes.size();
  }
  double largest = 0.0;
  for (compensate::TableColumn& column : block.columns) {
    const double at_reference = column.forward[zero];
    for (double& value : column.forward) {
      value -= at_reference;
      largest = std::max(largest, std::abs(value));
    }
  }
  const double least = content->value_steps[0];
  const double magnification = std::max(1.0, std::ceil(largest / least / (kMostCount + 0.49)));
  if (magnification > kMostGridMagnification) {
    return absl::FailedPreconditionError(absl::StrFormat("the largest correction is %.4f mm, fanuc-3d takes %.4f",
                                                         largest, kMostGridMagnification * kMostCount * least));
  }
  content->value_steps[0] = magnification * least;
  return absl::OkStatus();
}

absl::StatusOr<std::string> WriteGrid(const Machine& machine, const Content& content) {
  const TableBlock& block = content.table.blocks.at(0);
  const double step = content.value_steps[0], least = content.least_steps.at(block.arguments[0].axis);
  std::string text = "%\n";
  for (size_t n = 0; n < block.columns[0].forward.size(); ++n) {
    absl::StrAppend(&text, "N", 20000 + n);
    for (size_t c = 0; c < 3; ++c)
      absl::StrAppend(&text, std::string(1, kLetters[c + 1]), std::lround(block.columns[c].forward[n] / step));
    text += "\n";
  }
  text += "%\n";
  for (size_t d = 0; d < 3; ++d) {
    const compensate::TableArgument& argument = block.arguments[d];
    const size_t reference = GridReferenceNode(argument, content.reference);
    absl::StrAppend(&text, "(", machine.axes[argument.axis].name, " POINTS=", argument.nodes.size(),
                    " REFERENCE_POINT=", reference + 1, " INTERVAL=", Fixed(argument.nodes[1] - argument.nodes[0], 4),
                    " REFERENCE=", Fixed(argument.nodes[reference], 4), " MAGNIFICATION=", std::lround(step / least),
                    " UNIT=", Fixed(least, DecimalsOf(least)), ")\n");
  }
  text += FanucNoteText("the lines above are parameters 10800 to 10814, to be set by hand, one axis each");
  for (const std::string& note : content.notes) text += FanucNoteText(note);
  return text;
}

absl::StatusOr<Table> ReadGrid(const Machine& machine, const std::string& text) {
  ASSIGN_OR_RETURN(const FanucFile file, ReadFanucFile(text));
  TableBlock block;
  double step = 0.0;
  size_t count = 1;
  for (const FanucNote& note : file.notes) {
    if (note.values.count("INTERVAL") == 0) continue;
    ASSIGN_OR_RETURN(const int axis, AxisNamed(machine, note.key, note.line));
    ASSIGN_OR_RETURN(const int points, IntegerIn(note, "POINTS"));
    ASSIGN_OR_RETURN(const int reference, IntegerIn(note, "REFERENCE_POINT"));
    ASSIGN_OR_RETURN(const int magnification, IntegerIn(note, "MAGNIFICATION"));
    ASSIGN_OR_RETURN(const double interval, NumberIn(note, "INTERVAL"));
    ASSIGN_OR_RETURN(const double position, NumberIn(note, "REFERENCE"));
    ASSIGN_OR_RETURN(const double least, NumberIn(note, "UNIT"));
    if (points < 2 || points > kMaxGridPoints || reference < 1 || reference > points || !(interval > 0) ||
        !(least > 0) || magnification < 1 || magnification > kMostGridMagnification || block.arguments.size() == 3)
      return BadLine(note.line, note.key, "three axes of 2 to 25 points, the reference among them, INTERVAL above 0");
    step = magnification * least;
    count *= static_cast<size_t>(points);
    block.arguments.push_back(
        {axis, EqualNodes(position - (reference - 1) * interval, interval, static_cast<size_t>(points))});
    block.columns.push_back({axis, {}, {}});
  }
  if (block.arguments.size() != 3) return absl::InvalidArgumentError("notes of three axes must stand behind the data");
  if (file.data.size() != count)
    return absl::InvalidArgumentError(absl::StrCat(file.data.size(), " points in the file, the notes say ", count));
  for (size_t n = 0; n < count; ++n) {
    const auto& [line, words_text] = file.data[n];
    ASSIGN_OR_RETURN(const std::vector<int> words, ReadWords(line, words_text, kLetters));
    if (words[0] != 20000 + static_cast<int>(n)) return BadLine(line, words_text, absl::StrCat("N", 20000 + n));
    for (size_t c = 0; c < 3; ++c) {
      if (words[c + 1] < -kMostCount - 1 || words[c + 1] > kMostCount) return BadLine(line, words_text, "-128 to 127");
      block.columns[c].forward.push_back(words[c + 1] * step);
    }
  }
  Table table;
  table.blocks.push_back(std::move(block));
  return table;
}

}  // namespace

Format FanucGridFormat() {
  Format format;
  format.name = "fanuc-3d";
  format.title = "Fanuc three-dimensional error compensation, trilinear";
  format.values = "corrections, added to the command: counts of detection units";
  format.layout = Layout::kGrid;
  format.limits.max_points = kMaxGridPoints;
  format.limits.equal_steps = true;
  format.limits.from_reference = true;
  format.limits.holds_rotary = false;
  format.limits.is_resolution_free = true;
  format.limits.value_step_mm = 1e-3;
  format.limits.position_step_mm = 1e-3;
  format.assumed =
      "the layout of the data lines, the numbers of the parameters and the order of the points: no source was at hand. "
      "Compare them with the control's manual and arrange the numbers as it says";
  format.cannot_carry = {"backlash (fanuc-pitch)", "errors over rotary axes: the grid holds for the reference's angles",
                         "orientation of the tool"};
  format.fit = FitGrid;
  format.write = WriteGrid;
  format.read = ReadGrid;
  return format;
}

}  // namespace axiscal::tables
