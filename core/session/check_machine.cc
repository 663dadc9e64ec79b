#include "core/session/check_machine.h"

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

absl::Status Refuse(const std::string& what) { return absl::InvalidArgumentError(what); }

std::string ColumnName(const Axis& axis) { return axis.name + (axis.kind == AxisKind::kLinear ? "_mm" : "_deg"); }

absl::Status CheckMachineName(const Session& session, const machine::Machine& machine) {
  for (size_t i = 0; i < session.header.size(); ++i) {
    const HeaderEntry& entry = session.header[i];
    if (entry.key != "machine" || entry.value == machine.id) continue;
    return Refuse(
        absl::StrCat("line ", HeaderLine(i), ": machine: ", Quoted(entry.value), ", expected '", machine.id, "'"));
  }
  return absl::OkStatus();
}

absl::Status CheckTravel(const Column& column, const Axis& axis, const Session& session, size_t index) {
  if (!axis.min_position || !axis.max_position) return absl::OkStatus();
  const bool linear = axis.kind == AxisKind::kLinear;
  const double unit = linear ? 1.0 : base::kRadPerDeg, tolerance = linear ? kTravelToleranceMm : kTravelToleranceRad;
  for (size_t row = 0; row < column.values.size(); ++row) {
    const double position = column.values[row] * unit;
    if (position >= *axis.min_position - tolerance && position <= *axis.max_position + tolerance) continue;
    return Refuse(absl::StrFormat("%s: %g is beyond the travel of %s, expected %g to %g",
                                  Place(ReadingLine(session.header.size(), row), index, column.name),
                                  column.values[row], axis.name, *axis.min_position / unit, *axis.max_position / unit));
  }
  return absl::OkStatus();
}

absl::Status CheckAxisColumn(const Session& session, const machine::Machine& machine, const ColumnRule& rule,
                             size_t index) {
  const std::string place = Place(HeaderLine(session.header.size()), index, rule.name);
  const int found = machine::FindAxis(machine, rule.axis);
  if (found < 0) return Refuse(absl::StrCat(place, ": machine ", machine.id, " has no axis ", rule.axis));
  const Axis& axis = machine.axes[found];
  if ((axis.kind == AxisKind::kLinear) != (rule.kind == ColumnKind::kLinearAxis)) {
    return Refuse(absl::StrCat(place, ": ", axis.name, " is ", axis.kind == AxisKind::kLinear ? "linear" : "rotary",
                               ", expected ", ColumnName(axis)));
  }
  return CheckTravel(session.columns[index], axis, session, index);
}

}  // namespace

absl::Status CheckAgainstMachine(const Session& session, const machine::Machine& machine) {
  RETURN_IF_ERROR(CheckMachineName(session, machine));
  std::vector<std::string> names;
  for (const Column& column : session.columns) names.push_back(column.name);
  ASSIGN_OR_RETURN(const std::vector<ColumnRule> rules, ColumnRules(session.header, names));
  for (size_t i = 0; i < rules.size(); ++i) {
    if (!rules[i].axis.empty()) RETURN_IF_ERROR(CheckAxisColumn(session, machine, rules[i], i));
  }
  const InstrumentFormat* format = FindInstrumentFormat(*FindHeader(session, "instrument"));
  DEMAND(format != nullptr);  // the session is valid
  for (const Axis& axis : machine.axes) {
    const bool needed = format->axes == AxisColumns::kAll ||
                        (format->axes == AxisColumns::kRotaryOnly && axis.kind == AxisKind::kRotary);
    if (needed && FindColumn(session, ColumnName(axis)) == nullptr) {
      return Refuse(absl::StrCat("line ", HeaderLine(session.header.size()), ": axis ", axis.name, " of machine ",
                                 machine.id, " has no column, instrument ", format->name, " needs ", ColumnName(axis)));
    }
  }
  return absl::OkStatus();
}

}  // namespace axiscal::session
