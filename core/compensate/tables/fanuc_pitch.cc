// Fanuc stored pitch error compensation: `N(10000 + point) P(value)`. Values are increments of the correction from the
// point before, -7 to 7 times the magnification (3623) in detection units, so that what the control adds at a point is
// their sum from the reference point (3620) on: zero there. Points stand 3624 apart, 3621 is the lowest and 3622 the
// highest. Bidirectional (3605#0): the second row, from 3626 on, holds while the axis moves negative, and 3627 is its
// value at the reference in detection units. Positive values move the axis positive: corrections. Linear between
// points.
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

constexpr int kMaxPitchPoints = 128;  // of one row of an axis
constexpr int kMostNumber = 1023;     // point numbers of all axes
constexpr int kMostIncrement = 7, kMostPitchMagnification = 100;

size_t PitchReferenceNode(const TableBlock& block, const compensate::Pose& reference) {
  const compensate::TableArgument& argument = block.arguments[0];
  const double position = reference.position[argument.axis];
  const auto nearest = std::min_element(argument.nodes.begin(), argument.nodes.end(), [&](double a, double b) {
    return std::abs(a - position) < std::abs(b - position);
  });
  return static_cast<size_t>(nearest - argument.nodes.begin());
}

std::vector<long> Counts(const std::vector<double>& values, double step) {
  std::vector<long> counts;
  for (const double value : values) counts.push_back(std::lround(value / step));
  return counts;
}

bool Fits(const std::vector<double>& values, double step) {
  const std::vector<long> counts = Counts(values, step);
  for (size_t i = 0; i + 1 < counts.size(); ++i) {
    if (std::abs(counts[i + 1] - counts[i]) > kMostIncrement) return false;
  }
  return true;
}

// Zero at the reference in the forward row, and the smallest magnification whose increments fit.
absl::Status FitPitch(const Machine& machine, Content* content) {
  for (size_t b = 0; b < content->table.blocks.size(); ++b) {
    TableBlock& block = content->table.blocks[b];
    compensate::TableColumn& column = block.columns[0];
    const double zero = column.forward[PitchReferenceNode(block, content->reference)];
    for (double& value : column.forward) value -= zero;
    for (double& value : column.reverse) value -= zero;
    const double least = content->value_steps[b];
    int magnification = 1;
    while (magnification <= kMostPitchMagnification &&
           !(Fits(column.forward, magnification * least) && Fits(column.reverse, magnification * least)))
      ++magnification;
    if (magnification > kMostPitchMagnification) {
      return absl::FailedPreconditionError(
          absl::StrCat("the correction of ", machine.axes[column.target].name, " changes by more than ", kMostIncrement,
                       " x ", kMostPitchMagnification, " detection units from one point to the next"));
    }
    content->value_steps[b] = magnification * least;
  }
  return absl::OkStatus();
}

void WriteRow(const std::vector<double>& values, double step, int first, std::string* text) {
  const std::vector<long> counts = Counts(values, step);
  for (size_t i = 0; i < counts.size(); ++i) {
    absl::StrAppend(text, "N", 10000 + first + static_cast<int>(i), "P", i == 0 ? 0 : counts[i] - counts[i - 1], "\n");
  }
}

absl::StatusOr<std::string> WritePitch(const Machine& machine, const Content& content) {
  std::string text = "%\n", notes;
  int next = 0;
  for (size_t b = 0; b < content.table.blocks.size(); ++b) {
    const TableBlock& block = content.table.blocks[b];
    const compensate::TableColumn& column = block.columns[0];
    const machine::Axis& axis = machine.axes[column.target];
    const std::vector<double>& nodes = block.arguments[0].nodes;
    const double unit = FileUnit(axis), step = content.value_steps[b];
    const double least = content.least_steps.at(column.target);
    const auto reference = static_cast<int>(PitchReferenceNode(block, content.reference));
    const int count = static_cast<int>(nodes.size()), first = next;
    WriteRow(column.forward, step, first, &text);
    next += count;
    absl::StrAppend(&notes, "(", axis.name, " 3620=", first + reference, " 3621=", first, " 3622=", first + count - 1,
                    " 3623=", std::lround(step / least), " 3624=", Fixed((nodes[1] - nodes[0]) / unit, 4));
    if (!column.reverse.empty()) {
      WriteRow(column.reverse, step, next, &text);
      absl::StrAppend(&notes, " 3605#0=1 3626=", next, " 3627=", std::lround(column.reverse[reference] / least));
      next += count;
    }
    absl::StrAppend(&notes, " REFERENCE=", Fixed(nodes[reference] / unit, 4),
                    " UNIT=", Fixed(least / unit, DecimalsOf(least / unit)), ")\n");
  }
  if (next - 1 > kMostNumber) {
    return absl::FailedPreconditionError(
        absl::StrCat("the corrections need ", next, " points, fanuc-pitch has 1024: choose with axes or fewer points"));
  }
  text += "%\n" + notes;
  text += FanucNoteText(
      "the lines above are parameters to be set by hand; REFERENCE is where the axis' reference position is taken to "
      "be");
  for (const std::string& note : content.notes) text += FanucNoteText(note);
  return text;
}

