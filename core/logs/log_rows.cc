#include "core/logs/log_rows.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/session/column_rules.h"
#include "core/session/text.h"

namespace axiscal::logs {

using session::Column;

std::string ColumnName(const machine::Axis& axis) {
  return axis.name + (axis.kind == machine::AxisKind::kLinear ? "_mm" : "_deg");
}

bool IsAxisName(const std::string& column) {
  std::string axis;
  session::ColumnKind kind;
  return session::ParseAxisColumn(column, &axis, &kind);
}

namespace {
// Whether a rule `axis: NAME ...` speaks of the column.
bool IsScaledBy(const std::string& name, const std::string& column) {
  return column == name || column == name + "_mm" || column == name + "_deg";
}
}  // namespace

bool IsFeature(const std::string& column) { return column == "feature" || column == "rod"; }

absl::Status LogRows::Read(std::istream& in, const session::InstrumentFormat& format) {
  format_ = &format;
  RETURN_IF_ERROR(MakePattern());
  RETURN_IF_ERROR(CheckFields());
  RETURN_IF_ERROR(CheckReadings());
  if (AreTouchesOfCentres() && options_.machine == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat(template_.name, ": line: '", pattern_.text,
                     "' has no fields {cx_mm} {cy_mm} {cz_mm}: centres are computed from touches with the "
                     "machine's axes, expected the fields or --machine"));
  }
  ASSIGN_OR_RETURN(log_, ReadLog(in, log_name_, template_, pattern_, options_.cancelled));
  return absl::OkStatus();
}

std::string LogRows::LineOf(size_t reading) const {
  return absl::StrCat(log_name_, ": line ", log_.readings[reading].line);
}

std::vector<std::string> LogRows::KnownAxes() const {
  std::vector<std::string> names;
  if (options_.machine != nullptr) {
    for (const machine::Axis& axis : options_.machine->axes) names.push_back(ColumnName(axis));
  } else if (options_.plan != nullptr) {
    for (const Column& column : options_.plan->columns) {
      if (IsAxis(column.name)) names.push_back(column.name);
    }
    // What is read may be where an axis stood: Z_mm of a tool setter.
    for (const session::ReadingColumn& column : format_->columns) {
      if (IsAxisName(column.name)) names.push_back(column.name);
    }
  }
  return names;
}

bool LogRows::IsAxis(const std::string& column) const {
  return IsAxisName(column) &&
         std::none_of(format_->columns.begin(), format_->columns.end(),
                      [&](const session::ReadingColumn& reading) { return reading.name == column; });
}

absl::Status LogRows::MakePattern() {
  if (template_.line) {
    pattern_ = *template_.line;
    return absl::OkStatus();
  }
  std::string text;
  if (template_.format == KnownFormat::kLinuxCncProbe) {
    text = "{X_mm} {Y_mm} {Z_mm} {A_deg} {B_deg} {C_deg} {U_mm} {V_mm} {W_mm}";
  } else {
    for (const std::string& name : KnownAxes())
      absl::StrAppend(&text, text.empty() ? "" : " ", name.substr(0, name.find('_')), "{", name, "}");
  }
  if (KnownAxes().empty()) {
    return absl::InvalidArgumentError(
        template_.name +
        ": which axes the log holds follows from the machine or the plan, expected one of them or 'line:'");
  }
  ASSIGN_OR_RETURN(pattern_, ParsePattern(text));
  pattern_.decimal = template_.decimal;
  return absl::OkStatus();
}

int LogRows::FieldIndex(const std::string& name) const {
  for (size_t i = 0; i < pattern_.pieces.size(); ++i) {
    if (pattern_.pieces[i].field == name) return static_cast<int>(i);
  }
  return -1;
}

bool LogRows::IsColumn(const std::string& field) const {
  if (field == "t_s") return format_->has_time;
  if (session::StateColumnRule(field)) return true;  // positions, encoders, senses, temperatures
  return std::any_of(format_->columns.begin(), format_->columns.end(),
                     [&](const session::ReadingColumn& column) { return column.name == field; });
}

