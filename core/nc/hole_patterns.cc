#include "core/nc/hole_patterns.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <string_view>

#include "core/base/units.h"
#include "core/nc/char_class.h"
#include "core/nc/line_splitter.h"
#include "core/nc/plain_number.h"

namespace axiscal::nc {
namespace {

constexpr char kPatternName[] = "HOLES";
constexpr size_t kArguments = 6;
constexpr int64_t kMostHoles = 10000;

// "N50 HOLES1(0,0,30,5,10,4)": where the name begins behind the block's number; nullptr: something else stands there.
const char* PatternNameIn(const char* text, const char* end) {
  while (text < end && Class(*text) == kBlank) ++text;
  if (text < end && Capital(*text) == 'N' && text + 1 < end && Class(text[1]) == kDigit) {
    for (++text; text < end && Class(*text) == kDigit;) ++text;
    while (text < end && Class(*text) == kBlank) ++text;
  }
  const size_t size = std::strlen(kPatternName);
  if (static_cast<size_t>(end - text) <= size) return nullptr;
  for (size_t i = 0; i < size; ++i) {
    if (Capital(text[i]) != kPatternName[i]) return nullptr;
  }
  return text;
}

// The arguments between the parentheses; `behind`: what follows them.
std::optional<std::vector<std::string_view>> PatternArguments(std::string_view text, std::string_view* behind) {
  text = WithoutBlanks(text);
  const size_t close = text.find(')');
  if (text.empty() || text.front() != '(' || close == std::string_view::npos) return std::nullopt;
  *behind = text.substr(close + 1);
  std::vector<std::string_view> parts;
  std::string_view rest = text.substr(1, close - 1);
  while (true) {
    const size_t end = std::min(rest.find(','), rest.size());
    parts.push_back(WithoutBlanks(rest.substr(0, end)));
    if (end == rest.size()) return parts;
    rest.remove_prefix(end + 1);
  }
}

// Why the cycle of MCALL cannot be followed at positions, or "".
std::string WhyNoPattern(const Interpreter& reader) {
  const Modal& modal = reader.modal();
  if (!modal.calls_at_moves) return "no MCALL of a cycle that is followed stands in front of it";
  if (reader.options().orientation) return "with --orientation modal calls of cycles are not followed";
  if (modal.uncertain != 0 || modal.blockers != 0) return "modal codes in force are not known, or not followed";
  if (modal.plane_normal != 2) return "in another plane than XY";
  if (modal.is_inch) return "in inch: its arguments may be in the machine's unit";
  if (modal.is_incremental) return "in G91";
  if (modal.motion != Meaning::kRapid && modal.motion != Meaning::kLinear) return "in G2 or G3";
  if (reader.AxisOf('X') < 0 || reader.AxisOf('Y') < 0) return "the machine has no axes X and Y";
  return "";
}

}  // namespace

bool MayBeHolePattern(const Dialect& dialect, const char* text, size_t size) {
  return dialect.has_equals && std::memchr(text, '(', size) != nullptr && PatternNameIn(text, text + size) != nullptr;
}

// 840D sl, Programming Manual Cycles: HOLES1 (SPCA, SPCO, STA1, FDIS, DBH, NUM), a row from a reference point on;
// HOLES2 (CPA, CPO, RAD, STA1, INDA, NUM), a circle, equally divided where INDA is 0.
HolePattern ReadHolePattern(const Interpreter& reader, const char* text, size_t size) {
  HolePattern pattern;
  const char* const end = text + TextSize(text, size);
  const char* const name = PatternNameIn(text, end);
  const char* const kind = name + std::strlen(kPatternName);
  if (*kind != '1' && *kind != '2') return pattern;
  const bool is_row = *kind == '1';
  const auto refuse = [&](const std::string& problem) {
    pattern.problem = absl::StrCat(kPatternName, std::string(1, *kind), ": ", problem);
    return pattern;
  };
  std::string_view behind;
  const auto parts = PatternArguments({kind + 1, static_cast<size_t>(end - kind - 1)}, &behind);
  behind = WithoutBlanks(behind);
  if (!parts || (!behind.empty() && behind.front() != ';')) return refuse("other words in its block");
  if (parts->size() < kArguments)
    return refuse(absl::StrCat("expected ", kArguments, " arguments, found ", parts->size()));
  std::array<Ticks, kArguments> values{};
  for (size_t i = 0; i < parts->size(); ++i) {
    const std::string_view part = (*parts)[i];
    // HOLES1(0,0,,5,10,4): an argument that is left out is 0.
    const std::optional<Ticks> value = part.empty() ? std::optional<Ticks>(0) : PlainTicks(part, kTicksPerMm);
    if (!value) return refuse(absl::StrCat("argument ", i + 1, " '", std::string(part), "' is no plain number"));
    if (i < kArguments) {
      values[i] = *value;
    } else if (*value != 0) {
      return refuse(
          absl::StrCat("argument ", i + 1, " '", std::string(part), "': expected ", kArguments, " arguments"));
    }
  }
  const Ticks number = values[5];
  const int64_t count = number / kTicksPerMm;
  if (number % kTicksPerMm != 0 || count < 1 || count > kMostHoles)
    return refuse(absl::StrCat("NUM = ", std::string((*parts)[5]), ": expected a whole number from 1 to ", kMostHoles));
  const auto value = [&](size_t index) { return static_cast<double>(values[index]) / kTicksPerUnit; };
  const size_t first_length = is_row ? 3 : 2;
  if (values[first_length] < 0 || (is_row ? values[4] < 0 : values[2] == 0))
    return refuse(is_row ? "FDIS and DBH have no sign" : "RAD must be above 0");
  if (const std::string problem = WhyNoPattern(reader); !problem.empty()) return refuse(problem);
  std::vector<std::array<Ticks, 2>> places;
  for (int64_t k = 0; k < count; ++k) {
    const auto step = static_cast<double>(k);
    const double indexed_deg = values[4] != 0 ? value(4) : 360.0 / static_cast<double>(count);
    const double angle = (is_row ? value(2) : value(3) + step * indexed_deg) * base::kRadPerDeg;
    const double along = is_row ? value(3) + step * value(4) : value(2);
    places.push_back({values[0] + std::llround(along * std::cos(angle) * kTicksPerUnit),
                      values[1] + std::llround(along * std::sin(angle) * kTicksPerUnit)});
  }
  // A row is drilled from its end that is nearer to where the tool stands; ticks.
  const int x = reader.AxisOf('X'), y = reader.AxisOf('Y');
  const Positions& at = reader.positions();
  const auto distance = [&](const std::array<Ticks, 2>& place) {
    return std::hypot(static_cast<double>(place[0] + reader.offset(x) - at.ticks[x]),
                      static_cast<double>(place[1] + reader.offset(y) - at.ticks[y]));
  };
  if (is_row && count > 1 && (!at.is_known(x) || !at.is_known(y)))
    return refuse("from which of its ends on is not known: it is not known where the tool stands in X and Y");
  if (is_row && distance(places.back()) < distance(places.front()) - 1.0) std::reverse(places.begin(), places.end());
  const int decimals = reader.options().decimals_mm;
  const std::string line_end(text + TextSize(text, size), text + size);
  const bool is_rapid = reader.modal().motion == Meaning::kRapid;
  for (const std::array<Ticks, 2>& place : places) {
    const bool is_first = pattern.lines.empty();
    std::string line = is_first ? std::string(text, name) : "";
    if (is_first && !is_rapid) line += "G0 ";
    absl::StrAppend(&line, "X", TicksText(place[0], kTicksPerMm, decimals), " Y",
                    TicksText(place[1], kTicksPerMm, decimals));
    if (is_first && !behind.empty()) absl::StrAppend(&line, " ", std::string(behind));
    pattern.lines.push_back(line + (line_end.empty() ? "\n" : line_end));
  }
  if (!is_rapid) pattern.lines.push_back("G1" + (line_end.empty() ? "\n" : line_end));
  if (line_end.empty()) pattern.lines.back().pop_back();
  return pattern;
}

}  // namespace axiscal::nc
