#include "core/compensate/tables/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "core/base/units.h"

namespace axiscal::tables {

double FileUnit(const machine::Axis& axis) { return axis.kind == machine::AxisKind::kRotary ? base::kRadPerDeg : 1.0; }

std::string UnitName(const machine::Axis& axis) { return axis.kind == machine::AxisKind::kRotary ? "deg" : "mm"; }

double Round(double value, double step) { return std::round(value / step) * step; }

int DecimalsOf(double step) {
  int decimals = 0;
  double scaled = step;
  while (decimals < 12 && (scaled < 0.5 || std::abs(scaled - std::round(scaled)) > 1e-6)) {
    scaled *= 10.0;
    ++decimals;
  }
  return decimals;
}

std::string Fixed(double value, int decimals) {
  std::string text = absl::StrFormat("%.*f", decimals, value);
  // Not "-0.000": controllers and people read it as a sign.
  if (text[0] == '-' && text.find_first_not_of("-0.") == std::string::npos) text.erase(0, 1);
  return text;
}

std::optional<double> ParseFixed(const std::string& text) {
  const size_t begin = !text.empty() && (text[0] == '-' || text[0] == '+') ? 1 : 0;
  if (text.size() == begin || text.find_first_not_of("0123456789.", begin) != std::string::npos) return std::nullopt;
  const char* first = text.data() + (text[0] == '+' ? 1 : 0);
  double value = 0.0;
  const auto [end, error] = std::from_chars(first, text.data() + text.size(), value, std::chars_format::fixed);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    lines.push_back(line);
  }
  return lines;
}

std::vector<std::string> Words(const std::string& line) {
  std::vector<std::string> words;
  std::istringstream stream(line);
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::vector<std::string> Split(const std::string& line, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : line) {
    if (c == separator)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

std::string Strip(const std::string& text) {
  const size_t begin = text.find_first_not_of(" \t"), end = text.find_last_not_of(" \t");
  return begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
}

absl::Status BadLine(size_t line, const std::string& text, const std::string& expected) {
  std::string shown = text.substr(0, 60);
  std::replace_if(
      shown.begin(), shown.end(), [](unsigned char c) { return c < 32 || c > 126; }, '?');
  return absl::InvalidArgumentError(absl::StrCat("line ", line, ": '", shown, "', expected ", expected));
}

absl::StatusOr<int> AxisNamed(const machine::Machine& machine, const std::string& name, size_t line) {
  const int axis = machine::FindAxis(machine, name);
  if (axis < 0) return BadLine(line, name, "an axis of machine '" + machine.id + "'");
  return axis;
}

absl::Status CheckIncreasing(const std::vector<double>& nodes, double position, size_t line) {
  if (nodes.empty() || position > nodes.back()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("line ", line, ": positions must increase"));
}

std::vector<double> EqualNodes(double start, double step, size_t count) {
  std::vector<double> nodes;
  for (size_t k = 0; k < count; ++k) nodes.push_back(start + static_cast<double>(k) * step);
  return nodes;
}

}  // namespace axiscal::tables
