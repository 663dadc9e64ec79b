#include "core/logs/reduce.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/units.h"
#include "core/instruments/plausible.h"
#include "core/instruments/touch/touch_bind.h"
#include "core/instruments/touch/touch_model.h"
#include "core/logs/sphere_centres.h"
#include "core/session/check_machine.h"
#include "core/session/column_rules.h"
#include "core/session/header_rules.h"
#include "core/session/text.h"
#include "core/session/validate.h"

namespace axiscal::logs {
namespace {

using session::Column;
using session::Session;

// Header keys that a log leaves in its session.
constexpr char kCutLine[] = "cut_line", kCentreSigma[] = "centre_sigma_um";

std::string ColumnName(const machine::Axis& axis) {
  return axis.name + (axis.kind == machine::AxisKind::kLinear ? "_mm" : "_deg");
}

bool IsAxisName(const std::string& column) {
  std::string axis;
  session::ColumnKind kind;
  return session::ParseAxisColumn(column, &axis, &kind);
}

class Reducer {
 public:
  Reducer(const std::string& log_name, const LogTemplate& log_template, const ReduceOptions& options)
      : log_name_(log_name), template_(log_template), options_(options) {}

  absl::StatusOr<Reduced> Run(std::istream& in) {
    RETURN_IF_ERROR(MakeHeader());
    RETURN_IF_ERROR(MakePattern());
    RETURN_IF_ERROR(CheckFields());
    RETURN_IF_ERROR(CheckReadings());
    if (AreTouchesOfCentres() && options_.machine == nullptr) {
      return absl::InvalidArgumentError(
          absl::StrCat(template_.name, ": line: '", pattern_.text,
                       "' has no fields {cx_mm} {cy_mm} {cz_mm}: centres are computed from touches with the "
                       "machine's axes, expected the fields or --machine"));
    }
    ASSIGN_OR_RETURN(log_, ReadLog(in, log_name_, template_, pattern_));
    for (const LogReading& reading : log_.readings) out_.lines.push_back(reading.line);
    if (AreTouchesOfCentres()) {
      RETURN_IF_ERROR(FillCentres());
    } else {
      RETURN_IF_ERROR(FillAxes());
      RETURN_IF_ERROR(CheckPlan());
      FillTimes();
      if (format_->name == "touch") RETURN_IF_ERROR(FillTouches());
      RETURN_IF_ERROR(FillMissing());
      FillRest();
    }
    RETURN_IF_ERROR(CheckValues());
    Report();
    RETURN_IF_ERROR(base::Within(template_.name, session::Validate(out_.session)));
    if (options_.machine != nullptr) {
      RETURN_IF_ERROR(base::Within(log_name_, session::CheckAgainstMachine(out_.session, *options_.machine)));
      RETURN_IF_ERROR(base::Within(log_name_, instruments::CheckPlausible(out_.session, *options_.machine)));
    }
    return std::move(out_);
  }

 private:
  absl::Status MakeHeader() {
    std::vector<session::HeaderEntry>& header = out_.session.header;
    header = template_.header;
    if (options_.plan != nullptr) {
      if (!header.empty())
        return absl::InvalidArgumentError(template_.name +
                                          ": header lines beside a plan, which brings them: expected rules alone");
      header = options_.plan->header;
      // Of a measured session that is measured again: what its own log said.
      std::erase_if(
          header, [](const session::HeaderEntry& entry) { return entry.key == kCutLine || entry.key == kCentreSigma; });
    }
    if (header.empty()) {
      return absl::InvalidArgumentError(
          template_.name +
          ": no header lines '# key: value' of the session, expected them in the template or in a plan");
    }
    for (session::HeaderEntry& entry : header) {
      if (entry.key == "session" && !options_.session.empty()) entry.value = options_.session;
    }
    RETURN_IF_ERROR(base::Within(template_.name, session::ValidateHeader(header)));
    const std::string machine = *session::FindHeader(out_.session, "machine");
    if (options_.machine != nullptr && machine != options_.machine->id) {
      return absl::InvalidArgumentError(absl::StrCat(options_.plan != nullptr ? "the plan" : template_.name,
                                                     ": machine: ", session::Quoted(machine), ", expected '",
                                                     options_.machine->id, "'"));
    }
    format_ = session::FindInstrumentFormat(*session::FindHeader(out_.session, "instrument"));
    return absl::OkStatus();
  }

