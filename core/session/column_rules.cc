#include "core/session/column_rules.h"

#include <algorithm>
#include <cctype>
#include <map>

#include "core/base/demand.h"
#include "core/session/text.h"

namespace axiscal::session {
namespace {

const InstrumentFormat& FormatOf(const std::vector<HeaderEntry>& header) {
  const InstrumentFormat* format = nullptr;
  for (const HeaderEntry& entry : header) {
    if (entry.key == "instrument") format = FindInstrumentFormat(entry.value);
  }
  DEMAND(format != nullptr);  // the header was validated
  return *format;
}

std::set<std::string> FeatureNames(const std::vector<HeaderEntry>& header, const InstrumentFormat& format) {
  std::set<std::string> names;
  for (const HeaderEntry& entry : header) {
    const FeatureRule* rule = FindFeatureRule(format, entry.key);
    if (rule != nullptr) names.insert(entry.key.substr(rule->prefix.size() + 1));
  }
  return names;
}

ColumnRule RangeRule(const std::string& name, ColumnKind kind, double min, double max, const std::string& unit) {
  ColumnRule rule{name, kind, "", min, max, absl::StrFormat("%s from %g to %g", unit, min, max), false, {}};
  return rule;
}

// "T_spindle_C": a letter, then letters, digits and '-'.
bool IsNamedTemperature(const std::string& column) {
  if (!column.starts_with("T_") || !column.ends_with("_C") || column.size() < 5) return false;
  const std::string name = column.substr(2, column.size() - 4);
  return std::isalpha(static_cast<unsigned char>(name[0])) != 0 && std::all_of(name.begin(), name.end(), [](char c) {
           return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-';
         });
}

// "X_enc_mm" is to "X_mm" what the encoder shows.
bool AxisOfEncoder(const std::string& column, std::string* axis, ColumnKind* kind) {
  const size_t bar = column.find("_enc_");
  if (bar == std::string::npos) return false;
  if (!ParseAxisColumn(column.substr(0, bar) + column.substr(bar + 4), axis, kind)) return false;
  *kind = *kind == ColumnKind::kLinearAxis ? ColumnKind::kLinearEncoder : ColumnKind::kRotaryEncoder;
  return true;
}

// "X_sense".
bool AxisOfSense(const std::string& column, std::string* axis) {
  ColumnKind kind;
  constexpr std::string_view kEnd = "_sense";
  return column.ends_with(kEnd) && ParseAxisColumn(column.substr(0, column.size() - kEnd.size()) + "_mm", axis, &kind);
}

// A reading of a plan: nothing is there yet.
bool IsUnread(const ReadingColumn& column, SessionKind kind) {
  return kind == SessionKind::kPlan && column.source != ColumnSource::kPlan;
}

// The rule of a column, or nothing when the instrument has no such column.
std::optional<ColumnRule> RuleOf(const std::string& name, const InstrumentFormat& format,
                                 const std::set<std::string>& feature_names, SessionKind session_kind) {
  for (const ReadingColumn& column : format.columns) {
    if (column.name != name) continue;
    const bool is_feature = column.is_name && (name == "feature" || name == "rod");
    return ColumnRule{name,
                      column.is_name ? ColumnKind::kName : ColumnKind::kReading,
                      "",
                      column.min,
                      column.max,
                      column.expected,
                      column.may_be_empty || IsUnread(column, session_kind),
                      is_feature ? feature_names : std::set<std::string>()};
  }
  return StateColumnRule(name);
}

std::string KnownColumns(const InstrumentFormat& format) {
  std::string known = format.has_time ? "t_s, " : "";
  if (format.axes == AxisColumns::kAll) known += "axis columns such as X_mm or B_deg, ";
  if (format.axes == AxisColumns::kRotaryOnly) known += "rotary axis columns such as B_deg, ";
  if (format.axes != AxisColumns::kNone)
    known += "encoder columns such as X_enc_mm or B_enc_deg, senses such as X_sense, ";
  known += "temp_C, T_NAME_C";
  for (const ReadingColumn& column : format.columns) known += ", " + column.name;
  return known;
}

absl::Status RequireColumns(const std::vector<std::string>& columns, const InstrumentFormat& format, size_t line,
                            SessionKind kind) {
  std::vector<std::string> required;
  for (const ReadingColumn& column : format.columns) {
    if (!column.is_optional && !IsUnread(column, kind)) required.push_back(column.name);
  }
  for (const std::string& name : required) {
    if (std::find(columns.begin(), columns.end(), name) != columns.end()) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("line ", line, ": column ", name, " is missing, instrument ", format.name, " needs it"));
  }
  return absl::OkStatus();
}

}  // namespace

