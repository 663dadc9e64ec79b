#include "core/machine/error_symbol.h"

#include <cctype>

namespace axiscal::machine {
namespace {

constexpr char kLetters[] = "XYZABC";

bool IsJointName(const std::string& name) { return IsAxisName(name) || name == kToolName || name == kWorkName; }

}  // namespace

char Letter(Component component) { return kLetters[static_cast<int>(component)]; }

bool IsAxisName(const std::string& name) {
  if (name.empty() || name[0] < 'A' || name[0] > 'Z' || name == kToolName || name == kWorkName) return false;
  for (size_t i = 1; i < name.size(); ++i) {
    if (!std::isdigit(static_cast<unsigned char>(name[i]))) return false;
  }
  return true;
}

std::string ToString(const ErrorSymbol& symbol) {
  return std::string("E") + Letter(symbol.component) + (symbol.is_constant ? "0" : "") + symbol.axis;
}

absl::StatusOr<ErrorSymbol> ParseErrorSymbol(const std::string& text) {
  const absl::Status not_a_symbol =
      absl::InvalidArgumentError(absl::StrCat("'", text,
                                              "' is not an error symbol, expected E, a component X Y Z A B C, 0 for a "
                                              "constant error, and an axis (EX0C, EYX)"));
  // As reports name errors that have a shape.
  if (const size_t colon = text.find(':'); colon != std::string::npos) {
    return absl::InvalidArgumentError(absl::StrCat(
        "'", text, "' has a shape, expected a symbol alone (EX0C); an error of a shape is an entry of \"terms\" ",
        "of errors.json (--model of axiscal identify): {\"symbol\": \"", text.substr(0, colon), "\", \"shape\": ...}"));
  }
  size_t at = 0;
  // X0C and XOC leave the E out; E itself is no component.
  if (at < text.size() && text[at] == 'E') ++at;
  const bool has_e = at == 1;
  if (at >= text.size()) return not_a_symbol;
  const std::string letters(kLetters);
  const size_t component = letters.find(text[at]);
  if (component == std::string::npos) return not_a_symbol;
  ++at;
  ErrorSymbol symbol;
  symbol.component = static_cast<Component>(component);
  symbol.is_constant = at < text.size() && (text[at] == '0' || text[at] == 'O') && at + 1 < text.size() &&
                       !std::isdigit(static_cast<unsigned char>(text[at + 1]));
  if (!symbol.is_constant && !has_e) return not_a_symbol;
  symbol.axis = text.substr(at + (symbol.is_constant ? 1 : 0));
  if (!IsJointName(symbol.axis)) return not_a_symbol;
  return symbol;
}

}  // namespace axiscal::machine