absl::Status LogRows::CheckFields() const {
  for (const Piece& piece : pattern_.pieces) {
    if (piece.field.empty() || piece.field == "*" || IsColumn(piece.field)) continue;
    return absl::InvalidArgumentError(absl::StrCat(template_.name, ": line: {", piece.field,
                                                   "} is no column of instrument ", format_->name,
                                                   ", expected such as X_mm, B_deg, t_s, temp_C",
                                                   format_->columns.empty() ? "" : ", " + format_->columns[0].name));
  }
  for (const auto& [name, scale] : template_.scales) {
    int fields = 0;
    for (const Piece& piece : pattern_.pieces) {
      if (!IsScaledBy(name, piece.field)) continue;
      ++fields;
      if (piece.is_text)
        return absl::InvalidArgumentError(
            absl::StrCat(template_.name, ": axis: ", name, " is scaled, but {", piece.field, "} is no number"));
      if (piece.field != name && template_.scales.count(piece.field) > 0)
        return absl::InvalidArgumentError(
            absl::StrCat(template_.name, ": axis: {", piece.field, "} is scaled twice, as ", name, " too"));
    }
    if (fields == 0)
      return absl::InvalidArgumentError(absl::StrCat(template_.name, ": axis: ", name,
                                                     " is scaled, but the line has no field {", name, "}, {", name,
                                                     "_mm} or {", name, "_deg}"));
  }
  return absl::OkStatus();
}

// What an instrument reads is in the line. What it may leave empty is empty, if the line holds any other of that kind.
absl::Status LogRows::CheckReadings() const {
  if (AreTouchesOfCentres()) return absl::OkStatus();
  const bool is_read = std::any_of(format_->columns.begin(), format_->columns.end(), [&](const auto& column) {
    return column.may_be_empty && FieldIndex(column.name) >= 0;
  });
  for (const session::ReadingColumn& column : format_->columns) {
    if (column.source == session::ColumnSource::kPlan || FieldIndex(column.name) >= 0) continue;
    if (column.may_be_empty && is_read) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        template_.name, ": line: '", pattern_.text, "' has no field {", column.name, "}, which instrument ",
        format_->name, " reads and only the log can hold, expected a template with 'line: ...{", column.name, "}'"));
  }
  return absl::OkStatus();
}

std::vector<double> LogRows::NumbersOf(int field) const {
  std::vector<double> numbers;
  for (const LogReading& reading : log_.readings) numbers.push_back(reading.fields[field].number);
  for (const auto& [name, scale] : template_.scales) {
    if (!IsScaledBy(name, pattern_.pieces[field].field)) continue;
    for (double& number : numbers) number = scale.scale * number + scale.offset;
  }
  return numbers;
}

const Column* LogRows::Planned(const std::string& column) const {
  return options_.plan != nullptr ? session::FindColumn(*options_.plan, column) : nullptr;
}

absl::Status LogRows::CheckForeignAxes(const std::vector<std::string>& names) const {
  // Instruments without axis columns pass over what else the control prints.
  if (format_->axes == session::AxisColumns::kNone && options_.machine == nullptr) return absl::OkStatus();
  for (const Piece& piece : pattern_.pieces) {
    if (!IsAxis(piece.field) || std::find(names.begin(), names.end(), piece.field) != names.end()) continue;
    const std::vector<double> numbers = NumbersOf(FieldIndex(piece.field));
    for (size_t k = 0; k < numbers.size(); ++k) {
      if (numbers[k] == 0.0 && template_.format == KnownFormat::kLinuxCncProbe) continue;
      return WrongAt({log_.readings[k].line, 0, piece.field},
                     absl::StrCat(LineOf(k), ": ", piece.field, " reads ", numbers[k], ", but ",
                                  options_.machine != nullptr ? "machine " + options_.machine->id : "the plan",
                                  " has no such axis"));
    }
  }
  return absl::OkStatus();
}

std::optional<std::string> LogRows::LoggedName(const std::string& column, size_t reading) const {
  const int field = FieldIndex(column);
  if (field >= 0) return log_.readings[reading].fields[field].text;
  if (IsFeature(column) && !log_.readings[reading].feature.empty()) return log_.readings[reading].feature;
  return std::nullopt;
}

