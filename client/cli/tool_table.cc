#include "client/cli/tool_table.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <sstream>

#include "core/session/text.h"

namespace axiscal::cli {
namespace {

constexpr double kMmPerInch = 25.4;
constexpr int kMostNumber = 9999;
constexpr int kAnyTool = 0;  // of tables whose numbers are of no tool

std::string Upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

std::optional<double> NumberOf(const std::string& text) {
  std::vector<double> numbers;
  if (text.empty() || !session::ParseNumbers(text, &numbers) || numbers.size() != 1) return std::nullopt;
  return numbers[0];
}

// The text of a line without what stands in comments.
std::string WithoutComment(const std::string& line) {
  std::string text;
  int depth = 0;
  for (const char c : line) {
    if (c == ';') break;
    depth += c == '(';
    if (depth == 0) text += c;
    depth -= c == ')' && depth > 0;
  }
  return Upper(text);
}

// "G10 L10 P5 R120.5": letters with their numbers. False: it is no such line.
bool ReadWords(const std::string& line, std::map<char, std::vector<double>>* words) {
  words->clear();
  for (size_t at = 0; at < line.size();) {
    const char letter = line[at];
    if (std::isspace(static_cast<unsigned char>(letter))) {
      ++at;
      continue;
    }
    size_t end = at + 1;
    while (end < line.size() && (std::isdigit(static_cast<unsigned char>(line[end])) || line[end] == '.' ||
                                 ((line[end] == '-' || line[end] == '+') && end == at + 1)))
      ++end;
    const std::string digits = line.substr(at + 1, end - at - 1);
    const std::optional<double> number = NumberOf(!digits.empty() && digits[0] == '+' ? digits.substr(1) : digits);
    if (!std::isalpha(static_cast<unsigned char>(letter)) || !number) return false;
    (*words)[letter].push_back(*number);
    at = end;
  }
  return !words->empty();
}

// Numbers of one kind.
class Values {
 public:
  explicit Values(const std::string& path) : path_(path) {}

  absl::Status Error(int line, const std::string& what) const {
    return absl::InvalidArgumentError(absl::StrCat("--tool-table: ", path_, ", line ", line, ": ", what));
  }
  // Length and wear add up; `part` tells them apart, `tool_number` the tools that have this number.
  absl::Status Add(int line, double number, double value_mm, int part, double tool_number) {
    if (tool_number != std::floor(tool_number) || tool_number < kAnyTool || tool_number > kMostNumber)
      return Error(line, absl::StrCat("tool ", tool_number, ", expected a whole number from 1 to ", kMostNumber));
    const int tool = static_cast<int>(tool_number);
    if (number != std::floor(number) || number < 1 || number > kMostNumber)
      return Error(line, absl::StrCat("number ", number, ", expected a whole one from 1 to ", kMostNumber));
    Parts& parts = parts_[static_cast<int>(number)];
    const auto known = parts.find({tool, part});
    if (known != parts.end()) return Error(line, absl::StrCat("number ", number, " stands there twice"));
    parts[{tool, part}] = value_mm;
    return absl::OkStatus();
  }
  // By number, in its order. `beside`: the other kind of value of the same tools.
  std::map<int, double> Sums(const Values& beside) const {
    std::map<int, double> sums;
    for (const auto& [number, parts] : parts_) {
      std::map<int, double> of_tool;
      for (const auto& [key, value_mm] : parts) of_tool[key.first] += value_mm;
      // A number of one tool, or of several with the same value, needs no tool to be known.
      const double first_mm = of_tool.begin()->second;
      const auto is_first = [first_mm](const auto& one) { return one.second == first_mm; };
      const auto has_value = [&of_tool](int tool) { return of_tool.contains(tool); };
      const std::set<int> tools = beside.ToolsOf(number);
      if (std::all_of(of_tool.begin(), of_tool.end(), is_first) && std::all_of(tools.begin(), tools.end(), has_value))
        sums[number] = first_mm;
      for (const auto& [tool, value_mm] : of_tool) {
        if (tool != kAnyTool) sums[nc::NumberOfEdge(tool, number)] = value_mm;
      }
    }
    return sums;
  }
  bool is_empty() const { return parts_.empty(); }
  // Tools that have this number.
  std::set<int> ToolsOf(int number) const {
    std::set<int> tools;
    const auto found = parts_.find(number);
    if (found == parts_.end()) return tools;
    for (const auto& [key, value_mm] : found->second) {
      if (key.first != kAnyTool) tools.insert(key.first);
    }
    return tools;
  }

