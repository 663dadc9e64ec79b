#include "core/nc/options.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/nc/dialect.h"

namespace axiscal::nc {
namespace {

constexpr int kMaxWordDecimals = 6;
constexpr size_t kMaxMachineLength = 100;  // as machine.json allows
constexpr size_t kMaxNameLength = 80;      // a mark must fit a block of the narrowest controllers

bool IsNameCharacter(unsigned char c) {
  return std::isalnum(c) || c == ' ' || c == '.' || c == '_' || c == '-' || c == '+' || c == ':' || c == '/';
}

bool IsToolNumber(int number) {
  return number >= 1 && number < kEdgesOfTool * kEdgesOfTool && number % kEdgesOfTool != 0;
}

absl::Status CheckDecimals(const std::string& field, int decimals) {
  if (decimals >= 0 && decimals <= kMaxWordDecimals) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(field, " = ", decimals, ", must be 0 to ", kMaxWordDecimals));
}

}  // namespace

std::string ToolNumberText(int number) {
  if (number < kEdgesOfTool) return absl::StrCat(number);
  return absl::StrCat("T", number / kEdgesOfTool, "D", number % kEdgesOfTool);
}

absl::Status Validate(const RewriteOptions& options) {
  if (FindDialect(options.dialect) == nullptr) {
    std::string names;
    for (const Dialect& dialect : Dialects()) absl::StrAppend(&names, names.empty() ? "" : ", ", dialect.name);
    return absl::InvalidArgumentError(absl::StrCat("dialect = '", options.dialect, "', must be one of: ", names));
  }
  RETURN_IF_ERROR(CheckDecimals("decimals_mm", options.decimals_mm));
  RETURN_IF_ERROR(CheckDecimals("decimals_inch", options.decimals_inch));
  if (!(options.max_correction_mm > 0)) {
    return absl::InvalidArgumentError(absl::StrCat("max_correction_mm = ", options.max_correction_mm, ", must be > 0"));
  }
  if (!(options.tolerance_mm > 0)) {
    return absl::InvalidArgumentError(absl::StrCat("tolerance_mm = ", options.tolerance_mm, ", must be > 0"));
  }
  if (!(options.cycle_tolerance_mm > 0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("cycle_tolerance_mm = ", options.cycle_tolerance_mm, ", must be > 0"));
  }
  if (!(options.cutter_tolerance_mm > 0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("cutter_tolerance_mm = ", options.cutter_tolerance_mm, ", must be > 0"));
  }
  if (!(options.max_rotary_correction_rad > 0 && options.max_rotary_correction_rad <= kMaxRotaryCorrectionRad)) {
    return absl::InvalidArgumentError(absl::StrCat("max_rotary_correction_rad = ", options.max_rotary_correction_rad,
                                                   ", must be > 0 and at most ", kMaxRotaryCorrectionRad));
  }
  if (!(options.tolerance_rad > 0)) {
    return absl::InvalidArgumentError(absl::StrCat("tolerance_rad = ", options.tolerance_rad, ", must be > 0"));
  }
  for (const ToolLength& length : options.tool_lengths) {
    const bool is_bad = !IsToolNumber(length.number) || !(std::abs(length.length_mm) <= 1e4);
    if (is_bad) {
      return absl::InvalidArgumentError(absl::StrCat(
          "tool_lengths: number ", length.number, " = ", length.length_mm,
          " mm, must be a number from 1 to 9999 (of one tool's D number T * 10000 + D) and at most 1e4 mm"));
    }
  }
  for (const ToolRadius& radius : options.tool_radii) {
    if (IsToolNumber(radius.number) && radius.radius_mm >= 0 && radius.radius_mm <= 1e3) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("tool_radii: number ", radius.number, " = ", radius.radius_mm,
                     " mm, must be a number from 1 to 9999 (of one tool's D number T * 10000 + D) and 0 to 1e3 mm"));
  }
  for (const int number : options.harmless_m) {
    if (number < 0 || number > kMaxHarmlessM)
      return absl::InvalidArgumentError(absl::StrCat("harmless_m: ", number, ", must be 0 to ", kMaxHarmlessM));
    if (10 * number >= kCodes) continue;
    const CodeMeaning& known = FindDialect(options.dialect)->m_codes[static_cast<size_t>(10 * number)];
    if (known.meaning == Meaning::kUnknown || known.meaning == Meaning::kHarmless) continue;
    return absl::InvalidArgumentError(absl::StrCat("harmless_m: M", number, " is known to dialect '", options.dialect,
                                                   "' (", known.text,
                                                   "), only M codes of the machine's builder may be "
                                                   "stated"));
  }
  if (options.calibration.empty() || options.calibration.size() > kMaxNameLength) {
    return absl::InvalidArgumentError(
        absl::StrCat("calibration: a name of 1 to ", kMaxNameLength, " characters is expected"));
  }
  const bool is_name = std::all_of(options.machine.begin(), options.machine.end(),
                                   [](char c) { return IsNameCharacter(static_cast<unsigned char>(c)); });
  if (!is_name || options.machine.size() > kMaxMachineLength) {
    return absl::InvalidArgumentError(absl::StrCat("machine = '", options.machine, "', must be at most ",
                                                   kMaxMachineLength, " letters, digits, blanks and \"._-+:/\""));
  }
  for (const char c : options.calibration) {
    if (IsNameCharacter(static_cast<unsigned char>(c))) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("calibration = '", options.calibration,
                     "', must be letters, digits, blanks and \"._-+:/\", because it stands in a comment"));
  }
  return absl::OkStatus();
}

}  // namespace axiscal::nc
