#include "core/sheet/iso_words.h"

#include "core/machine/error_symbol.h"

namespace axiscal::sheet {
namespace {

using machine::Component;
using machine::ErrorSymbol;

enum class Joint { kLinear, kRotary, kTool, kWork, kOther };

Joint JointOf(const std::string& axis) {
  if (axis == machine::kToolName) return Joint::kTool;
  if (axis == machine::kWorkName) return Joint::kWork;
  switch (axis[0]) {
    case 'X':
    case 'Y':
    case 'Z':
    case 'U':
    case 'V':
      return Joint::kLinear;
    case 'A':
    case 'B':
    case 'C':
      return Joint::kRotary;
    default:
      return Joint::kOther;
  }
}

// 0 to 2: along or about x, y, z.
int DirectionOf(char letter) {
  switch (letter) {
    case 'X':
    case 'U':
    case 'A':
      return 0;
    case 'Y':
    case 'V':
    case 'B':
      return 1;
    default:
      return 2;
  }
}

// English, German; %1: the axis, %2: the direction of the component, %3: the axis that is square to both.
struct Words {
  const char* english;
  const char* german;
};

Words WordsOf(const ErrorSymbol& symbol) {
  const bool is_angle = machine::IsAngle(symbol.component);
  const Joint joint = JointOf(symbol.axis);
  if (joint == Joint::kTool) {
    return is_angle ? Words{"tilt of spindle and tool around %2", "Neigung von Spindel und Werkzeug um %2"}
                    : Words{"offset of spindle and tool in %2", "Versatz von Spindel und Werkzeug in %2"};
  }
  if (joint == Joint::kWork) {
    return is_angle ? Words{"tilt of what the table carries around %2", "Neigung auf dem Tisch um %2"}
                    : Words{"offset of the table ball in %2", "Versatz der Tischkugel in %2"};
  }
  if (joint == Joint::kOther)
    return is_angle ? Words{"error of %1 around %2", "Abweichung von %1 um %2"}
                    : Words{"error of %1 in %2", "Abweichung von %1 in %2"};
  const bool is_own = static_cast<int>(symbol.component) % 3 == DirectionOf(symbol.axis[0]);
  const bool is_linear = joint == Joint::kLinear;
  if (symbol.is_constant) {
    if (is_angle && !is_own) return {"squareness error of %1 to %3", "Rechtwinkligkeitsabweichung von %1 zu %3"};
    if (is_own && is_angle != is_linear) return {"zero position error of %1", "Nullpunktabweichung von %1"};
    if (is_angle) return {"roll of %1, constant part", "Rollabweichung von %1, fester Anteil"};
    return {"position error of %1 in %2", "Lageabweichung von %1 in %2"};
  }
  if (is_linear) {
    if (is_angle) {
      return is_own ? Words{"roll error motion of %1", "Rollabweichung von %1"}
                    : Words{"angular error motion of %1 around %2", "Winkelabweichung von %1 um %2"};
    }
    return is_own ? Words{"positioning error of %1", "Positionierabweichung von %1"}
                  : Words{"straightness error motion of %1 in %2", "Geradheitsabweichung von %1 in %2"};
  }
  if (is_angle) {
    return is_own ? Words{"angular positioning error of %1", "Winkelpositionierabweichung von %1"}
                  : Words{"tilt error motion of %1 around %2", "Taumelabweichung von %1 um %2"};
  }
  return is_own ? Words{"axial error motion of %1", "Axialabweichung von %1"}
                : Words{"radial error motion of %1 in %2", "Radialabweichung von %1 in %2"};
}

}  // namespace

std::string IsoWords(const std::string& text, Language language) {
  const absl::StatusOr<ErrorSymbol> symbol = machine::ParseErrorSymbol(text);
  if (!symbol.ok()) return "";
  constexpr char kAlong[] = "XYZ";
  const int component = static_cast<int>(symbol->component) % 3, own = DirectionOf(symbol->axis[0]);
  const Words words = WordsOf(*symbol);
  std::string said;
  for (const char* c = language == Language::kGerman ? words.german : words.english; *c != '\0'; ++c) {
    if (*c != '%') {
      said += *c;
      continue;
    }
    ++c;
    if (*c == '1') {
      said += symbol->axis;
    } else {
      said += kAlong[*c == '2' ? component : 3 - component - own];
    }
  }
  return said;
}

}  // namespace axiscal::sheet
