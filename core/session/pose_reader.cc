#include "core/session/pose_reader.h"

#include <algorithm>
#include <filesystem>
#include <limits>

#include "core/base/files.h"
#include "core/base/units.h"
#include "core/session/text.h"

namespace axiscal::session {
namespace {

using machine::Axis;
using machine::AxisKind;

constexpr size_t kBlockRows = 4096;

std::string PoseColumn(const Axis& axis) { return axis.name + (axis.kind == AxisKind::kLinear ? "_mm" : "_deg"); }

std::string PoseColumns(const machine::Machine& machine) {
  std::string names;
  for (const Axis& axis : machine.axes) absl::StrAppend(&names, PoseColumn(axis), ", ");
  return names + "t_s, temp_C and other columns of a session's state, no readings";
}

// A position beyond the travel is refused, but for the last digit that is shown (check_machine.cc).
void KeepToTravel(const Axis& axis, ColumnRule* rule) {
  if (!axis.min_position || !axis.max_position) return;
  constexpr double kLastDigit = 1e-3;  // mm or deg
  const double unit = axis.kind == AxisKind::kLinear ? 1.0 : base::kRadPerDeg;
  const double min = *axis.min_position / unit, max = *axis.max_position / unit;
  rule->min = min - kLastDigit;
  rule->max = max + kLastDigit;
  rule->expected = absl::StrFormat("%s from %g to %g, the travel of %s", axis.kind == AxisKind::kLinear ? "mm" : "deg",
                                   min, max, axis.name);
}

}  // namespace

PoseReader::PoseReader(const std::string& path, const machine::Machine& machine) : path_(path), machine_(machine) {}

absl::StatusOr<std::unique_ptr<PoseReader>> PoseReader::Open(const std::string& path, const machine::Machine& machine) {
  RETURN_IF_ERROR(base::RequireFile(path));
  std::unique_ptr<PoseReader> reader(new PoseReader(path, machine));
  reader->in_.open(path, std::ios::binary);
  if (!reader->in_) return absl::InvalidArgumentError(path + ": cannot be opened");
  std::error_code error;
  reader->bytes_ = std::max(1.0, static_cast<double>(std::filesystem::file_size(path, error)));
  reader->lines_ = std::make_unique<LineReader>(reader->in_, std::numeric_limits<size_t>::max());
  RETURN_IF_ERROR(base::Within(path, reader->ReadColumns()));
  return reader;
}

absl::StatusOr<ColumnRule> PoseReader::RuleOf(const std::string& name, const std::string& place) const {
  std::optional<ColumnRule> rule = StateColumnRule(name);
  if (!rule || rule->IsSense())
    return absl::InvalidArgumentError(
        absl::StrCat(place, ": unknown column for poses, expected ", PoseColumns(machine_)));
  if (rule->axis.empty()) return *rule;
  const int found = machine::FindAxis(machine_, rule->axis);
  if (found < 0)
    return absl::InvalidArgumentError(absl::StrCat(place, ": machine ", machine_.id, " has no axis ", rule->axis));
  const Axis& axis = machine_.axes[found];
  if ((axis.kind == AxisKind::kLinear) != rule->IsLinear()) {
    return absl::InvalidArgumentError(absl::StrCat(place, ": ", axis.name, " is ",
                                                   axis.kind == AxisKind::kLinear ? "linear" : "rotary", ", expected ",
                                                   axis.kind == AxisKind::kLinear ? "mm" : "deg"));
  }
  if (rule->IsAxis()) KeepToTravel(axis, &*rule);
  return *rule;
}

absl::Status PoseReader::RequireAxes(size_t line) const {
  for (size_t i = 0; i < column_of_axis_.size(); ++i) {
    if (column_of_axis_[i] >= 0) continue;
    const Axis& axis = machine_.axes[i];
    return absl::InvalidArgumentError(absl::StrCat("line ", line, ": axis ", axis.name, " of machine ", machine_.id,
                                                   " has no column, expected ", PoseColumn(axis)));
  }
  return absl::OkStatus();
}

absl::Status PoseReader::ReadColumns() {
  Line line;
  ASSIGN_OR_RETURN(const std::vector<HeaderEntry> header, ReadHeaderLines(*lines_, &line));
  for (size_t i = 0; i < header.size(); ++i) {
    if (header[i].key != "machine" || header[i].value == machine_.id) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("line ", HeaderLine(i), ": machine: ", Quoted(header[i].value), ", expected '", machine_.id, "'"));
  }
  const std::vector<std::string> names = SplitCells(line.text);
  if (names.size() > kMaxColumns) {
    return absl::InvalidArgumentError(
        absl::StrCat("line ", line.number, ": ", names.size(), " columns, at most ", kMaxColumns, " are read"));
  }
  column_of_axis_.assign(machine_.axes.size(), -1);
  for (size_t i = 0; i < names.size(); ++i) {
    const std::string place = Place(line.number, i, names[i].empty() ? "no name" : Printable(names[i]));
    if (const auto first = std::find(names.begin(), names.end(), names[i]) - names.begin();
        first < static_cast<std::ptrdiff_t>(i))
      return absl::InvalidArgumentError(
          absl::StrCat(place, ": the same name as column ", first + 1, ", expected once"));
    ASSIGN_OR_RETURN(ColumnRule rule, RuleOf(names[i], place));
    if (rule.IsAxis()) column_of_axis_[machine::FindAxis(machine_, rule.axis)] = static_cast<int>(i);
    if (rule.kind == ColumnKind::kTime) time_ = static_cast<int>(i);
    if (rule.name == "temp_C") temperature_ = static_cast<int>(i);
    if (rule.kind == ColumnKind::kTemperature) {
      channels_.push_back(names[i]);
      column_of_channel_.push_back(i);
    }
    rules_.push_back(std::move(rule));
    columns_.push_back({names[i], {}, {}});
  }
  RETURN_IF_ERROR(RequireAxes(line.number));
  rows_ = std::make_unique<RowParser>(rules_, columns_);
  return absl::OkStatus();
}

