#include "core/compensate/tables/siemens.h"

#include <cmath>

#include "core/compensate/tables/text.h"

namespace axiscal::tables {
namespace {

bool IsFrame(const std::string& line) {
  return line.empty() || line[0] == ';' || line[0] == '%' || line.rfind("CHANDATA(", 0) == 0 || line == "M17";
}

}  // namespace

absl::StatusOr<std::vector<Assignment>> ReadAssignments(const std::string& text) {
  std::vector<Assignment> assignments;
  const std::vector<std::string> lines = Lines(text);
  for (size_t i = 0; i < lines.size(); ++i) {
    const std::string line = Strip(lines[i]);
    if (IsFrame(line)) continue;
    const size_t open = line.find('['), close = line.find("]=");
    if (line[0] != '$' || open == std::string::npos || close == std::string::npos || close < open)
      return BadLine(i + 1, line, "$NAME[index]=value, a comment or M17");
    Assignment assignment{i + 1, line.substr(0, open), {}, Strip(line.substr(close + 2))};
    for (const std::string& index : Split(line.substr(open + 1, close - open - 1), ','))
      assignment.indices.push_back(Strip(index));
    assignments.push_back(std::move(assignment));
  }
  return assignments;
}

absl::StatusOr<double> NumberOf(const Assignment& assignment) {
  const std::optional<double> value = ParseFixed(assignment.value);
  if (!value) return BadLine(assignment.line, assignment.value, "a decimal number");
  return *value;
}

absl::StatusOr<int> IndexOf(const Assignment& assignment, size_t which) {
  const std::string text = which < assignment.indices.size() ? assignment.indices[which] : "";
  if (text.empty() || text.size() > 5 || text.find_first_not_of("0123456789") != std::string::npos)
    return BadLine(assignment.line, text, absl::StrCat("a whole number as index ", which + 1, " of ", assignment.name));
  return std::stoi(text);
}

absl::Status SiemensTable::SetValue(int n, const Assignment& assignment) {
  const auto number = static_cast<size_t>(n);
  if (values.size() <= number) values.resize(number + 1);
  line = assignment.line;
  return Set(&values[number], assignment);
}

absl::Status SiemensTable::Set(std::optional<double>* field, const Assignment& assignment) {
  if (field->has_value()) return BadLine(assignment.line, assignment.name, "every value once");
  ASSIGN_OR_RETURN(*field, NumberOf(assignment));
  return absl::OkStatus();
}

absl::StatusOr<std::vector<double>> SiemensTable::Nodes(const std::string& name) const {
  if (!min || !max || !step || !(*step > 0) || !(*max > *min))
    return absl::InvalidArgumentError(name + ": _MIN, _MAX above it and a _STEP above zero must be there");
  const double count = (*max - *min) / *step + 1.0;
  if (std::abs(count - std::round(count)) > 1e-6 || static_cast<size_t>(std::llround(count)) != values.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("line ", line, ": ", name, " has ", values.size(), " values, (MAX - MIN) / STEP + 1 = ", count));
  }
  for (size_t n = 0; n < values.size(); ++n) {
    if (!values[n]) return absl::InvalidArgumentError(absl::StrCat(name, ": value ", n, " is missing"));
  }
  return EqualNodes(*min, *step, values.size());
}

}  // namespace axiscal::tables