 private:
  using Parts = std::map<std::pair<int, int>, double>;
  const std::string path_;
  std::map<int, Parts> parts_;
};

struct Tables {
  Values lengths, radii;
};

// "$TC_DP3[5,1]=120.5": length 1; $TC_DP12 is its wear. $TC_DP6 and $TC_DP15 are those of the radius.
absl::Status AddSinumerik(const std::string& line, int number, Tables* tables) {
  const struct {
    std::string name;
    int part;
    Values* values;
  } kinds[] = {{"$TC_DP3[", 0, &tables->lengths},
               {"$TC_DP12[", 1, &tables->lengths},
               {"$TC_DP6[", 0, &tables->radii},
               {"$TC_DP15[", 1, &tables->radii}};
  for (const auto& [name, part, values] : kinds) {
    if (line.compare(0, name.size(), name) != 0) continue;
    const size_t comma = line.find(','), close = line.find(']'), equals = line.find('=');
    if (comma == std::string::npos || close == std::string::npos || equals == std::string::npos || comma > close ||
        close > equals)
      return values->Error(number, absl::StrCat("expected ", name, "T,D]=NUMBER"));
    const auto tool = NumberOf(line.substr(name.size(), comma - name.size()));
    const auto edge = NumberOf(line.substr(comma + 1, close - comma - 1));
    const auto value = NumberOf(line.substr(equals + 1));
    if (!tool || !edge || !value)
      return values->Error(number, absl::StrCat("expected plain numbers: ", name, "5,1]=120.5"));
    return values->Add(number, *edge, *value, part, *tool);
  }
  return absl::OkStatus();
}

// Where a column begins and ends, by the line of names.
struct Column {
  size_t begin = std::string::npos, end = std::string::npos;

