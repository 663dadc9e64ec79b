// ISO 230-1 error symbols: a component of one axis' six-component error.
//   EXX position of X, EYX straightness of X in Y, EAX roll of X; EXC EYC EZC radial, axial, EAC EBC tilt, ECC position
//   With a 0 the constant part: location errors EX0C EY0C EA0C EB0C, squareness EC0Y EA0Z EB0Z.
// `T` (spindle and tool) and `W` (table ball) stand beside the axes. X0C, XOC and EXOC are read as EX0C.
#ifndef AXISCAL_CORE_MACHINE_ERROR_SYMBOL_H_
#define AXISCAL_CORE_MACHINE_ERROR_SYMBOL_H_

#include <compare>
#include <string>

#include "core/base/status.h"

namespace axiscal::machine {

// Rows of an error vector: EX EY EZ in mm, EA EB EC in rad. Never renumber: persisted by name, computed by number.
enum class Component { kX = 0, kY = 1, kZ = 2, kA = 3, kB = 4, kC = 5 };
inline constexpr int kComponents = 6;

inline bool IsAngle(Component component) { return component >= Component::kA; }
char Letter(Component component);

// Names of the two joints that are not axes.
inline constexpr char kToolName[] = "T";
inline constexpr char kWorkName[] = "W";

struct ErrorSymbol {
  Component component = Component::kX;
  std::string axis;       // an axis name (letter and optional digits), "T" or "W"
  bool is_constant = true;  // written with a 0: EX0C

  auto operator<=>(const ErrorSymbol&) const = default;
};

// "EX0C" (constant) or "EXC". Never fails.
std::string ToString(const ErrorSymbol& symbol);

// INVALID_ARGUMENT with the text and what was expected when `text` is no symbol. Does not know the machine's axes.
absl::StatusOr<ErrorSymbol> ParseErrorSymbol(const std::string& text);

// An axis name: one capital letter and optional digits, other than T and W: X, C2, J1.
bool IsAxisName(const std::string& name);

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_ERROR_SYMBOL_H_
