#include "core/nc/mark.h"

#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "core/base/units.h"

namespace axiscal::nc {
namespace {
constexpr char kMark[] = "AXISCAL COMPENSATED";
constexpr char kMachine[] = "AXISCAL MACHINE ";
constexpr size_t kMostListed = 20;  // of offsets, and of tools

std::string Comment(const Dialect& dialect, const std::string& text) {
  return dialect.has_parenthesis_comments ? "(" + text + ")" : std::string(1, dialect.line_comment) + text;
}

// Without an exponent; never -0.
std::string Number(double value) {
  std::string text = absl::StrFormat("%.4f", value);
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

// What may stand in a comment of any control.
std::string Plain(std::string text) {
  for (char& c : text) {
    const bool is_letter = (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    if (!is_letter && c != '.' && c != ' ' && c != '-') c = '_';
  }
  return text;
}

// " X-490 C90 MM DEG"
std::string AxisTexts(const machine::Machine& machine, const std::vector<AxisValue>& values) {
  std::string text;
  bool has_linear = false, has_rotary = false;
  for (const AxisValue& value : values) {
    const int axis = machine::FindAxis(machine, value.axis);
    const bool is_rotary = axis >= 0 && machine.axes[axis].kind == machine::AxisKind::kRotary;
    (is_rotary ? has_rotary : has_linear) = true;
    absl::StrAppend(&text, " ", value.axis, Number(is_rotary ? value.value * base::kDegPerRad : value.value));
  }
  return absl::StrCat(text, has_linear ? " MM" : "", has_rotary ? " DEG" : "");
}
}  // namespace

bool HasMark(const char* begin, const char* end) {
  while (begin != end && (*begin == ' ' || *begin == '\t')) ++begin;
  for (const char* expected = kMark; *expected != 0; ++expected, ++begin) {
    if (begin == end) return false;
    const char capital = *begin >= 'a' && *begin <= 'z' ? static_cast<char>(*begin - 'a' + 'A') : *begin;
    if (capital != *expected) return false;
  }
  return true;
}

std::string MarkComment(const Dialect& dialect, const std::string& calibration, uint32_t source_crc32c) {
  const std::string text = absl::StrFormat("%s BY %s SOURCE CRC32C %08X", kMark, calibration, source_crc32c);
  return Comment(dialect, text);
}

std::string HeadComments(const Dialect& dialect, const compensate::Compensator& compensator,
                         const RewriteOptions& options, uint32_t source_crc32c, const std::string& line_end) {
  std::string head = MarkComment(dialect, options.calibration, source_crc32c) + line_end;
  if (options.machine.empty()) return head;
  const machine::Machine& machine = compensator.machine();
  const auto add = [&](const std::string& text) { absl::StrAppend(&head, Comment(dialect, text), line_end); };
  const auto add_numbered = [&](const char* what, const auto& values, auto value_of) {
    size_t listed = 0;
    for (const auto& value : values) {
      if (++listed > kMostListed) return add(absl::StrCat("AXISCAL ", what, "S OF ", values.size(), " TOOLS"));
      add(absl::StrFormat("AXISCAL %s %s IS %s MM", what, ToolNumberText(value.number), Number(value_of(value))));
    }
  };
  add(absl::StrCat(kMachine, options.machine));
  if (!options.calibration_warns.empty()) {
    add("AXISCAL ITS CALIBRATION WARNS OF " + Plain(absl::StrJoin(options.calibration_warns, " ")) +
        " - READ ITS REPORT");
  }
  const auto& tip = options.tool_tip_mm;
  add(absl::StrFormat("AXISCAL TOOL POINT AT HOME %s %s %s MM", Number(tip.x()), Number(tip.y()), Number(tip.z())));
  size_t listed = 0;
  for (const WorkOffset& offset : options.work_offsets) {
    if (++listed > kMostListed) break;
    add("AXISCAL OFFSET " + Plain(offset.code) + AxisTexts(machine, offset.offsets));
  }
  if (listed > kMostListed) add(absl::StrCat("AXISCAL OFFSETS OF ", options.work_offsets.size()));
  add_numbered("TOOL LENGTH", options.tool_lengths, [](const ToolLength& tool) { return tool.length_mm; });
  // What is stated of no tool that cuts beside a contour says nothing: a table holds a radius of 0 for these.
  std::vector<ToolRadius> radii = options.tool_radii;
  std::erase_if(radii, [](const ToolRadius& tool) { return tool.radius_mm == 0; });
  add_numbered("TOOL RADIUS", radii, [](const ToolRadius& tool) { return tool.radius_mm; });
  if (!options.initial_position.empty()) add("AXISCAL START" + AxisTexts(machine, options.initial_position));
  if (!options.tool_change_keeps.empty())
    add("AXISCAL TOOL CHANGES LEAVE " + absl::StrJoin(options.tool_change_keeps, " "));
  const compensate::Options& when = compensator.options();
  if (when.time_s) add(absl::StrCat("AXISCAL TIME ", Number(*when.time_s), " S"));
  if (when.temperature_celsius) add(absl::StrCat("AXISCAL TEMPERATURE ", Number(*when.temperature_celsius), " DEG C"));
  add("AXISCAL ERROR TABLES AND VOLUMETRIC COMPENSATION OF THE CONTROL MUST BE OFF");
  return head;
}

std::string MarkedMachine(std::string_view program) {
  const size_t mark = program.find(kMark);
  if (mark == std::string_view::npos) return "";
  // Its line is the next one.
  const size_t line = program.find('\n', mark);
  if (line == std::string_view::npos) return "";
  const size_t begin = line + 1 + (line + 1 < program.size() && (program[line + 1] == '(' || program[line + 1] == ';'));
  if (program.substr(begin, sizeof(kMachine) - 1) != kMachine) return "";
  const std::string_view rest = program.substr(begin + sizeof(kMachine) - 1);
  return std::string(rest.substr(0, rest.find_first_of(")\r\n")));
}

}  // namespace axiscal::nc
