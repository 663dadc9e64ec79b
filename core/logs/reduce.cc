#include "core/logs/reduce.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "core/base/units.h"
#include "core/instruments/plausible.h"
#include "core/instruments/touch/touch_bind.h"
#include "core/instruments/touch/touch_model.h"
#include "core/logs/log_rows.h"
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

// Where each column of the session comes from: the log, the plan, the template, or what is computed of them.
class Reducer {
 public:
  Reducer(const std::string& log_name, const LogTemplate& log_template, const ReduceOptions& options)
      : log_name_(log_name), template_(log_template), options_(options), rows_(log_name, log_template, options) {}

  absl::StatusOr<Reduced> Run(std::istream& in) {
    RETURN_IF_ERROR(MakeHeader());
    RETURN_IF_ERROR(rows_.Read(in, *format_));
    for (const LogReading& reading : rows_.readings()) out_.lines.push_back(reading.line);
    if (rows_.AreTouchesOfCentres()) {
      RETURN_IF_ERROR(FillCentres());
    } else {
      RETURN_IF_ERROR(FillAxes());
      RETURN_IF_ERROR(rows_.CheckPlan(from_plan_, &axes_, &out_.notes));
      FillTimes();
      if (format_->name == "touch") RETURN_IF_ERROR(FillTouches());
      RETURN_IF_ERROR(FillMissing());
      FillRest();
      FillSenses();
    }
    RETURN_IF_ERROR(CheckValues());
    Report();
    RETURN_IF_ERROR(base::Within(template_.name, session::Validate(out_.session)));
    if (options_.machine != nullptr) RETURN_IF_ERROR(CheckReadings(*options_.machine));
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
      std::erase_if(header, [](const session::HeaderEntry& entry) {
        return entry.key == kCutLine || entry.key == kCentreSigma || entry.key == "log" ||
               entry.key.starts_with("log_");
      });
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

  absl::Status NoField(const std::string& name) const {
    return absl::InvalidArgumentError(absl::StrCat(
        template_.name, ": line: '", rows_.pattern().text, "' has no field {", name, "}, instrument ", format_->name,
        " needs it", format_->name == "touch" ? "" : ", expected the field or a plan that holds it"));
  }

  absl::Status FillAxes() {
    std::vector<std::string> names = rows_.KnownAxes();
    if (names.empty()) {
      for (const Piece& piece : rows_.pattern().pieces) {
        if (rows_.IsAxis(piece.field)) names.push_back(piece.field);
      }
    }
    RETURN_IF_ERROR(rows_.CheckForeignAxes(names));
    for (const std::string& name : names) {
      const bool is_linear = name.ends_with("_mm");
      if ((format_->axes == session::AxisColumns::kRotaryOnly && is_linear) ||
          format_->axes == session::AxisColumns::kNone)
        continue;
      const int field = rows_.FieldIndex(name);
      if (field >= 0) {
        axes_.push_back({name, rows_.NumbersOf(field), {}});
        rows_.CountOn(name, &axes_.back().values, &out_.notes);
        continue;
      }
      // A touch is where the axes were latched; all else is measured at commanded positions, which the plan holds.
      const Column* const plan = rows_.Planned(name);
      if (plan == nullptr || format_->name == "touch") return NoField(name);
      axes_.push_back(*plan);
      from_plan_.push_back(name);
    }
    return absl::OkStatus();
  }

  // Of a log with moments (`time:`) the first reading stands at --start-s, or at 0.
  std::vector<double> Times(int field) const {
    std::vector<double> times = rows_.NumbersOf(field);
    if (!template_.time.empty())
      for (double& time_s : times) time_s += options_.start_s.value_or(0.0);
    return times;
  }

  void FillTimes() {
    std::vector<Column>& columns = out_.session.columns;
    const int field = rows_.FieldIndex("t_s");
    if (field >= 0) {
      columns.push_back({"t_s", Times(field), {}});
    } else if (format_->has_time) {
      const Column* const plan = rows_.Planned("t_s");
      const double start_s = options_.start_s.value_or(plan != nullptr ? plan->values[0] : 0.0);
      Column times = {"t_s", {}, {}};
      for (size_t k = 0; k < rows_.readings().size(); ++k) {
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

  absl::StatusOr<std::string> FeatureOf(const std::string& column, size_t k) const {
    if (const std::optional<std::string> name = rows_.LoggedName(column, k)) return *name;
    if (const Column* const plan = rows_.Planned(column)) return plan->texts[k];
    if (!template_.feature.empty()) return template_.feature;
    std::vector<std::string> names;
    for (const session::HeaderEntry& entry : out_.session.header) {
      const session::FeatureRule* rule = session::FindFeatureRule(*format_, entry.key);
      if (rule != nullptr) names.push_back(entry.key.substr(rule->prefix.size() + 1));
    }
    if (names.size() == 1) return names[0];
    return WrongAt({rows_.readings()[k].line, 0, column},
                   rows_.LineOf(k) + ": nothing says which " +
                       (column == "feature" ? "feature was touched" : column + " was measured") +
                       ", expected a field {" + column + "}, 'mark: ...', 'feature: ...' or a plan");
  }

  absl::Status FillTouches() {
    const size_t count = rows_.readings().size();
    Column approach[3] = {{"nx", {}, {}}, {"ny", {}, {}}, {"nz", {}, {}}}, feature = {"feature", {}, {}};
    for (size_t k = 0; k < count; ++k) {
      ASSIGN_OR_RETURN(std::string name, FeatureOf("feature", k));
      feature.texts.push_back(std::move(name));
    }
    const int fields[3] = {rows_.FieldIndex("nx"), rows_.FieldIndex("ny"), rows_.FieldIndex("nz")};
    const bool are_logged = fields[0] >= 0 && fields[1] >= 0 && fields[2] >= 0;
    std::vector<double> logged[3];
    for (int i = 0; are_logged && i < 3; ++i) logged[i] = rows_.NumbersOf(fields[i]);
    for (size_t k = 0; k < count; ++k) {
      Eigen::Vector3d n;
      if (are_logged) {
        for (int i = 0; i < 3; ++i) n[i] = logged[i][k];
      } else if (options_.plan != nullptr) {
        for (int i = 0; i < 3; ++i) n[i] = rows_.Planned(approach[i].name)->values[k];
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
    return WrongAt({rows_.readings()[k].line, 0, "feature"},
                   absl::StrCat(rows_.LineOf(k), ": feature ", session::Quoted(name), " has no header line '# sphere ",
                                name, ": ...' or '# plane ...'"));
  }

  // Columns of the instrument that the line does not hold.
  absl::Status FillMissing() {
    for (const session::ReadingColumn& column : format_->columns) {
      if (session::FindColumn(out_.session, column.name) != nullptr || rows_.FieldIndex(column.name) >= 0) continue;
      if (column.is_optional && rows_.Planned(column.name) == nullptr) continue;
      ASSIGN_OR_RETURN(Column filled, Missing(column));
      out_.session.columns.push_back(std::move(filled));
    }
    std::string columns;
    for (const std::string& name : from_plan_) absl::StrAppend(&columns, columns.empty() ? "" : ", ", name);
    if (!columns.empty()) out_.notes.push_back(columns + ": not in the log, the plan's");
    if (rows_.Planned("temp_C") != nullptr && rows_.FieldIndex("temp_C") < 0)
      out_.notes.push_back("temp_C: left out, the plan's is not what was measured, and the log has none");
    return absl::OkStatus();
  }

  absl::StatusOr<Column> Missing(const session::ReadingColumn& column) {
    const size_t count = rows_.readings().size();
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
    if (const Column* const plan = rows_.Planned(column.name)) {
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
    return absl::InvalidArgumentError(absl::StrCat(template_.name, ": line: '", rows_.pattern().text,
                                                   "' has no field {", column.name, "}, instrument ", format_->name,
                                                   " needs it, expected the field or a plan"));
  }

  // The instrument's own columns and the temperature, as the line gives them.
  void FillRest() {
    for (size_t i = 0; i < rows_.pattern().pieces.size(); ++i) {
      const Piece& piece = rows_.pattern().pieces[i];
      if (piece.field.empty() || piece.field == "*" || rows_.IsAxis(piece.field) ||
          session::FindColumn(out_.session, piece.field) != nullptr)
        continue;
      Column column = {piece.field, {}, {}};
      if (piece.is_text) {
        for (const LogReading& reading : rows_.readings()) column.texts.push_back(reading.fields[i].text);
      } else {
        column.values = rows_.NumbersOf(static_cast<int>(i));
      }
      out_.session.columns.push_back(std::move(column));
    }
  }

  // From which side an axis came is the plan's where the log does not say it: no position shows it.
  void FillSenses() {
    if (options_.plan == nullptr) return;
    for (Column column : options_.plan->columns) {
      const std::optional<session::ColumnRule> rule = session::StateColumnRule(column.name);
      if (!rule || !rule->IsSense() || session::FindColumn(out_.session, column.name) != nullptr) continue;
      column.values.resize(rows_.readings().size());
      out_.notes.push_back(column.name + ": not in the log, the plan's");
      out_.session.columns.push_back(std::move(column));
    }
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
    for (const std::string& name : rows_.KnownAxes()) {
      if (rows_.FieldIndex(name) < 0) {
        return absl::InvalidArgumentError(
            absl::StrCat(template_.name, ": line: '", rows_.pattern().text, "' has no field {", name,
                         "}, and none for centres: a touch is where all axes were latched"));
      }
      axes.push_back(rows_.NumbersOf(rows_.FieldIndex(name)));
      rows_.CountOn(name, &axes.back(), &out_.notes);
      if (options_.plan != nullptr && name.ends_with("_deg") && rows_.Planned(name) == nullptr)
        return absl::InvalidArgumentError("the plan has no column " + name);
    }
    RETURN_IF_ERROR(rows_.CheckForeignAxes(rows_.KnownAxes()));
    ASSIGN_OR_RETURN(const std::vector<TouchedPose> poses, rows_.Poses(&axes));
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
    const int time = rows_.FieldIndex("t_s"), temperature = rows_.FieldIndex("temp_C");
    const Column* const plan = rows_.Planned("t_s");
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
      columns[column++].values.push_back(time >= 0         ? mean(Times(time))
                                         : plan != nullptr ? start_s + plan->values[pose] - plan->values[0]
                                                           : start_s + static_cast<double>(first) * template_.seconds);
      for (int i = 0; i < machine.axis_count(); ++i) {
        if (machine.axes[i].kind == machine::AxisKind::kRotary) columns[column++].values.push_back(mean(axes[i]));
      }
      if (temperature >= 0) columns[column++].values.push_back(mean(rows_.NumbersOf(temperature)));
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
    const auto line_of = [&](size_t row) { return absl::StrCat(log_name_, ": line ", out_.lines[row]); };
    std::vector<std::string> names;
    for (const Column& column : out_.session.columns) names.push_back(column.name);
    const auto rules = session::ColumnRules(out_.session.header, names);
    if (!rules.ok()) return base::Within(template_.name, rules.status());
    for (size_t i = 0; i < rules->size(); ++i) {
      const Column& column = out_.session.columns[i];
      for (size_t k = 0; k < column.texts.size(); ++k)
        if (const absl::Status wrong = session::CheckName((*rules)[i], column.texts[k]); !wrong.ok()) {
          return WrongAt({out_.lines[k], 0, column.name},
                         absl::StrCat(line_of(k), " (", column.name, "): ", wrong.message()));
        }
      for (size_t k = 0; k < column.values.size(); ++k) {
        if (!(*rules)[i].Fits(column.values[k]) && !((*rules)[i].may_be_empty && std::isnan(column.values[k])))
          return WrongAt({out_.lines[k], 0, column.name},
                         absl::StrFormat("%s (%s): %g, expected %s", line_of(k), column.name, column.values[k],
                                         (*rules)[i].expected));
        if (column.name == "t_s" && k > 0 && column.values[k] < column.values[k - 1])
          return WrongAt({out_.lines[k], 0, column.name},
                         absl::StrFormat("%s (t_s): %g after %g: time never runs back", line_of(k), column.values[k],
                                         column.values[k - 1]));
      }
    }
    return absl::OkStatus();
  }

  // What is wrong with a line of the log by its machine.
  absl::Status InLog(const absl::Status& status) const {
    size_t line = 0;
    if (status.ok()) return status;
    const std::string message(status.message()), whole = absl::StrCat(log_name_, ": ", message);
    const size_t at = message.starts_with("line ") ? 0 : message.find(": line ");
    const size_t number = at == std::string::npos ? at : message.find_first_of("0123456789", at);
    if (number == std::string::npos || std::sscanf(message.c_str() + number, "%zu", &line) != 1)
      return absl::InvalidArgumentError(whole);
    return WrongAt({line, 0, ""}, whole);
  }

  // Readings against the machine, told by the log's line.
  absl::Status CheckReadings(const machine::Machine& machine) const {
    std::vector<std::string> names;
    for (const Column& column : out_.session.columns) names.push_back(column.name);
    const auto check = session::MachineCheck::Create(out_.session.header, names, machine);
    if (!check.ok()) return base::Within(options_.plan != nullptr ? "the plan" : template_.name, check.status());
    RETURN_IF_ERROR(InLog(check->Check(out_.session.columns, &out_.lines)));
    RETURN_IF_ERROR(InLog(instruments::CheckPlausible(out_.session, machine, 0, &out_.lines)));
    return base::Within(log_name_, instruments::CheckWhole(out_.session));
  }

  void Report() {
    for (const Announcement& a : rows_.log().announcements) {
      out_.notes.push_back(absl::StrCat("line ", a.line, " of the log announces ", a.announced, " readings, ", a.found,
                                        a.found == 1 ? " is" : " are", " there"));
    }
    out_.cut = rows_.log().cut;
    if (!rows_.log().cut) return;
    const std::string what =
        absl::StrCat("line ", rows_.log().cut->line, " of the log: ", session::Quoted(rows_.log().cut->text));
    out_.session.header.push_back({kCutLine, what});
    out_.notes.push_back("cut, and left out: " + what);
  }

  const std::string& log_name_;
  const LogTemplate& template_;
  const ReduceOptions& options_;
  const session::InstrumentFormat* format_ = nullptr;
  LogRows rows_;
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