absl::Status PoseReader::ReadRows(PoseBlock* block) {
  for (Column& column : columns_) column.values.clear();
  Line line;
  size_t count = 0;
  for (; count < kBlockRows; ++count) {
    ASSIGN_OR_RETURN(const bool more, lines_->Next(&line));
    if (!more) break;
    RETURN_IF_ERROR(CheckLineEnd(line));
    RETURN_IF_ERROR(rows_->Add(line));
  }
  rows_read_ += count;
  if (rows_read_ == 0) return absl::InvalidArgumentError("no poses follow the column names, expected at least one");
  block->count = count;
  const size_t axes = column_of_axis_.size();
  block->positions.resize(count * axes);
  for (size_t i = 0; i < axes; ++i) {
    const std::vector<double>& values = columns_[column_of_axis_[i]].values;
    const double unit = machine_.axes[i].kind == AxisKind::kRotary ? base::kRadPerDeg : 1.0;
    for (size_t k = 0; k < count; ++k) block->positions[k * axes + i] = values[k] * unit;
  }
  block->time_s.clear();
  block->temperature_celsius.clear();
  if (has_time()) block->time_s = columns_[time_].values;
  if (has_temperature()) block->temperature_celsius = columns_[temperature_].values;
  block->celsius.resize(channels_.size());
  for (size_t i = 0; i < channels_.size(); ++i) block->celsius[i] = columns_[column_of_channel_[i]].values;
  return absl::OkStatus();
}

absl::Status PoseReader::Next(PoseBlock* block) { return base::Within(path_, ReadRows(block)); }

double PoseReader::fraction() const { return std::min(1.0, static_cast<double>(lines_->bytes_read()) / bytes_); }

}  // namespace axiscal::session
