#include "core/compensate/tables/fanuc.h"

#include <algorithm>
#include <cmath>

#include "core/compensate/tables/text.h"

namespace axiscal::tables {
namespace {

// "(GRID 10803=5 10812=100.0000)", or nothing where it is a note for people.
std::optional<FanucNote> ParseNote(size_t line, const std::string& text) {
  const std::vector<std::string> words = Words(text.substr(1, text.size() - 2));
  if (words.size() < 2) return std::nullopt;
  FanucNote note{line, words[0], {}};
  for (size_t i = 1; i < words.size(); ++i) {
    const size_t equals = words[i].find('=');
    if (equals == std::string::npos || equals == 0) return std::nullopt;
    note.values[words[i].substr(0, equals)] = words[i].substr(equals + 1);
  }
  return note;
}

}  // namespace

absl::StatusOr<FanucFile> ReadFanucFile(const std::string& text) {
  FanucFile file;
  int percents = 0;
  const std::vector<std::string> lines = Lines(text);
  for (size_t i = 0; i < lines.size(); ++i) {
    const std::string line = Strip(lines[i]);
    if (line == "%") {
      if (++percents > 2) return BadLine(i + 1, line, "'%' before and behind the data only");
    } else if (percents == 1) {
      file.data.emplace_back(i + 1, line);
    } else if (!line.empty()) {
      if (percents == 0 || line.front() != '(' || line.back() != ')')
        return BadLine(i + 1, line, percents == 0 ? "'%'" : "a note in parentheses");
      if (std::optional<FanucNote> note = ParseNote(i + 1, line)) file.notes.push_back(*std::move(note));
    }
  }
  if (percents != 2) return BadLine(lines.size(), "", "'%' behind the data");
  return file;
}

absl::StatusOr<double> NumberIn(const FanucNote& note, const std::string& name) {
  const auto found = note.values.find(name);
  const std::optional<double> value = found == note.values.end() ? std::nullopt : ParseFixed(found->second);
  if (!value) return BadLine(note.line, note.key, name + "=NUMBER in the note");
  return *value;
}

absl::StatusOr<int> IntegerIn(const FanucNote& note, const std::string& name) {
  ASSIGN_OR_RETURN(const double value, NumberIn(note, name));
  if (value != std::round(value) || std::abs(value) > 1e6) return BadLine(note.line, note.key, name + "=WHOLE NUMBER");
  return static_cast<int>(value);
}

absl::StatusOr<std::vector<int>> ReadWords(size_t line, const std::string& text, const std::string& letters) {
  std::vector<int> numbers;
  size_t at = 0;
  for (const char letter : letters) {
    const size_t begin = at + 1;
    size_t end = begin;
    if (end < text.size() && text[end] == '-') ++end;
    const size_t digits = end;
    while (end < text.size() && text[end] >= '0' && text[end] <= '9') ++end;
    if (at >= text.size() || text[at] != letter || end == digits || end - digits > 6)
      return BadLine(line, text, letters + " with whole numbers");
    numbers.push_back(std::stoi(text.substr(begin, end - begin)));
    at = end;
  }
  if (at != text.size()) return BadLine(line, text, letters + " with whole numbers and nothing else");
  return numbers;
}

std::string FanucNoteText(const std::string& text) {
  std::string inner = text;
  std::replace(inner.begin(), inner.end(), '(', '[');
  std::replace(inner.begin(), inner.end(), ')', ']');
  return "(" + inner + ")\n";
}

}  // namespace axiscal::tables