absl::StatusOr<std::vector<double>> ReadRow(const FanucFile& file, const FanucNote& note, int first, int count,
                                            int reference, double step, double at_reference) {
  std::vector<double> sums;
  double sum = 0.0;
  for (int i = 0; i < count; ++i) {
    const auto index = static_cast<size_t>(first + i);
    if (index >= file.data.size()) return BadLine(note.line, note.key, "a point for every number of 3621 to 3622");
    const auto& [line, text] = file.data[index];
    ASSIGN_OR_RETURN(const std::vector<int> words, ReadWords(line, text, "NP"));
    if (words[0] != 10000 + first + i) return BadLine(line, text, absl::StrCat("N", 10000 + first + i));
    if (std::abs(words[1]) > kMostIncrement) return BadLine(line, text, "P from -7 to 7");
    if (i > 0) sum += words[1] * step;
    sums.push_back(sum);
  }
  const double shift = at_reference - sums[static_cast<size_t>(reference)];
  for (double& value : sums) value += shift;
  return sums;
}

absl::StatusOr<Table> ReadPitch(const Machine& machine, const std::string& text) {
  ASSIGN_OR_RETURN(const FanucFile file, ReadFanucFile(text));
  Table table;
  size_t used = 0;
  for (const FanucNote& note : file.notes) {
    if (note.values.count("3621") == 0) continue;
    ASSIGN_OR_RETURN(const int axis, AxisNamed(machine, note.key, note.line));
    const double unit = FileUnit(machine.axes[axis]);
    ASSIGN_OR_RETURN(const int first, IntegerIn(note, "3621"));
    ASSIGN_OR_RETURN(const int last, IntegerIn(note, "3622"));
    ASSIGN_OR_RETURN(const int reference, IntegerIn(note, "3620"));
    ASSIGN_OR_RETURN(const int magnification, IntegerIn(note, "3623"));
    ASSIGN_OR_RETURN(const double interval, NumberIn(note, "3624"));
    ASSIGN_OR_RETURN(const double position, NumberIn(note, "REFERENCE"));
    ASSIGN_OR_RETURN(const double least, NumberIn(note, "UNIT"));
    const int count = last - first + 1;
    if (first < 0 || count < 2 || count > kMaxPitchPoints || reference < first || reference > last ||
        magnification < 1 || magnification > kMostPitchMagnification || !(interval > 0) || !(least > 0))
      return BadLine(note.line, note.key, "2 to 128 points, 3620 among them, 3623 from 1 to 100, 3624 above 0");
    TableBlock block;
    block.arguments = {{axis, EqualNodes((position - (reference - first) * interval) * unit, interval * unit,
                                         static_cast<size_t>(count))}};
    block.columns.push_back({axis, {}, {}});
    const double step = magnification * least * unit;
    ASSIGN_OR_RETURN(block.columns[0].forward, ReadRow(file, note, first, count, reference - first, step, 0.0));
    used += static_cast<size_t>(count);
    if (note.values.count("3626") > 0) {
      ASSIGN_OR_RETURN(const int reverse, IntegerIn(note, "3626"));
      ASSIGN_OR_RETURN(const int at_reference, IntegerIn(note, "3627"));
      if (reverse < 0) return BadLine(note.line, note.key, "3626 not below 0");
      ASSIGN_OR_RETURN(block.columns[0].reverse,
                       ReadRow(file, note, reverse, count, reference - first, step, at_reference * least * unit));
      used += static_cast<size_t>(count);
    }
    table.blocks.push_back(std::move(block));
  }
  if (table.blocks.empty()) return absl::InvalidArgumentError("no note of an axis with 3620 to 3624 behind the data");
  if (used != file.data.size())
    return BadLine(file.data.back().first, file.data.back().second, "points of the axes in the notes only");
  return table;
}

}  // namespace

Format FanucPitchFormat() {
  Format format;
  format.name = "fanuc-pitch";
  format.title = "Fanuc stored pitch error compensation, with 3620 to 3627";
  format.values = "corrections, added to the command: increments from point to point in detection units";
  format.limits.max_points = kMaxPitchPoints;
  format.limits.min_points = 3;
  format.limits.equal_steps = true;
  format.limits.from_reference = true;
  format.limits.most_increments = kMostIncrement;
  format.limits.by_sense = true;
  format.limits.is_resolution_free = true;
  format.limits.value_step_mm = 1e-3;
  format.limits.value_step_deg = 1e-3;
  format.limits.position_step_mm = 1e-3;
  format.limits.position_step_deg = 1e-3;
  format.assumed =
      "an increment is spread evenly over its interval, reference return is in the positive direction, text behind the "
      "closing % is not read; written as the maker's manual is understood, not tried on a control";
  format.cannot_carry = {"errors across the axis or over another one", "orientation of the tool"};
  format.fit = FitPitch;
  format.write = WritePitch;
  format.read = ReadPitch;
  return format;
}

}  // namespace axiscal::tables