bool LogRows::AreTouchesOfCentres() const {
  bool is_any = false;
  for (const session::ReadingColumn& column : format_->columns) {
    if (column.source != session::ColumnSource::kFromTouches) continue;
    if (FieldIndex(column.name) >= 0) return false;
    is_any = true;
  }
  return is_any;
}

// Unstated without a machine.
machine::RollOver LogRows::RollOverOf(const std::string& column) const {
  if (options_.machine == nullptr) return machine::RollOver::kUnstated;
  const int axis = machine::FindAxis(*options_.machine, column.substr(0, column.find('_')));
  return axis < 0 ? machine::RollOver::kUnstated : options_.machine->axes[axis].roll_over;
}

// `number`, or the number of the same position nearest to `place` where the axis rolls over.
double LogRows::AtTurnOf(double place, const std::string& column, double number) const {
  constexpr double kTurnDeg = 360.0;
  const machine::RollOver roll_over = RollOverOf(column);
  if (roll_over == machine::RollOver::kUnstated || roll_over == machine::RollOver::kNone) return number;
  return number - kTurnDeg * std::round((number - place) / kTurnDeg);
}

void LogRows::CountOn(const std::string& column, std::vector<double>* positions_deg,
                      std::vector<std::string>* notes) const {
  if (options_.plan != nullptr || column.ends_with("_mm") || positions_deg->empty()) return;
  constexpr double kTurnDeg = 360.0, kHalfTurnDeg = 180.0;
  const bool is_never_across_zero = RollOverOf(column) == machine::RollOver::kByDifference;
  double before = positions_deg->front(), turns_deg = 0.0;
  size_t others = 0, first = 0;
  for (size_t k = 0; k < positions_deg->size(); ++k) {
    double& position = (*positions_deg)[k];
    const double logged = position, here = logged + turns_deg, step = std::abs(here - before);
    position = here;
    // Half a turn has no nearer way: the numbers say which.
    if (is_never_across_zero ? std::abs(step - kTurnDeg) <= kMaxOffPlanDeg : step > kHalfTurnDeg + kMaxOffPlanDeg)
      position = AtTurnOf(before, column, here);
    // One that never crosses 0 stays on its turn: what is a turn off is the display at 0.
    if (!is_never_across_zero) turns_deg = position - logged;
    before = position;
    if (position != logged && others++ == 0) first = k;
  }
  if (others == 0) return;
  notes->push_back(absl::StrCat(column, ": the axis rolls over, and ", others,
                                " of its positions are given on the turn nearest to the one before, from ",
                                LineOf(first), " on"));
}

absl::Status LogRows::OffPlan(size_t reading, const std::string& column, double number, size_t plan_line,
                              double planned) const {
  const bool is_linear = column.ends_with("_mm");
  const double limit = is_linear ? kMaxOffPlanMm : kMaxOffPlanDeg;
  const bool is_a_turn = !is_linear && RollOverOf(column) == machine::RollOver::kUnstated &&
                         std::abs(std::remainder(number - planned, 360.0)) <= limit;
  return WrongAt(
      {log_.readings[reading].line, 0, column},
      absl::StrFormat(
          "%s: %s = %g, but line %d of the plan is at %g, expected within %g: %s", LineOf(reading), column, number,
          plan_line, planned, limit,
          is_a_turn
              ? "whole turns apart; does the axis count from 0 to 360 deg? Then its roll_over in machine.json says so"
              : "was a touch missed, or another program run?"));
}

// Where a name of the log stands in the plan too, they agree.
absl::Status LogRows::CheckPlannedNames(bool* is_any) const {
  for (const session::ReadingColumn& column : format_->columns) {
    const Column* const plan = Planned(column.name);
    if (!column.is_name || plan == nullptr) continue;
    for (size_t k = 0; k < log_.readings.size(); ++k) {
      const std::optional<std::string> name = LoggedName(column.name, k);
      if (!name) continue;
      *is_any |= IsFeature(column.name);  // a run has several senses
      if (*name == plan->texts[k]) continue;
      return WrongAt({log_.readings[k].line, 0, column.name},
                     absl::StrCat(LineOf(k), ": ", column.name, " ", session::Quoted(*name), ", but line ", k + 1,
                                  " of the plan is of ", session::Quoted(plan->texts[k]),
                                  ": was a reading missed, or another program run?"));
    }
  }
  return absl::OkStatus();
}

