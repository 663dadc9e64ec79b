#include "core/session/check_machine.h"

#include <algorithm>

#include "core/base/demand.h"
#include "core/base/units.h"
#include "core/session/column_rules.h"
#include "core/session/text.h"

namespace axiscal::session {
namespace {

using machine::Axis;
using machine::AxisKind;

// A latched position may stand beyond the limit by the last digit that is shown.
constexpr double kTravelToleranceMm = 1e-3;
constexpr double kTravelToleranceRad = 1e-3 * base::kRadPerDeg;

std::string ColumnName(const Axis& axis) { return axis.name + (axis.kind == AxisKind::kLinear ? "_mm" : "_deg"); }

absl::Status CheckMachineName(const std::vector<HeaderEntry>& header, const machine::Machine& machine) {
  for (size_t i = 0; i < header.size(); ++i) {
    const HeaderEntry& entry = header[i];
    if (entry.key != "machine" || entry.value == machine.id) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("line ", HeaderLine(i), ": machine: ", Quoted(entry.value), ", expected '", machine.id, "'"));
  }
  return absl::OkStatus();
}

// `# datum: free X Z` names linear axes of this machine.
absl::Status CheckDatum(const std::vector<HeaderEntry>& header, const machine::Machine& machine) {
  for (size_t i = 0; i < header.size(); ++i) {
    if (header[i].key != "datum") continue;
    ASSIGN_OR_RETURN(const std::vector<std::string> axes, ParseDatum(header[i].value));
    for (const std::string& name : axes) {
      const int axis = machine::FindAxis(machine, name);
      if (axis >= 0 && machine.axes[axis].kind == AxisKind::kLinear) continue;
      return absl::InvalidArgumentError(absl::StrCat(
          "line ", HeaderLine(i), ": datum: ", Quoted(header[i].value), ": ", name,
          axis < 0 ? absl::StrCat(" is no axis of machine ", machine.id) : std::string(" is a rotary axis"),
          ", expected linear axes"));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckTravel(const Column& column, const Axis& axis, size_t header_entries, size_t index,
                         const std::vector<size_t>* log_lines) {
  if (!axis.min_position || !axis.max_position) return absl::OkStatus();
  const bool linear = axis.kind == AxisKind::kLinear;
  const double unit = linear ? 1.0 : base::kRadPerDeg, tolerance = linear ? kTravelToleranceMm : kTravelToleranceRad;
  const double lowest = *axis.min_position - tolerance, highest = *axis.max_position + tolerance;
  // Nearly always all are within: a loop without a way out is several times faster.
  bool all_within = true;
  for (const double shown : column.values) all_within &= (shown * unit >= lowest) & (shown * unit <= highest);
  for (size_t row = 0; !all_within && row < column.values.size(); ++row) {
    const double position = column.values[row] * unit;
    if (position >= lowest && position <= highest) continue;
    const size_t line = ReadingLine(header_entries, row, log_lines);
    // A log's columns are not the session's.
    const std::string place =
        log_lines != nullptr ? absl::StrCat("line ", line, " (", column.name, ")") : Place(line, index, column.name);
    return absl::InvalidArgumentError(absl::StrFormat("%s: %g is beyond the travel of %s, expected %g to %g", place,
                                                      column.values[row], axis.name, *axis.min_position / unit,
                                                      *axis.max_position / unit));
  }
  return absl::OkStatus();
}

// The axis of the column, or why it has none.
absl::StatusOr<Axis> AxisOf(const ColumnRule& rule, const machine::Machine& machine, size_t header_entries,
                            size_t index) {
  const std::string place = Place(HeaderLine(header_entries), index, rule.name);
  const int found = machine::FindAxis(machine, rule.axis);
  if (found < 0)
    return absl::InvalidArgumentError(absl::StrCat(place, ": machine ", machine.id, " has no axis ", rule.axis));
  const Axis& axis = machine.axes[found];
  if (!rule.IsSense() && (axis.kind == AxisKind::kLinear) != rule.IsLinear()) {
    std::string expected = ColumnName(axis);
    if (rule.IsEncoder()) expected.insert(axis.name.size(), "_enc");
    return absl::InvalidArgumentError(absl::StrCat(
        place, ": ", axis.name, " is ", axis.kind == AxisKind::kLinear ? "linear" : "rotary", ", expected ", expected));
  }
  return axis;
}

absl::Status CheckAxesAreThere(const std::vector<HeaderEntry>& header, const std::vector<std::string>& columns,
                               const machine::Machine& machine) {
  const InstrumentFormat* format = FindInstrumentFormat(*FindHeader({header, {}}, "instrument"));
  DEMAND(format != nullptr);  // the header is valid
  for (const Axis& axis : machine.axes) {
    const bool needed = format->axes == AxisColumns::kAll ||
                        (format->axes == AxisColumns::kRotaryOnly && axis.kind == AxisKind::kRotary);
    if (needed && std::find(columns.begin(), columns.end(), ColumnName(axis)) == columns.end()) {
      return absl::InvalidArgumentError(absl::StrCat("line ", HeaderLine(header.size()), ": axis ", axis.name,
                                                     " of machine ", machine.id, " has no column, instrument ",
                                                     format->name, " needs ", ColumnName(axis)));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<MachineCheck> MachineCheck::Create(const std::vector<HeaderEntry>& header,
                                                  const std::vector<std::string>& columns,
                                                  const machine::Machine& machine) {
  ASSIGN_OR_RETURN(const std::vector<ColumnRule> rules, ColumnRules(header, columns));
  MachineCheck check;
  check.header_entries_ = header.size();
  check.wrong_machine_ = CheckMachineName(header, machine);
  for (size_t i = 0; i < rules.size(); ++i) {
    if (rules[i].axis.empty()) continue;
    check.axis_columns_.push_back({i, AxisOf(rules[i], machine, header.size(), i), rules[i].IsAxis()});
  }
  RETURN_IF_ERROR(CheckDatum(header, machine));
  check.missing_axis_ = CheckAxesAreThere(header, columns, machine);
  return check;
}

absl::Status MachineCheck::Check(const std::vector<Column>& columns, const std::vector<size_t>* log_lines) const {
  RETURN_IF_ERROR(wrong_machine_);
  for (const AxisColumn& column : axis_columns_) {
    RETURN_IF_ERROR(column.axis.status());
    if (!column.is_position) continue;  // an encoder may stand beyond the limit of the command
    RETURN_IF_ERROR(CheckTravel(columns[column.index], *column.axis, header_entries_, column.index, log_lines));
  }
  return missing_axis_;
}

absl::Status CheckAgainstMachine(const Session& session, const machine::Machine& machine) {
  RETURN_IF_ERROR(CheckMachineName(session.header, machine));
  std::vector<std::string> names;
  for (const Column& column : session.columns) names.push_back(column.name);
  ASSIGN_OR_RETURN(const MachineCheck check, MachineCheck::Create(session.header, names, machine));
  return check.Check(session.columns);
}

}  // namespace axiscal::session
