#include "core/session/validate.h"

#include <cmath>

#include "core/session/column_rules.h"

namespace axiscal::session {
namespace {

absl::Status ValidateColumn(const Column& column, const ColumnRule& rule, size_t index, size_t header_entries,
                            size_t readings) {
  const bool is_name = rule.kind == ColumnKind::kName;
  const size_t length = is_name ? column.texts.size() : column.values.size();
  const size_t other = is_name ? column.values.size() : column.texts.size();
  if (length != readings || other != 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("column ", index + 1, " (", column.name, "): ", length, is_name ? " texts" : " numbers",
                     other != 0 ? " and cells of the other kind" : "", ", expected ", readings));
  }
  const auto place = [&](size_t i) { return Place(ReadingLine(header_entries, i), index, column.name); };
  for (size_t i = 0; i < column.texts.size(); ++i) {
    RETURN_IF_ERROR(base::Within(place(i), CheckName(rule, column.texts[i])));
  }
  for (size_t i = 0; i < column.values.size(); ++i) {
    const double number = column.values[i];
    if (!rule.Fits(number) && !(rule.may_be_empty && std::isnan(number))) {
      return absl::InvalidArgumentError(absl::StrFormat("%s: %g, expected %s", place(i), number, rule.expected));
    }
    if (rule.kind == ColumnKind::kTime && i > 0 && number < column.values[i - 1]) {
      return absl::InvalidArgumentError(absl::StrFormat("%s: %.12g, expected at least %.12g: time never runs back",
                                                        place(i), number, column.values[i - 1]));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Validate(const Session& session) {
  RETURN_IF_ERROR(ValidateHeader(session.header));
  std::vector<std::string> names;
  for (const Column& column : session.columns) names.push_back(column.name);
  ASSIGN_OR_RETURN(const std::vector<ColumnRule> rules, ColumnRules(session.header, names));
  const size_t readings = session.reading_count();
  if (readings == 0) return absl::InvalidArgumentError("no readings, expected at least one");
  for (size_t i = 0; i < rules.size(); ++i) {
    RETURN_IF_ERROR(ValidateColumn(session.columns[i], rules[i], i, session.header.size(), readings));
  }
  return absl::OkStatus();
}

}  // namespace axiscal::session
