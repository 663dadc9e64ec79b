#include "tests/house/page.h"

#include <gtest/gtest.h>

#include <sstream>

#include "absl/strings/ascii.h"
#include "absl/strings/str_split.h"
#include "core/base/files.h"
#include "core/base/testing/source_path.h"

namespace axiscal::house {
namespace {

constexpr size_t kMaxBytes = 10 << 20;

// 2 of "## The map", 0 of a line that is no heading.
size_t LevelOf(const std::string& line) {
  const size_t level = line.find_first_not_of('#');
  return level != std::string::npos && line[level] == ' ' ? level : 0;
}

bool IsRuler(const std::string& line) { return line.find_first_not_of("|-: ") == std::string::npos; }

std::vector<std::string> CellsOf(const std::string& line) {
  std::vector<std::string> cells;
  for (const std::string& cell : std::vector<std::string>(absl::StrSplit(line, '|')))
    cells.push_back(std::string(absl::StripAsciiWhitespace(cell)));
  return {cells.begin() + 1, cells.end() - 1};
}

}  // namespace

std::string ReadPage(const std::string& path) {
  const absl::StatusOr<std::string> text = base::ReadFile(base::SourcePath("/" + path), kMaxBytes);
  if (text.ok()) return *text;
  ADD_FAILURE() << text.status();
  return "";
}

std::string Section(const std::string& page, const std::string& heading) {
  std::istringstream lines(page);
  std::string line, section;
  bool is_inside = false, is_code = false;
  while (std::getline(lines, line)) {
    if (line.rfind("```", 0) == 0) is_code = !is_code;
    const size_t level = is_code ? 0 : LevelOf(line);
    if (is_inside && level > 0 && level <= LevelOf(heading)) break;
    if (is_inside) section += line + "\n";
    if (line == heading) is_inside = true;
  }
  return section;
}

std::vector<std::vector<std::string>> TableRows(const std::string& text) {
  std::istringstream lines(text);
  std::string line;
  std::vector<std::vector<std::string>> rows;
  while (std::getline(lines, line)) {
    if (line.size() < 2 || line.front() != '|' || line.back() != '|') continue;
    if (IsRuler(line)) {
      if (!rows.empty()) rows.pop_back();  // the head above it
    } else {
      rows.push_back(CellsOf(line));
    }
  }
  return rows;
}

std::vector<std::string> Quoted(const std::string& text) {
  std::vector<std::string> quoted;
  for (size_t begin = text.find('`'); begin != std::string::npos;) {
    const size_t end = text.find('`', begin + 1);
    if (end == std::string::npos) break;
    quoted.push_back(text.substr(begin + 1, end - begin - 1));
    begin = text.find('`', end + 1);
  }
  return quoted;
}

}  // namespace axiscal::house