  std::string Of(const std::string& line) const {
    if (begin == std::string::npos || begin >= line.size()) return "";
    std::string text = line.substr(begin, end == std::string::npos ? end : end - begin);
    const size_t first = text.find_first_not_of(" \t\r"), last = text.find_last_not_of(" \t\r");
    return first == std::string::npos ? "" : text.substr(first, last - first + 1);
  }
};

Column FindColumn(const std::string& names, const std::string& name) {
  Column column;
  for (size_t at = 0; at < names.size();) {
    const size_t begin = names.find_first_not_of(" \t\r", at);
    if (begin == std::string::npos) break;
    const size_t end = std::min(names.find_first_of(" \t\r", begin), names.size());
    const size_t next = names.find_first_not_of(" \t\r", end);
    if (names.substr(begin, end - begin) == name) {
      column.begin = begin;
      column.end = next;
      return column;
    }
    at = end;
  }
  return column;
}

// "+1.5", "1.5".
std::optional<double> SignedOf(const std::string& text) {
  return NumberOf(!text.empty() && text[0] == '+' ? text.substr(1) : text);
}

absl::Status AddHeidenhain(const std::string& line, const std::string& names, double unit_mm, int number,
                           Tables* tables) {
  const std::string tool = FindColumn(names, "T").Of(line);
  const struct {
    const char* name;
    int part;
    Values* values;
  } columns[] = {
      {"L", 0, &tables->lengths}, {"DL", 1, &tables->lengths}, {"R", 0, &tables->radii}, {"DR", 1, &tables->radii}};
  if (tool.empty() || FindColumn(names, "L").Of(line).empty()) return absl::OkStatus();
  const auto number_of_tool = NumberOf(tool);
  for (const auto& [name, part, values] : columns) {
    const std::string text = FindColumn(names, name).Of(line);
    if (text.empty()) continue;
    const auto value = SignedOf(text);
    if (!number_of_tool || !value)
      return values->Error(number, absl::StrCat("T = '", tool, "', ", name, " = '", text, "', expected numbers"));
    if (*number_of_tool == 0) return absl::OkStatus();
    RETURN_IF_ERROR(values->Add(number, *number_of_tool, *value * unit_mm, part, 0));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ToolTable> ParseToolTable(const std::string& text, const std::string& path) {
  Tables tables{Values(path), Values(path)};
  Values& lengths = tables.lengths;
  std::istringstream lines(text);
  std::string names;
  bool is_heidenhain = false;
  double unit_mm = 1.0;
  int number = 0;
  std::map<char, std::vector<double>> words;
  const auto one = [&](char letter) { return words.count(letter) == 1 && words[letter].size() == 1; };
  for (std::string source; std::getline(lines, source);) {
    ++number;
    const std::string line = is_heidenhain ? Upper(source) : WithoutComment(source);
    if (line.compare(0, 10, "BEGIN TOOL") == 0 || line.compare(0, 5, "BEGIN") == 0) {
      is_heidenhain = true;
      if (line.find("INCH") != std::string::npos) unit_mm = kMmPerInch;
      continue;
    }
    if (is_heidenhain) {
      if (line.find("[END]") != std::string::npos || line.compare(0, 3, "END") == 0) break;
      if (names.empty()) {
        names = line;
        if (FindColumn(names, "T").begin == std::string::npos || FindColumn(names, "L").begin == std::string::npos)
          return lengths.Error(number, "expected the names of the columns, T and L among them");
        continue;
      }
      RETURN_IF_ERROR(AddHeidenhain(line, names, unit_mm, number, &tables));
      continue;
    }
    if (line.compare(0, 4, "$TC_") == 0) {
      RETURN_IF_ERROR(AddSinumerik(line, number, &tables));
      continue;
    }
    if (!ReadWords(line, &words)) continue;
    const auto has_g = [&](double code) {
      return words.count('G') == 1 && std::find(words['G'].begin(), words['G'].end(), code) != words['G'].end();
    };
    if (has_g(20)) unit_mm = kMmPerInch;
    if (has_g(10)) {
      const double kind = one('L') ? words['L'][0] : 0;
      if (kind < 10 || kind > 13) continue;
      if (!one('P') || !one('R') || has_g(91))
        return lengths.Error(number, "expected G10 L10 P5 R120.5 with one P and one R, in G90");
      Values& values = kind < 12 ? lengths : tables.radii;
      RETURN_IF_ERROR(values.Add(number, words['P'][0], words['R'][0] * unit_mm, kind == 11 || kind == 13, 0));
    } else if (one('T') && (one('P') || one('Z')) && words.count('G') == 0 && words.count('M') == 0) {
      RETURN_IF_ERROR(lengths.Add(number, words['T'][0], one('Z') ? words['Z'][0] * unit_mm : 0.0, 0, 0));
      if (one('D')) RETURN_IF_ERROR(tables.radii.Add(number, words['T'][0], 0.5 * words['D'][0] * unit_mm, 0, 0));
    }
  }
  if (!lengths.is_empty() || !tables.radii.is_empty()) {
    ToolTable tools;
    for (const auto& [known, length_mm] : lengths.Sums(tables.radii)) {
      if (length_mm != 0) tools.lengths.push_back({known, length_mm});
    }
    for (const auto& [known, radius_mm] : tables.radii.Sums(lengths)) tools.radii.push_back({known, radius_mm});
    return tools;
  }
  return absl::InvalidArgumentError(
      absl::StrCat("--tool-table: ", path,
                   " holds no tool: expected lines of LinuxCNC (T5 P5 Z120.5), Fanuc (G10 L10 "
                   "P5 R120.5), Sinumerik ($TC_DP3[5,1]=120.5) or Heidenhain (TOOL.T)"));
}

}  // namespace axiscal::cli
