#include "core/sheet/error_words.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/sheet/iso_words.h"

namespace axiscal::sheet {
namespace {

using machine::Axis;
using machine::AxisKind;
using machine::ErrorSymbol;
using machine::Machine;

// The direction that ISO 841 gives the letter.
bool IsWhatItsLetterSays(const Axis& axis) {
  constexpr char kLinear[] = "XYZ", kBeside[] = "UVW", kRotary[] = "ABC";
  constexpr double kNear = 0.7;  // swivel axes of 45 deg have the letter of either direction
  for (int i = 0; i < 3; ++i) {
    const bool is_linear = axis.name[0] == kLinear[i] || axis.name[0] == kBeside[i];
    if (!is_linear && axis.name[0] != kRotary[i]) continue;
    return is_linear == (axis.kind == AxisKind::kLinear) && std::abs(axis.direction[i]) > kNear;
  }
  return false;
}

// "3" of J3; Q of an axis without a number.
std::string NumberOf(const Axis& axis) { return axis.name.size() > 1 ? axis.name.substr(1) : axis.name; }

// The axis that carries this one; none carries the first of its branch.
const Axis* CarrierOf(const Machine& machine, int axis) {
  for (const std::vector<int>* branch : {&machine.tool_branch, &machine.work_branch}) {
    const auto at = std::find(branch->begin(), branch->end(), axis);
    if (at != branch->end()) return at == branch->begin() ? nullptr : &machine.axes[static_cast<size_t>(*(at - 1))];
  }
  return nullptr;
}

class JointWords {
 public:
  JointWords(const Machine& machine, const ErrorSymbol& symbol, Language language)
      : machine_(machine),
        symbol_(symbol),
        component_(static_cast<int>(symbol.component) % 3),
        is_angle_(machine::IsAngle(symbol.component)),
        along_(1, "XYZ"[component_]),
        language_(language) {}

  std::string Write() const {
    if (symbol_.axis == machine::kToolName) return Say("tool: ", "Werkzeug: ") + OfEnd();
    if (symbol_.axis == machine::kWorkName) return Say("workpiece: ", "Werkstück: ") + OfEnd();
    const int index = machine::FindAxis(machine_, symbol_.axis);
    if (index < 0) return "";
    const Axis& axis = machine_.axes[static_cast<size_t>(index)];
    const std::string joint = Say("joint ", "Gelenk ") + NumberOf(axis) + ": ";
    return symbol_.is_constant ? OfPlace(axis, CarrierOf(machine_, index), joint) : joint + OfMotion(axis);
  }

 private:
  std::string Say(const char* english, const char* german) const {
    return language_ == Language::kGerman ? german : english;
  }

  // The share of a joint's direction that the component has.
  double Share(const Axis& axis) const { return std::abs(axis.direction[component_]); }

  std::string OfEnd() const {
    if (!symbol_.is_constant) return Say("motion ", "Bewegung ") + Where();
    return is_angle_ ? Say("turned around ", "Verdrehung um ") + along_
                     : Say("offset along ", "Versatz entlang ") + along_;
  }
  std::string Where() const { return (is_angle_ ? Say("around ", "um ") : Say("along ", "entlang ")) + along_; }

  std::string OfPlace(const Axis& axis, const Axis* carrier, const std::string& joint) const {
    constexpr double kAlong = 0.99, kAcross = 0.01;
    const bool is_own_kind = is_angle_ == (axis.kind == AxisKind::kRotary);
    if (is_own_kind && Share(axis) > kAlong) return joint + Say("zero offset", "Nullpunktversatz");
    if (is_angle_) {
      return joint +
             (Share(axis) < kAcross ? Say("tilt of its axis around ", "Neigung seiner Achse um ")
                                    : Say("turned around ", "Verdrehung um ")) +
             along_;
    }
    if (carrier == nullptr) return joint + Say("place along ", "Lage entlang ") + along_;
    // The link is as long as the place of a joint is from that of the one before it: most along one direction.
    const Eigen::Vector3d link_mm = axis.point_mm - carrier->point_mm;
    constexpr double kMost = 0.7;
    const bool is_length = std::abs(link_mm[component_]) > kMost * link_mm.norm();
    return Say("link between joints ", "Glied zwischen Gelenk ") + NumberOf(*carrier) + Say(" and ", " und ") +
           NumberOf(axis) +
           (is_length ? Say(": length along ", ": Länge entlang ") : Say(": offset along ", ": Versatz entlang ")) +
           along_;
  }

  std::string OfMotion(const Axis& axis) const {
    constexpr double kAlong = 0.7;
    const bool is_own = Share(axis) > kAlong, is_rotary = axis.kind == AxisKind::kRotary;
    if (is_angle_ == is_rotary && is_own) return Say("positioning error", "Positionierabweichung");
    if (is_angle_) return Say("tilt as it moves around ", "Neigung beim Bewegen um ") + along_;
    if (!is_rotary) return Say("straightness along ", "Geradheit entlang ") + along_;
    return (is_own ? Say("axial run-out along ", "Planlauf entlang ") : Say("run-out along ", "Rundlauf entlang ")) +
           along_;
  }

  const Machine& machine_;
  const ErrorSymbol& symbol_;
  const int component_;
  const bool is_angle_;
  const std::string along_;
  const Language language_;
};

}  // namespace

bool IsArm(const Machine& machine) {
  const auto others = std::count_if(machine.axes.begin(), machine.axes.end(),
                                    [](const Axis& axis) { return !IsWhatItsLetterSays(axis); });
  return 2 * others > machine.axis_count();
}

std::string ErrorWords(const std::string& text, const std::optional<Machine>& machine, Language language) {
  const absl::StatusOr<ErrorSymbol> symbol = machine::ParseErrorSymbol(text);
  if (!symbol.ok() || !machine || !IsArm(*machine)) return IsoWords(text, language);
  return JointWords(*machine, *symbol, language).Write();
}

std::string PartWords(const std::string& part, Language language) {
  constexpr std::pair<const char*, const char*> kGerman[] = {
      {"acceleration", "Beschleunigung"},
      {"backlash", "Umkehrspanne"},
      {"backlash-curve", "Umkehrspanne als Kurve"},
      {"crossed", "gekreuzt"},
      {"curve", "Kurve"},
      {"drift", "Drift"},
      {"drift-exp", "Drift, abklingend"},
      {"empirical", "empirisch"},
      {"harmonic", "Harmonische"},
      {"lag", "Nachlauf"},
      {"last-move", "nach der letzten Bewegung"},
      {"linear", "linear"},
      {"lobe", "Wellen"},
      {"play", "Spiel"},
      {"pre-travel", "Schaltweg"},
      {"quadratic", "quadratisch"},
      {"reversal", "Umkehr"},
      {"tabulated", "Tabelle"},
      {"thermal", "thermisch"},
      {"thermal-lag", "thermisch, verzögert"},
      {"time-curve", "Kurve über der Zeit"},
  };
  const size_t end = std::min(part.find_first_of("(.#"), part.size());
  for (const auto& [english, german] : kGerman)
    if (language == Language::kGerman && part.substr(0, end) == english) return german + part.substr(end);
  return part;
}

}  // namespace axiscal::sheet