  // Axis columns in the machine's order, else in the plan's, else in the line's.
  std::vector<std::string> KnownAxes() const {
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

  // An axis column of the session, which a reading of the same name is not.
  bool IsAxis(const std::string& column) const {
    return IsAxisName(column) &&
           std::none_of(format_->columns.begin(), format_->columns.end(),
                        [&](const session::ReadingColumn& reading) { return reading.name == column; });
  }

  absl::Status MakePattern() {
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
    return absl::OkStatus();
  }

  int FieldIndex(const std::string& name) const {
    for (size_t i = 0; i < pattern_.pieces.size(); ++i) {
      if (pattern_.pieces[i].field == name) return static_cast<int>(i);
    }
    return -1;
  }

  bool IsColumn(const std::string& field) const {
    if (field == "t_s") return format_->has_time;
    if (field == "temp_C" || IsAxisName(field)) return true;
    return std::any_of(format_->columns.begin(), format_->columns.end(),
                       [&](const session::ReadingColumn& column) { return column.name == field; });
  }

  absl::Status CheckFields() const {
    for (const Piece& piece : pattern_.pieces) {
      if (piece.field.empty() || piece.field == "*" || IsColumn(piece.field)) continue;
      return absl::InvalidArgumentError(absl::StrCat(template_.name, ": line: {", piece.field,
                                                     "} is no column of instrument ", format_->name,
                                                     ", expected such as X_mm, B_deg, t_s, temp_C",
                                                     format_->columns.empty() ? "" : ", " + format_->columns[0].name));
    }
    for (const auto& [axis, scale] : template_.scales) {
      if (FieldIndex(axis + "_mm") < 0 && FieldIndex(axis + "_deg") < 0)
        return absl::InvalidArgumentError(
            absl::StrCat(template_.name, ": axis ", axis, " is scaled, but its line has no such field"));
    }
    return absl::OkStatus();
  }

  // What an instrument reads is in the line. What it may leave empty is empty, if the line holds any other of that
  // kind.
  absl::Status CheckReadings() const {
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

  // As logged; an axis' by its scale and offset.
  std::vector<double> NumbersOf(int field) const {
    std::vector<double> numbers;
    for (const LogReading& reading : log_.readings) numbers.push_back(reading.fields[field].number);
    const std::string& name = pattern_.pieces[field].field;
    const auto scale = template_.scales.find(name.substr(0, name.find('_')));
    if (!IsAxisName(name) || scale == template_.scales.end()) return numbers;
    for (double& number : numbers) number = scale->second.scale * number + scale->second.offset;
    return numbers;
  }

  std::string LineOf(size_t reading) const { return absl::StrCat(log_name_, ": line ", out_.lines[reading]); }

  const Column* Planned(const std::string& column) const {
    return options_.plan != nullptr ? session::FindColumn(*options_.plan, column) : nullptr;
  }

  // LinuxCNC prints nine axes, whatever the machine has: those it has not read 0.
  absl::Status CheckForeignAxes(const std::vector<std::string>& names) const {
    // Instruments without axis columns pass over what else the control prints.
    if (format_->axes == session::AxisColumns::kNone && options_.machine == nullptr) return absl::OkStatus();
    for (const Piece& piece : pattern_.pieces) {
      if (!IsAxis(piece.field) || std::find(names.begin(), names.end(), piece.field) != names.end()) continue;
      const std::vector<double> numbers = NumbersOf(FieldIndex(piece.field));
      for (size_t k = 0; k < numbers.size(); ++k) {
        if (numbers[k] == 0.0 && template_.format == KnownFormat::kLinuxCncProbe) continue;
        return absl::InvalidArgumentError(absl::StrCat(
            LineOf(k), ": ", piece.field, " reads ", numbers[k], ", but ",
            options_.machine != nullptr ? "machine " + options_.machine->id : "the plan", " has no such axis"));
      }
    }
    return absl::OkStatus();
  }

  absl::Status NoField(const std::string& name) const {
    return absl::InvalidArgumentError(absl::StrCat(
        template_.name, ": line: '", pattern_.text, "' has no field {", name, "}, instrument ", format_->name,
        " needs it", format_->name == "touch" ? "" : ", expected the field or a plan that holds it"));
  }

  absl::Status FillAxes() {
    std::vector<std::string> names = KnownAxes();
    if (names.empty()) {
      for (const Piece& piece : pattern_.pieces) {
        if (IsAxis(piece.field)) names.push_back(piece.field);
      }
    }
    RETURN_IF_ERROR(CheckForeignAxes(names));
    for (const std::string& name : names) {
      const bool is_linear = name.ends_with("_mm");
      if ((format_->axes == session::AxisColumns::kRotaryOnly && is_linear) ||
          format_->axes == session::AxisColumns::kNone)
        continue;
      const int field = FieldIndex(name);
      if (field >= 0) {
        axes_.push_back({name, NumbersOf(field), {}});
        continue;
      }
      // A touch is where the axes were latched; all else is measured at commanded positions, which the plan holds.
      const Column* const plan = Planned(name);
      if (plan == nullptr || format_->name == "touch") return NoField(name);
      axes_.push_back(*plan);
      from_plan_.push_back(name);
    }
    return absl::OkStatus();
  }

  absl::Status OffPlan(const std::string& line, const std::string& column, double number, size_t plan_line,
                       double planned, double limit) const {
    return absl::InvalidArgumentError(absl::StrFormat(
        "%s: %s = %g, but line %d of the plan is at %g, expected within %g: was a touch missed, or another program "
        "run?",
        line, column, number, plan_line, planned, limit));
  }

  // Where a name of the log stands in the plan too, they agree.
  absl::Status CheckPlannedNames(bool* is_any) const {
    for (const session::ReadingColumn& column : format_->columns) {
      const Column* const plan = Planned(column.name);
      if (!column.is_name || plan == nullptr) continue;
      for (size_t k = 0; k < log_.readings.size(); ++k) {
        const std::optional<std::string> name = LoggedName(column.name, k);
        if (!name) continue;
        *is_any |= IsFeature(column.name);  // a run has several senses
        if (*name == plan->texts[k]) continue;
        return absl::InvalidArgumentError(absl::StrCat(
            LineOf(k), ": ", column.name, " ", session::Quoted(*name), ", but line ", k + 1, " of the plan is of ",
            session::Quoted(plan->texts[k]), ": was a reading missed, or another program run?"));
      }
    }
    return absl::OkStatus();
  }

  absl::Status CheckPlan() {
    if (options_.plan == nullptr) return absl::OkStatus();
    const size_t planned = options_.plan->reading_count(), found = log_.readings.size();
    if (found > planned) {
      return absl::InvalidArgumentError(absl::StrCat(LineOf(planned), ": reading ", planned + 1, ", but the plan has ",
                                                     planned, ", expected no more"));
    }
    for (Column& column : axes_) {
      const Column* const plan = Planned(column.name);
      if (plan == nullptr) return absl::InvalidArgumentError(absl::StrCat("the plan has no column ", column.name));
      column.values.resize(found);  // those of the plan itself
      const double limit = column.name.ends_with("_mm") ? kMaxOffPlanMm : kMaxOffPlanDeg;
      for (size_t k = 0; k < found; ++k) {
        if (std::abs(column.values[k] - plan->values[k]) > limit)
          return OffPlan(LineOf(k), column.name, column.values[k], k + 1, plan->values[k], limit);
      }
    }
    bool is_named = false;
    RETURN_IF_ERROR(CheckPlannedNames(&is_named));
    const bool is_tied = from_plan_.empty() && (is_named || !axes_.empty());
    if (found < planned && !is_tied) {
      return absl::InvalidArgumentError(
          absl::StrCat(log_name_, ": the plan has ", planned, " readings, the log ", found,
                       ": no position and no name in the log says which are missing, expected all of them"));
    }
    if (found < planned)
      out_.notes.push_back(
          absl::StrCat("the plan has ", planned, " readings, the log ", found, ": the rest is missing"));
    return absl::OkStatus();
  }

  void FillTimes() {
    std::vector<Column>& columns = out_.session.columns;
    const int field = FieldIndex("t_s");
    if (field >= 0) {
      columns.push_back({"t_s", NumbersOf(field), {}});
    } else if (format_->has_time) {
      const Column* const plan = Planned("t_s");
      const double start_s = options_.start_s.value_or(plan != nullptr ? plan->values[0] : 0.0);
      Column times = {"t_s", {}, {}};
      for (size_t k = 0; k < log_.readings.size(); ++k) {
        const double since_s =
            plan != nullptr ? plan->values[k] - plan->values[0] : static_cast<double>(k) * template_.seconds;
        times.values.push_back(start_s + since_s);
      }
      columns.push_back(std::move(times));
      out_.notes.push_back(
          plan != nullptr ? std::string("the log has no times: t_s is the plan's")
                          : absl::StrFormat("the log has no times: t_s counts %g s per reading", template_.seconds));
    }
    columns.insert(columns.end(), axes_.begin(), axes_.end());
  }

  // A mark and the rule `feature` name what was touched, or the rod that was measured.
  static bool IsFeature(const std::string& column) { return column == "feature" || column == "rod"; }

  // What the log itself says in a column of names.
  std::optional<std::string> LoggedName(const std::string& column, size_t k) const {
    const int field = FieldIndex(column);
    if (field >= 0) return log_.readings[k].fields[field].text;
    if (IsFeature(column) && !log_.readings[k].feature.empty()) return log_.readings[k].feature;
    return std::nullopt;
  }

  absl::StatusOr<std::string> FeatureOf(const std::string& column, size_t k) const {
    if (const std::optional<std::string> name = LoggedName(column, k)) return *name;
    if (const Column* const plan = Planned(column)) return plan->texts[k];
    if (!template_.feature.empty()) return template_.feature;
    std::vector<std::string> names;
    for (const session::HeaderEntry& entry : out_.session.header) {
      const session::FeatureRule* rule = session::FindFeatureRule(*format_, entry.key);
      if (rule != nullptr) names.push_back(entry.key.substr(rule->prefix.size() + 1));
    }
    if (names.size() == 1) return names[0];
    return absl::InvalidArgumentError(LineOf(k) + ": nothing says which " +
                                      (column == "feature" ? "feature was touched" : column + " was measured") +
                                      ", expected a field {" + column + "}, 'mark: ...', 'feature: ...' or a plan");
  }

  absl::Status FillTouches() {
    const size_t count = log_.readings.size();
    Column approach[3] = {{"nx", {}, {}}, {"ny", {}, {}}, {"nz", {}, {}}}, feature = {"feature", {}, {}};
    for (size_t k = 0; k < count; ++k) {
      ASSIGN_OR_RETURN(std::string name, FeatureOf("feature", k));
      feature.texts.push_back(std::move(name));
    }
    const int fields[3] = {FieldIndex("nx"), FieldIndex("ny"), FieldIndex("nz")};
    for (size_t k = 0; k < count; ++k) {
      Eigen::Vector3d n;
      if (fields[0] >= 0 && fields[1] >= 0 && fields[2] >= 0) {
        for (int i = 0; i < 3; ++i) n[i] = log_.readings[k].fields[fields[i]].number;
      } else if (options_.plan != nullptr) {
        for (int i = 0; i < 3; ++i) n[i] = Planned(approach[i].name)->values[k];
      } else if (template_.approach) {
        n = Eigen::Map<const Eigen::Vector3d>(template_.approach->data());
      } else {
        ASSIGN_OR_RETURN(n, TowardsFeature(k, feature.texts[k]));
      }
      for (int i = 0; i < 3; ++i) approach[i].values.push_back(n[i]);
    }
    for (Column& column : approach) out_.session.columns.push_back(std::move(column));
    out_.session.columns.push_back(std::move(feature));
    return absl::OkStatus();
  }

  absl::StatusOr<Eigen::Vector3d> TowardsFeature(size_t k, const std::string& name) const {
    if (!template_.approach_is_feature) {
      return absl::InvalidArgumentError(template_.name +
                                        ": nothing says from where the stylus came, expected fields {nx} {ny} {nz}, "
                                        "'approach: nx ny nz', 'approach: feature' or a plan");
    }
    if (options_.machine == nullptr)
      return absl::InvalidArgumentError(
          template_.name + ": 'approach: feature' needs the machine, whose axes say where the stylus stood");
    for (const session::HeaderEntry& entry : out_.session.header) {
      const session::FeatureRule* rule = session::FindFeatureRule(*format_, entry.key);
      if (rule == nullptr || entry.key.substr(rule->prefix.size() + 1) != name) continue;
      ASSIGN_OR_RETURN(const touch::Feature feature, touch::ParseFeature(entry.key, entry.value));
      std::vector<double> tip, positions;
      session::ParseNumbers(*session::FindHeader(out_.session, "tool_tip_mm"), &tip);
      for (const Column& column : axes_)
        positions.push_back(column.values[k] * (column.name.ends_with("_deg") ? base::kRadPerDeg : 1.0));
      return -touch::NormalAt(*options_.machine, feature, {tip[0], tip[1], tip[2]}, positions.data());
    }
    return absl::InvalidArgumentError(absl::StrCat(LineOf(k), ": feature ", session::Quoted(name),
                                                   " has no header line '# sphere ", name, ": ...' or '# plane ...'"));
  }

  // Columns of the instrument that the line does not hold.
  absl::Status FillMissing() {
    for (const session::ReadingColumn& column : format_->columns) {
      if (session::FindColumn(out_.session, column.name) != nullptr || FieldIndex(column.name) >= 0) continue;
      ASSIGN_OR_RETURN(Column filled, Missing(column));
      out_.session.columns.push_back(std::move(filled));
    }
    std::string columns;
    for (const std::string& name : from_plan_) absl::StrAppend(&columns, columns.empty() ? "" : ", ", name);
    if (!columns.empty()) out_.notes.push_back(columns + ": not in the log, the plan's");
    if (Planned("temp_C") != nullptr && FieldIndex("temp_C") < 0)
      out_.notes.push_back("temp_C: left out, the plan's is not what was measured, and the log has none");
    return absl::OkStatus();
  }

  absl::StatusOr<Column> Missing(const session::ReadingColumn& column) {
    const size_t count = log_.readings.size();
    Column filled = {column.name, {}, {}};
    if (column.source != session::ColumnSource::kPlan) {  // CheckReadings: it may be empty
      filled.values.assign(count, std::nan(""));
      return filled;
    }
    if (IsFeature(column.name)) {
      for (size_t k = 0; k < count; ++k) {
        ASSIGN_OR_RETURN(std::string name, FeatureOf(column.name, k));
        filled.texts.push_back(std::move(name));
      }
      return filled;
    }
    if (const Column* const plan = Planned(column.name)) {
      filled = *plan;
      filled.values.resize(std::min(count, plan->values.size()));
      filled.texts.resize(std::min(count, plan->texts.size()));
      return filled;
    }
    const Column* const rods = session::FindColumn(out_.session, "rod");
    if (column.name == "readout" && rods != nullptr) {
      std::map<std::string, int> readouts;
      for (const std::string& rod : rods->texts) filled.values.push_back(++readouts[rod]);
      out_.notes.push_back("readout: not in the log, counts the readings of each rod");
      return filled;
    }
    return absl::InvalidArgumentError(absl::StrCat(template_.name, ": line: '", pattern_.text, "' has no field {",
                                                   column.name, "}, instrument ", format_->name,
                                                   " needs it, expected the field or a plan"));
  }

  // The instrument's own columns and the temperature, as the line gives them.
  void FillRest() {
    for (size_t i = 0; i < pattern_.pieces.size(); ++i) {
      const Piece& piece = pattern_.pieces[i];
      if (piece.field.empty() || piece.field == "*" || IsAxis(piece.field) ||
          session::FindColumn(out_.session, piece.field) != nullptr)
        continue;
      Column column = {piece.field, {}, {}};
      if (piece.is_text) {
        for (const LogReading& reading : log_.readings) column.texts.push_back(reading.fields[i].text);
      } else {
        column.values = NumbersOf(static_cast<int>(i));
      }
      out_.session.columns.push_back(std::move(column));
    }
  }

  // A log of positions alone, in place of the centres that are computed from them.
  bool AreTouchesOfCentres() const {
    bool is_any = false;
    for (const session::ReadingColumn& column : format_->columns) {
      if (column.source != session::ColumnSource::kFromTouches) continue;
      if (FieldIndex(column.name) >= 0) return false;
      is_any = true;
    }
    return is_any;
  }

  // Touches in order, those at one rotary pose together; pose k is that of the plan's line k.
  absl::StatusOr<std::vector<TouchedPose>> Poses(const std::vector<std::vector<double>>& axes) const {
    const machine::Machine& machine = *options_.machine;
    std::vector<TouchedPose> poses;
    // The first rotary axis (its number in the machine) that stands elsewhere than `there` says, or -1.
    const auto turned = [&](size_t k, const auto& there) {
      for (int i = 0; i < machine.axis_count(); ++i) {
        if (machine.axes[i].kind == machine::AxisKind::kRotary && std::abs(axes[i][k] - there(i)) > kMaxOffPlanDeg)
          return i;
      }
      return -1;
    };
    size_t first = 0;  // touch of the pose
    for (size_t k = 0; k < log_.readings.size(); ++k) {
      if (poses.empty() || turned(k, [&](int i) { return axes[i][first]; }) >= 0) {
        poses.emplace_back();
        first = k;
        const size_t row = poses.size() - 1;
        if (options_.plan != nullptr && row >= options_.plan->reading_count()) {
          return absl::InvalidArgumentError(
              absl::StrCat(LineOf(k), ": pose ", row + 1, ", but the plan has ", row, ", expected no more"));
        }
        if (options_.plan != nullptr) {
          const auto planned = [&](int i) { return Planned(ColumnName(machine.axes[i]))->values[row]; };
          const int axis = turned(k, planned);
          if (axis >= 0)
            return OffPlan(LineOf(k), ColumnName(machine.axes[axis]), axes[axis][k], row + 1, planned(axis),
                           kMaxOffPlanDeg);
        }
      }
      LatchedTouch touch = {{}, log_.readings[k].line};
      for (int i = 0; i < machine.axis_count(); ++i) {
        const bool is_rotary = machine.axes[i].kind == machine::AxisKind::kRotary;
        touch.positions.push_back(axes[i][k] * (is_rotary ? base::kRadPerDeg : 1.0));
      }
      poses.back().touches.push_back(std::move(touch));
    }
    return poses;
  }

  absl::StatusOr<CentreOptions> OptionsOfCentres() const {
    CentreOptions options;
    std::vector<double> tip, ball;
    session::ParseNumbers(*session::FindHeader(out_.session, "tool_tip_mm"), &tip);
    session::ParseNumbers(*session::FindHeader(out_.session, "table_ball_mm"), &ball);
    options.tip_mm = {tip[0], tip[1], tip[2]};
    options.ball_mm = {ball[0], ball[1], ball[2]};
    options.off_ball_mm = kMaxOffPlanMm;
    double radii_mm[2] = {0.0, 0.0}, gate_um = touch::kDefaultGateMm * base::kUmPerMm;
    const std::pair<const char*, double*> keys[] = {
        {"sphere_radius_mm", &radii_mm[0]}, {"stylus_radius_mm", &radii_mm[1]}, {"radius_gate_um", &gate_um}};
    for (const auto& [key, number] : keys) {
      const std::optional<std::string> text = session::FindHeader(out_.session, key);
      std::vector<double> numbers;
      if (!text) continue;
      if (!session::ParseNumbers(*text, &numbers) || numbers.size() != 1 || !(numbers[0] > 0.0))
        return absl::InvalidArgumentError(
            absl::StrCat("header ", key, ": ", session::Quoted(*text), ", expected one number above 0"));
      *number = numbers[0];
    }
    if (radii_mm[0] > 0.0 && radii_mm[1] > 0.0) options.contact_mm = radii_mm[0] + radii_mm[1];
    options.gate_mm = gate_um * base::kMmPerUm;
    return options;
  }

  absl::Status FillCentres() {
    const machine::Machine& machine = *options_.machine;
    std::vector<std::vector<double>> axes;
    for (const std::string& name : KnownAxes()) {
      if (FieldIndex(name) < 0) {
        return absl::InvalidArgumentError(
            absl::StrCat(template_.name, ": line: '", pattern_.text, "' has no field {", name,
                         "}, and none for centres: a touch is where all axes were latched"));
      }
      axes.push_back(NumbersOf(FieldIndex(name)));
      if (options_.plan != nullptr && name.ends_with("_deg") && Planned(name) == nullptr)
        return absl::InvalidArgumentError("the plan has no column " + name);
    }
    RETURN_IF_ERROR(CheckForeignAxes(KnownAxes()));
    ASSIGN_OR_RETURN(const std::vector<TouchedPose> poses, Poses(axes));
    ASSIGN_OR_RETURN(const CentreOptions options, OptionsOfCentres());
    ASSIGN_OR_RETURN(const SphereCentres centres, CentresOf(machine, poses, options, log_name_));
    if (options_.plan != nullptr && poses.size() < options_.plan->reading_count()) {
      out_.notes.push_back(absl::StrCat("the plan has ", options_.plan->reading_count(), " poses, the log touches at ",
                                        poses.size(), ": the rest is missing"));
    }
    WriteCentres(poses, centres, axes);
    StateSigmas(centres);
    return absl::OkStatus();
  }

  // One reading for each pose: mean positions and times of its touches.
  void WriteCentres(const std::vector<TouchedPose>& poses, const SphereCentres& centres,
                    const std::vector<std::vector<double>>& axes) {
    const machine::Machine& machine = *options_.machine;
    std::vector<Column>& columns = out_.session.columns;
    const int time = FieldIndex("t_s"), temperature = FieldIndex("temp_C");
    const Column* const plan = Planned("t_s");
    const double start_s = options_.start_s.value_or(plan != nullptr ? plan->values[0] : 0.0);
    columns.push_back({"t_s", {}, {}});
    for (const machine::Axis& axis : machine.axes) {
      if (axis.kind == machine::AxisKind::kRotary) columns.push_back({ColumnName(axis), {}, {}});
    }
    if (temperature >= 0) columns.push_back({"temp_C", {}, {}});
    for (const char* const name : {"cx_mm", "cy_mm", "cz_mm"}) columns.push_back({name, {}, {}});
    out_.lines.clear();
    size_t first = 0;
    for (size_t pose = 0; pose < poses.size(); first += poses[pose++].touches.size()) {
      const std::vector<LatchedTouch>& touches = poses[pose].touches;
      if (!centres.poses[pose].why_not.empty()) {
        out_.notes.push_back(absl::StrCat("left out: pose ", pose + 1, ", lines ", touches.front().line, " to ",
                                          touches.back().line, ": ", centres.poses[pose].why_not));
        continue;
      }
      const auto mean = [&](const std::vector<double>& numbers) {
        double sum = 0.0;
        for (size_t k = 0; k < touches.size(); ++k) sum += numbers[first + k];
        return sum / static_cast<double>(touches.size());
      };
      size_t column = 0;
      columns[column++].values.push_back(time >= 0         ? mean(NumbersOf(time))
                                         : plan != nullptr ? start_s + plan->values[pose] - plan->values[0]
                                                           : start_s + static_cast<double>(first) * template_.seconds);
      for (int i = 0; i < machine.axis_count(); ++i) {
        if (machine.axes[i].kind == machine::AxisKind::kRotary) columns[column++].values.push_back(mean(axes[i]));
      }
      if (temperature >= 0) columns[column++].values.push_back(mean(NumbersOf(temperature)));
      for (int i = 0; i < 3; ++i) columns[column++].values.push_back(centres.poses[pose].centre_mm[i]);
      out_.lines.push_back(touches.front().line);
    }
    if (time < 0) {
      out_.notes.push_back(plan != nullptr
                               ? std::string("the log has no times: t_s is the plan's")
                               : absl::StrFormat("the log has no times: t_s counts %g s per touch", template_.seconds));
    }
  }

  // How well the centres are known: in the header, and in place of a stated sigma that is smaller.
  void StateSigmas(const SphereCentres& centres) {
    const Eigen::Vector3d sigma_um = centres.centre_sigma_mm * base::kUmPerMm;
    const std::string text = absl::StrFormat("%.3g %.3g %.3g", sigma_um.x(), sigma_um.y(), sigma_um.z());
    out_.session.header.push_back({kCentreSigma, text});
    out_.notes.push_back(
        absl::StrFormat("centres are of spheres through touches that scatter by %.3g um about them; one sigma of a "
                        "centre in x y z: %s um",
                        centres.touch_sigma_mm * base::kUmPerMm, text));
    std::vector<double> stated;
    for (session::HeaderEntry& entry : out_.session.header) {
      if (entry.key != "sigma_um" || !session::ParseNumbers(entry.value, &stated) || stated[0] >= sigma_um.maxCoeff())
        continue;
      const std::string larger = absl::StrFormat("%.3g", sigma_um.maxCoeff());
      out_.notes.push_back(
          absl::StrCat("sigma_um is ", larger, ", that of these touches, and not the stated ", entry.value));
      entry.value = larger;
    }
  }

  // Values against the rules of session files, told by the log's line.
  absl::Status CheckValues() const {
    std::vector<std::string> names;
    for (const Column& column : out_.session.columns) names.push_back(column.name);
    const auto rules = session::ColumnRules(out_.session.header, names);
    if (!rules.ok()) return base::Within(template_.name, rules.status());
    for (size_t i = 0; i < rules->size(); ++i) {
      const Column& column = out_.session.columns[i];
      for (size_t k = 0; k < column.texts.size(); ++k)
        RETURN_IF_ERROR(
            base::Within(LineOf(k) + " (" + column.name + ")", session::CheckName((*rules)[i], column.texts[k])));
      for (size_t k = 0; k < column.values.size(); ++k) {
        if (!(*rules)[i].Fits(column.values[k]) && !((*rules)[i].may_be_empty && std::isnan(column.values[k])))
          return absl::InvalidArgumentError(absl::StrFormat("%s (%s): %g, expected %s", LineOf(k), column.name,
                                                            column.values[k], (*rules)[i].expected));
        if (column.name == "t_s" && k > 0 && column.values[k] < column.values[k - 1])
          return absl::InvalidArgumentError(absl::StrFormat("%s (t_s): %g after %g: time never runs back", LineOf(k),
                                                            column.values[k], column.values[k - 1]));
      }
    }
    return absl::OkStatus();
  }

  void Report() {
    for (const Announcement& a : log_.announcements) {
      out_.notes.push_back(absl::StrCat("line ", a.line, " of the log announces ", a.announced, " readings, ", a.found,
                                        a.found == 1 ? " is" : " are", " there"));
    }
    out_.cut = log_.cut;
    if (!log_.cut) return;
    const std::string what = absl::StrCat("line ", log_.cut->line, " of the log: ", session::Quoted(log_.cut->text));
    out_.session.header.push_back({kCutLine, what});
    out_.notes.push_back("cut, and left out: " + what);
  }

  const std::string& log_name_;
  const LogTemplate& template_;
  const ReduceOptions& options_;
  const session::InstrumentFormat* format_ = nullptr;
  LinePattern pattern_;
  Log log_;
  std::vector<Column> axes_;
  std::vector<std::string> from_plan_;  // of axes_
  Reduced out_;
};

}  // namespace

absl::StatusOr<Reduced> Reduce(std::istream& log, const std::string& log_name, const LogTemplate& log_template,
                               const ReduceOptions& options) {
  return Reducer(log_name, log_template, options).Run(log);
}

}  // namespace axiscal::logs