absl::Status LogRows::CheckPlan(const std::vector<std::string>& from_plan, std::vector<Column>* axes,
                                std::vector<std::string>* notes) const {
  if (options_.plan == nullptr) return absl::OkStatus();
  const size_t planned = options_.plan->reading_count(), found = log_.readings.size();
  if (found > planned) {
    return WrongAt({log_.readings[planned].line}, absl::StrCat(LineOf(planned), ": reading ", planned + 1,
                                                               ", but the plan has ", planned, ", expected no more"));
  }
  for (Column& column : *axes) {
    const Column* const plan = Planned(column.name);
    if (plan == nullptr) return absl::InvalidArgumentError(absl::StrCat("the plan has no column ", column.name));
    column.values.resize(found);  // those of the plan itself
    const double limit = column.name.ends_with("_mm") ? kMaxOffPlanMm : kMaxOffPlanDeg;
    for (size_t k = 0; k < found; ++k) {
      const double logged = column.values[k];
      column.values[k] = AtTurnOf(plan->values[k], column.name, logged);
      if (std::abs(column.values[k] - plan->values[k]) > limit)
        return OffPlan(k, column.name, logged, k + 1, plan->values[k]);
    }
  }
  bool is_named = false;
  RETURN_IF_ERROR(CheckPlannedNames(&is_named));
  const bool is_tied = from_plan.empty() && (is_named || !axes->empty());
  if (found < planned && !is_tied) {
    return absl::InvalidArgumentError(
        absl::StrCat(log_name_, ": the plan has ", planned, " readings, the log ", found,
                     ": no position and no name in the log says which are missing, expected all of them"));
  }
  if (found < planned)
    notes->push_back(absl::StrCat("the plan has ", planned, " readings, the log ", found, ": the rest is missing"));
  return absl::OkStatus();
}

absl::StatusOr<std::vector<TouchedPose>> LogRows::Poses(std::vector<std::vector<double>>* axes) const {
  const machine::Machine& machine = *options_.machine;
  std::vector<TouchedPose> poses;
  // The first rotary axis (its number in the machine) that stands elsewhere than `there` says, or -1.
  const auto turned = [&](size_t k, const auto& there) {
    for (int i = 0; i < machine.axis_count(); ++i) {
      if (machine.axes[i].kind != machine::AxisKind::kRotary) continue;
      if (std::abs(AtTurnOf(there(i), ColumnName(machine.axes[i]), (*axes)[i][k]) - there(i)) > kMaxOffPlanDeg)
        return i;
    }
    return -1;
  };
  size_t first = 0;  // touch of the pose
  for (size_t k = 0; k < log_.readings.size(); ++k) {
    const auto of_first = [&](int i) { return (*axes)[i][first]; };
    const bool is_new = poses.empty() || turned(k, of_first) >= 0;
    if (is_new) {
      poses.emplace_back();
      first = k;
    }
    const size_t row = poses.size() - 1;
    const auto planned = [&](int i) { return Planned(ColumnName(machine.axes[i]))->values[row]; };
    if (is_new && options_.plan != nullptr) {
      if (row >= options_.plan->reading_count()) {
        return WrongAt({log_.readings[k].line},
                       absl::StrCat(LineOf(k), ": pose ", row + 1, ", but the plan has ", row, ", expected no more"));
      }
      const int axis = turned(k, planned);
      if (axis >= 0) return OffPlan(k, ColumnName(machine.axes[axis]), (*axes)[axis][k], row + 1, planned(axis));
    }
    LatchedTouch touch = {{}, log_.readings[k].line};
    for (int i = 0; i < machine.axis_count(); ++i) {
      const bool is_rotary = machine.axes[i].kind == machine::AxisKind::kRotary;
      double& position = (*axes)[i][k];
      if (is_rotary) {
        position = AtTurnOf(options_.plan != nullptr ? planned(i) : of_first(i), ColumnName(machine.axes[i]), position);
      }
      touch.positions.push_back(position * (is_rotary ? base::kRadPerDeg : 1.0));
    }
    poses.back().touches.push_back(std::move(touch));
  }
  return poses;
}

}  // namespace axiscal::logs