std::optional<ColumnRule> StateColumnRule(const std::string& name) {
  if (name == "t_s") return RangeRule(name, ColumnKind::kTime, -kMaxTimeS, kMaxTimeS, "s");
  if (name == "temp_C" || IsNamedTemperature(name))
    return RangeRule(name, ColumnKind::kTemperature, kMinTemperatureC, kMaxTemperatureC, "deg C");
  std::string axis;
  ColumnKind kind;
  if (AxisOfSense(name, &axis)) {
    ColumnRule rule{name, ColumnKind::kSense, axis, -1.0, 1.0, "1 or -1, or 0 where the positions show it", false, {}};
    return rule;
  }
  const bool is_encoder = AxisOfEncoder(name, &axis, &kind);
  if (!is_encoder && !ParseAxisColumn(name, &axis, &kind)) return std::nullopt;
  const bool linear = kind == ColumnKind::kLinearAxis || kind == ColumnKind::kLinearEncoder;
  const double limit = linear ? kMaxLengthMm : kMaxAngleDeg;
  ColumnRule rule = RangeRule(name, kind, -limit, limit, linear ? "mm" : "deg");
  rule.axis = axis;
  return rule;
}

std::string Place(size_t line, size_t column, const std::string& name) {
  return absl::StrCat("line ", line, ", column ", column + 1, " (", name, ")");
}

bool ParseAxisColumn(const std::string& column, std::string* axis, ColumnKind* kind) {
  const size_t bar = column.find('_');
  if (bar == std::string::npos || bar == 0 || column[0] < 'A' || column[0] > 'Z') return false;
  const auto digit = [](unsigned char c) { return std::isdigit(c) != 0; };
  if (!std::all_of(column.begin() + 1, column.begin() + bar, digit)) return false;
  const std::string unit = column.substr(bar);
  if (unit != "_mm" && unit != "_deg") return false;
  *axis = column.substr(0, bar);
  *kind = unit == "_mm" ? ColumnKind::kLinearAxis : ColumnKind::kRotaryAxis;
  return true;
}

absl::Status CheckName(const ColumnRule& rule, const std::string& text) {
  if (text.empty() || text.size() > kMaxNameBytes || !IsPlainText(text) || text.find(',') != std::string::npos) {
    return absl::InvalidArgumentError(
        absl::StrCat(Quoted(text), ", expected a name of 1 to ", kMaxNameBytes, " bytes of UTF-8 without a comma"));
  }
  if (rule.names.empty() || rule.names.count(text) != 0) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(Quoted(text), ", expected a name that the header describes, such as '", *rule.names.begin(), "'"));
}

absl::StatusOr<std::vector<ColumnRule>> ColumnRules(const std::vector<HeaderEntry>& header,
                                                    const std::vector<std::string>& columns, SessionKind session_kind) {
  const InstrumentFormat& format = FormatOf(header);
  const size_t line = HeaderLine(header.size());
  if (columns.size() > kMaxColumns) {
    return absl::InvalidArgumentError(
        absl::StrCat("line ", line, ": ", columns.size(), " columns, at most ", kMaxColumns, " are read"));
  }
  const std::set<std::string> feature_names = FeatureNames(header, format);
  std::vector<ColumnRule> rules;
  std::map<std::string, size_t> seen;  // column or axis -> its index
  for (size_t i = 0; i < columns.size(); ++i) {
    const std::string place = Place(line, i, columns[i].empty() ? "no name" : Printable(columns[i]));
    std::optional<ColumnRule> rule = RuleOf(columns[i], format, feature_names, session_kind);
    const bool is_of_axis = rule && !rule->axis.empty();
    const bool wrong_axis = is_of_axis && (format.axes == AxisColumns::kNone ||
                                           (format.axes == AxisColumns::kRotaryOnly && rule->IsLinear()));
    if (!rule || wrong_axis) {
      const bool other_separator = columns.size() == 1 && columns[i].find_first_of(";\t") != std::string::npos;
      return absl::InvalidArgumentError(
          absl::StrCat(place, ": unknown column for instrument ", format.name, ", expected ",
                       other_separator ? "names separated by commas" : KnownColumns(format)));
    }
    const std::string of = rule->IsAxis() ? "axis " : rule->IsSense() ? "sense " : "encoder ";
    const auto [first, is_new] = seen.emplace(rule->axis.empty() ? rule->name : of + rule->axis, i);
    if (!is_new) {
      return absl::InvalidArgumentError(absl::StrCat(place, ": the same ",
                                                     rule->axis.empty() ? "name" : of.substr(0, of.size() - 1),
                                                     " as column ", first->second + 1, ", expected once"));
    }
    rules.push_back(*std::move(rule));
  }
  RETURN_IF_ERROR(RequireColumns(columns, format, line, session_kind));
  return rules;
}

}  // namespace axiscal::session
