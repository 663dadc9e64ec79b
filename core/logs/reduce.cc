#include "core/logs/reduce.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/instruments/plausible.h"
#include "core/instruments/touch/touch_bind.h"
#include "core/instruments/touch/touch_model.h"
#include "core/session/check_machine.h"
#include "core/session/column_rules.h"
#include "core/session/header_rules.h"
#include "core/session/text.h"
#include "core/session/validate.h"

namespace axiscal::logs {
namespace {

using session::Column;
using session::Session;

absl::Status Refuse(const std::string& what) { return absl::InvalidArgumentError(what); }

std::string ColumnName(const machine::Axis& axis) {
  return axis.name + (axis.kind == machine::AxisKind::kLinear ? "_mm" : "_deg");
}

bool IsAxis(const std::string& column) {
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
    ASSIGN_OR_RETURN(log_, ReadLog(in, log_name_, template_, pattern_));
    RETURN_IF_ERROR(CheckFields());
    RETURN_IF_ERROR(FillAxes());
    RETURN_IF_ERROR(CheckPlan());
    FillTimes();
    if (format_->name == "touch") RETURN_IF_ERROR(FillTouches());
    FillRest();
    RETURN_IF_ERROR(CheckValues());
    Report();
    RETURN_IF_ERROR(base::Within(template_.name, session::Validate(out_.session)));
    if (options_.machine != nullptr) {
      RETURN_IF_ERROR(base::Within(log_name_, session::CheckAgainstMachine(out_.session, *options_.machine)));
      RETURN_IF_ERROR(base::Within(log_name_, instruments::CheckPlausible(out_.session, *options_.machine)));
    }
    for (const LogReading& reading : log_.readings) out_.lines.push_back(reading.line);
    return std::move(out_);
  }

