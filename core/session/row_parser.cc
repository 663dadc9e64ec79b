#include "core/session/row_parser.h"

#include <algorithm>
#include <charconv>

#include "core/session/text.h"

namespace axiscal::session {
namespace {

absl::Status RefuseLine(size_t line, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("line ", line, ": ", what));
}

std::string Trimmed(std::string_view text) {
  const size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return "";
  return std::string(text.substr(begin, text.find_last_not_of(" \t") + 1 - begin));
}

// "# key: value".
absl::StatusOr<HeaderEntry> ParseHeaderLine(const Line& line) {
  const std::string_view text = line.text.substr(1);
  const size_t colon = text.find(':');
  HeaderEntry entry;
  if (colon != std::string_view::npos) entry = {Trimmed(text.substr(0, colon)), Trimmed(text.substr(colon + 1))};
  if (entry.key.empty() || !IsPlainText(std::string(line.text))) {
    return RefuseLine(line.number, absl::StrCat(Quoted(std::string(line.text)), ", expected '# key: value' in UTF-8"));
  }
  return entry;
}

// The number that fills [at, end) up to a comma, and the place behind it; nullptr when there is none.
const char* ParseNumber(const char* at, const char* end, double* number) {
  if (at != end && *at == '+' && at + 1 != end && at[1] != '-') ++at;
  const auto [next, error] = std::from_chars(at, end, *number);
  if (error != std::errc() || (next != end && *next != ',')) return nullptr;
  return next;
}

}  // namespace

absl::Status CheckLineEnd(const Line& line) {
  if (line.has_line_end) return absl::OkStatus();
  return RefuseLine(
      line.number,
      absl::StrCat(Quoted(std::string(line.text)),
                   " is the last line and has no line end: the file may be cut short, expected a line feed"));
}

absl::StatusOr<std::vector<HeaderEntry>> ReadHeaderLines(LineReader& reader, Line* line) {
  std::vector<HeaderEntry> header;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, reader.Next(line));
    if (!more) {
      if (header.empty()) return absl::InvalidArgumentError("the file is empty, expected header lines '# key: value'");
      return RefuseLine(line->number + 1, "the file ends after its header lines, expected a line of column names");
    }
    RETURN_IF_ERROR(CheckLineEnd(*line));
    if (line->text.empty() || line->text[0] != '#') return header;
    if (header.size() >= kMaxHeaderEntries)
      return RefuseLine(line->number, absl::StrCat("more than ", kMaxHeaderEntries, " header lines"));
    ASSIGN_OR_RETURN(HeaderEntry entry, ParseHeaderLine(*line));
    header.push_back(std::move(entry));
  }
}

std::vector<std::string> SplitCells(std::string_view text) {
  std::vector<std::string> cells;
  for (size_t begin = 0;;) {
    const size_t comma = text.find(',', begin);
    cells.emplace_back(text.substr(begin, comma == std::string_view::npos ? comma : comma - begin));
    if (comma == std::string_view::npos) return cells;
    begin = comma + 1;
  }
}

// Fast path: appends the row. Anything unusual goes to Explain, which says what is wrong.
absl::Status RowParser::Add(const Line& line) {
  const char* at = line.text.data();
  const char* const end = at + line.text.size();
  for (size_t i = 0; i < rules_.size(); ++i) {
    if (i > 0 && (at == end || *at++ != ',')) return Explain(line);
    const ColumnRule& rule = rules_[i];
    if (rule.kind == ColumnKind::kName) {
      const char* const comma = std::find(at, end, ',');
      columns_[i].texts.emplace_back(at, comma);
      if (!CheckName(rule, columns_[i].texts.back()).ok()) return Explain(line);
      at = comma;
      continue;
    }
    double number = std::numeric_limits<double>::quiet_NaN();
    const bool empty = at == end || *at == ',';
    const char* const next = empty ? at : ParseNumber(at, end, &number);
    if (next == nullptr || !(empty ? rule.may_be_empty : rule.Fits(number))) return Explain(line);
    if (rule.kind == ColumnKind::kTime) {
      if (number < last_time_s_) return Explain(line);
      time_before_s_ = last_time_s_ = number;
    }
    columns_[i].values.push_back(number);
    at = next;
  }
  return at == end ? absl::OkStatus() : Explain(line);
}

absl::Status RowParser::Explain(const Line& line) const {
  const std::vector<std::string> cells = SplitCells(line.text);
  if (cells.size() != rules_.size()) {
    const bool more = cells.size() > rules_.size();
    const std::string place = more ? absl::StrCat("line ", line.number, ", column ", rules_.size() + 1)
                                   : Place(line.number, cells.size(), rules_[cells.size()].name);
    return absl::InvalidArgumentError(absl::StrCat(place, ": the line has ", cells.size(),
                                                   line.text.empty() ? " (empty) cell" : " cells", ", expected ",
                                                   rules_.size(), more ? " (is there a decimal comma?)" : ""));
  }
  for (size_t i = 0; i < cells.size(); ++i) {
    const std::string problem = Problem(rules_[i], cells[i]);
    if (!problem.empty())
      return absl::InvalidArgumentError(absl::StrCat(Place(line.number, i, rules_[i].name), ": ", problem));
  }
  return RefuseLine(line.number, "cannot be read");
}

std::string RowParser::Problem(const ColumnRule& rule, const std::string& cell) const {
  if (rule.kind == ColumnKind::kName) return std::string(CheckName(rule, cell).message());
  if (cell.empty()) return rule.may_be_empty ? "" : "is empty, expected " + rule.expected;
  double number = 0;
  const char* const end = cell.data() + cell.size();
  if (ParseNumber(cell.data(), end, &number) != end) {
    return absl::StrCat(Quoted(cell), " is no number, expected ", rule.expected, " with a decimal point and no blanks");
  }
  if (!rule.Fits(number)) return absl::StrCat(Quoted(cell), ", expected ", rule.expected);
  if (rule.kind == ColumnKind::kTime && number < time_before_s_) {
    return absl::StrFormat("%s, expected at least %.12g, the time of the line before: time never runs back",
                           Quoted(cell), time_before_s_);
  }
  return "";
}

}  // namespace axiscal::session