 private:
  absl::Status MakeHeader() {
    std::vector<session::HeaderEntry>& header = out_.session.header;
    header = template_.header;
    if (options_.plan != nullptr) {
      if (!header.empty())
        return Refuse(template_.name + ": header lines beside a plan, which brings them: expected rules alone");
      header = options_.plan->header;
    }
    if (header.empty()) {
      return Refuse(template_.name +
                    ": no header lines '# key: value' of the session, expected them in the template or in a plan");
    }
    for (session::HeaderEntry& entry : header) {
      if (entry.key == "session" && !options_.session.empty()) entry.value = options_.session;
    }
    RETURN_IF_ERROR(base::Within(template_.name, session::ValidateHeader(header)));
    const std::string machine = *session::FindHeader(out_.session, "machine");
    if (options_.machine != nullptr && machine != options_.machine->id) {
      return Refuse(absl::StrCat(options_.plan != nullptr ? "the plan" : template_.name,
                                 ": machine: ", session::Quoted(machine), ", expected '", options_.machine->id, "'"));
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
    }
    return names;
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
      return Refuse(template_.name +
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
    if (field == "temp_C" || IsAxis(field)) return true;
    return std::any_of(format_->columns.begin(), format_->columns.end(),
                       [&](const session::ReadingColumn& column) { return column.name == field; });
  }

  absl::Status CheckFields() const {
    for (const Piece& piece : pattern_.pieces) {
      if (piece.field.empty() || piece.field == "*" || IsColumn(piece.field)) continue;
      return Refuse(absl::StrCat(template_.name, ": line: {", piece.field, "} is no column of instrument ",
                                 format_->name, ", expected such as X_mm, B_deg, t_s, temp_C",
                                 format_->columns.empty() ? "" : ", " + format_->columns[0].name));
    }
    for (const auto& [axis, scale] : template_.scales) {
      if (FieldIndex(axis + "_mm") < 0 && FieldIndex(axis + "_deg") < 0)
        return Refuse(absl::StrCat(template_.name, ": axis ", axis, " is scaled, but its line has no such field"));
    }
    return absl::OkStatus();
  }

  std::vector<double> NumbersOf(int field) const {
    std::vector<double> numbers;
    for (const LogReading& reading : log_.readings) numbers.push_back(reading.fields[field].number);
    return numbers;
  }

  std::string LineOf(size_t reading) const { return absl::StrCat(log_name_, ": line ", log_.readings[reading].line); }

  absl::Status FillAxes() {
    std::vector<std::string> names = KnownAxes();
    const bool is_known = !names.empty();
    for (const Piece& piece : pattern_.pieces) {
      if (!IsAxis(piece.field)) continue;
      if (!is_known) names.push_back(piece.field);
      if (std::find(names.begin(), names.end(), piece.field) != names.end()) continue;
      // LinuxCNC prints nine axes, whatever the machine has: those it has not read 0.
      const std::vector<double> numbers = NumbersOf(FieldIndex(piece.field));
      for (size_t k = 0; k < numbers.size(); ++k) {
        if (numbers[k] == 0.0 && template_.format == KnownFormat::kLinuxCncProbe) continue;
        return Refuse(absl::StrCat(LineOf(k), ": ", piece.field, " reads ", numbers[k], ", but ",
                                   options_.machine != nullptr ? "machine " + options_.machine->id : "the plan",
                                   " has no such axis"));
      }
    }
    for (const std::string& name : names) {
      const bool is_linear = name.ends_with("_mm");
      if ((format_->axes == session::AxisColumns::kRotaryOnly && is_linear) ||
          format_->axes == session::AxisColumns::kNone)
        continue;
      const int field = FieldIndex(name);
      if (field < 0) {
        return Refuse(absl::StrCat(template_.name, ": line: '", pattern_.text, "' has no field {", name,
                                   "}, instrument ", format_->name, " needs it"));
      }
      std::vector<double> numbers = NumbersOf(field);
      const auto scale = template_.scales.find(name.substr(0, name.find('_')));
      if (scale != template_.scales.end()) {
        for (double& number : numbers) number = scale->second.scale * number + scale->second.offset;
      }
      axes_.push_back({name, std::move(numbers), {}});
    }
    return absl::OkStatus();
  }

  absl::Status CheckPlan() {
    if (options_.plan == nullptr) return absl::OkStatus();
    const size_t planned = options_.plan->reading_count(), found = log_.readings.size();
    if (found > planned) {
      return Refuse(absl::StrCat(LineOf(planned), ": reading ", planned + 1, ", but the plan has ", planned,
                                 ", expected no more"));
    }
    for (const Column& column : axes_) {
      const Column* const plan = session::FindColumn(*options_.plan, column.name);
      if (plan == nullptr) return Refuse(absl::StrCat("the plan has no column ", column.name));
      const double limit = column.name.ends_with("_mm") ? kMaxOffPlanMm : kMaxOffPlanDeg;
      for (size_t k = 0; k < found; ++k) {
        if (std::abs(column.values[k] - plan->values[k]) <= limit) continue;
        return Refuse(absl::StrFormat(
            "%s: %s = %g, but line %d of the plan is at %g, expected within %g: was a touch missed, or another program "
            "run?",
            LineOf(k), column.name, column.values[k], k + 1, plan->values[k], limit));
      }
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
      const Column* const plan = options_.plan != nullptr ? session::FindColumn(*options_.plan, "t_s") : nullptr;
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

  absl::StatusOr<std::string> FeatureOf(size_t k) const {
    const int field = FieldIndex("feature");
    if (field >= 0) return log_.readings[k].fields[field].text;
    if (!log_.readings[k].feature.empty()) return log_.readings[k].feature;
    if (options_.plan != nullptr) return session::FindColumn(*options_.plan, "feature")->texts[k];
    if (!template_.feature.empty()) return template_.feature;
    std::vector<std::string> names;
    for (const session::HeaderEntry& entry : out_.session.header) {
      const session::FeatureRule* rule = session::FindFeatureRule(*format_, entry.key);
      if (rule != nullptr) names.push_back(entry.key.substr(rule->prefix.size() + 1));
    }
    if (names.size() == 1) return names[0];
    return Refuse(LineOf(k) +
                  ": nothing says which feature was touched, expected a field {feature}, 'mark: ...', "
                  "'feature: ...' or a plan");
  }

  absl::Status FillTouches() {
    const size_t count = log_.readings.size();
    Column approach[3] = {{"nx", {}, {}}, {"ny", {}, {}}, {"nz", {}, {}}}, feature = {"feature", {}, {}};
    for (size_t k = 0; k < count; ++k) {
      ASSIGN_OR_RETURN(std::string name, FeatureOf(k));
      feature.texts.push_back(std::move(name));
    }
    const int fields[3] = {FieldIndex("nx"), FieldIndex("ny"), FieldIndex("nz")};
    for (size_t k = 0; k < count; ++k) {
      Eigen::Vector3d n;
      if (fields[0] >= 0 && fields[1] >= 0 && fields[2] >= 0) {
        for (int i = 0; i < 3; ++i) n[i] = log_.readings[k].fields[fields[i]].number;
      } else if (options_.plan != nullptr) {
        for (int i = 0; i < 3; ++i) n[i] = session::FindColumn(*options_.plan, approach[i].name)->values[k];
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
      return Refuse(template_.name +
                    ": nothing says from where the stylus came, expected fields {nx} {ny} {nz}, "
                    "'approach: nx ny nz', 'approach: feature' or a plan");
    }
    if (options_.machine == nullptr)
      return Refuse(template_.name + ": 'approach: feature' needs the machine, whose axes say where the stylus stood");
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
    return Refuse(absl::StrCat(LineOf(k), ": feature ", session::Quoted(name), " has no header line '# sphere ", name,
                               ": ...' or '# plane ...'"));
  }

  // The instrument's own columns and the temperature, as the line gives them.
  void FillRest() {
    for (size_t i = 0; i < pattern_.pieces.size(); ++i) {
      const Piece& piece = pattern_.pieces[i];
      if (piece.field.empty() || piece.field == "*" || IsAxis(piece.field) ||
          session::FindColumn(out_.session, piece.field) != nullptr)
        continue;
      Column column = {piece.field, {}, {}};
      for (const LogReading& reading : log_.readings) {
        if (piece.is_text) {
          column.texts.push_back(reading.fields[i].text);
        } else {
          column.values.push_back(reading.fields[i].number);
        }
      }
      out_.session.columns.push_back(std::move(column));
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
        if (!(*rules)[i].Fits(column.values[k]))
          return Refuse(absl::StrFormat("%s (%s): %g, expected %s", LineOf(k), column.name, column.values[k],
                                        (*rules)[i].expected));
        if (column.name == "t_s" && k > 0 && column.values[k] < column.values[k - 1])
          return Refuse(absl::StrFormat("%s (t_s): %g after %g: time never runs back", LineOf(k), column.values[k],
                                        column.values[k - 1]));
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
    out_.session.header.push_back({"cut_line", what});
    out_.notes.push_back("cut, and left out: " + what);
  }

  const std::string& log_name_;
  const LogTemplate& template_;
  const ReduceOptions& options_;
  const session::InstrumentFormat* format_ = nullptr;
  LinePattern pattern_;
  Log log_;
  std::vector<Column> axes_;
  Reduced out_;
};

}  // namespace

absl::StatusOr<Reduced> Reduce(std::istream& log, const std::string& log_name, const LogTemplate& log_template,
                               const ReduceOptions& options) {
  return Reducer(log_name, log_template, options).Run(log);
}

}  // namespace axiscal::logs
