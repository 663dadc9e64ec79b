#include "core/machine/error_model.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/base/demand.h"
#include "core/base/units.h"
#include "core/shapes/depends_on.h"

namespace axiscal::machine {
namespace {

// "45" for an order per turn, "10mm" for a period along a linear axis.
std::string FrequencyText(const Machine& machine, const shapes::Harmonic& harmonic) {
  if (machine.axes[harmonic.axis].kind == AxisKind::kRotary) return absl::StrFormat("%g", harmonic.frequency);
  return absl::StrFormat("%gmm", 2.0 * std::numbers::pi / harmonic.frequency);
}

// "60" for a node at 60 deg, "60,A -30" in a map over A too.
std::string NodeText(const Machine& machine, const shapes::Tabulated& map) {
  const auto position = [&](int axis, double at) {
    return absl::StrFormat("%.6g", machine.axes[axis].kind == AxisKind::kRotary ? at * base::kDegPerRad : at);
  };
  const std::string text = position(map.axis, map.node.at);
  if (map.second_axis < 0) return text;
  return absl::StrCat(text, ",", machine.axes[map.second_axis].name, " ", position(map.second_axis, map.second.at));
}

}  // namespace

ErrorTerm ConstantTerm(const Machine& machine, const ErrorSymbol& symbol, double amplitude) {
  ErrorTerm term;
  term.joint = FindJoint(machine, symbol.axis);
  DEMAND(term.joint >= 0);
  term.component = symbol.component;
  term.amplitude[0] = amplitude;
  return term;
}

ErrorTerm AlongApproachTerm(const Machine& machine, const shapes::Shape& shape) {
  return {machine.tool_joint(), Component::kX, shape, {}};
}

shapes::Times TimesPositionOf(const Machine& machine, int axis) {
  const bool is_rotary = machine.axes[axis].kind == AxisKind::kRotary;
  return {axis, is_rotary ? shapes::Times::kReferenceRad : shapes::Times::kReferenceMm};
}

Component PositioningOf(const Machine& machine, int axis) {
  int along = 0;
  machine.axes[axis].direction.cwiseAbs().maxCoeff(&along);
  return static_cast<Component>(along + (machine.axes[axis].kind == AxisKind::kRotary ? 3 : 0));
}

ErrorModel DeclaredModel(const Machine& machine) {
  ErrorModel model;
  for (const ErrorSymbol& symbol : machine.declared) model.terms.push_back(ConstantTerm(machine, symbol));
  return model;
}

bool HasName(const ErrorTerm& term) { return !std::holds_alternative<shapes::Bump>(term.shape); }

ErrorModel NamedErrors(ErrorModel model) {
  std::erase_if(model.terms, [](const ErrorTerm& term) { return !HasName(term); });
  return model;
}

std::string SymbolOf(const Machine& machine, const ErrorTerm& term) {
  if (shapes::IsAlongApproach(term.shape)) return kAlongApproachSymbol;
  const bool is_constant = std::holds_alternative<shapes::Constant>(term.shape);
  return ToString({term.component, JointName(machine, term.joint), is_constant});
}

std::string NameOf(const Machine& machine, const ErrorTerm& term) {
  if (std::holds_alternative<shapes::Constant>(term.shape)) return SymbolOf(machine, term);
  std::string arguments;
  if (const auto* harmonic = std::get_if<shapes::Harmonic>(&term.shape)) arguments = FrequencyText(machine, *harmonic);
  if (const auto* map = std::get_if<shapes::Tabulated>(&term.shape)) arguments = NodeText(machine, *map);
  if (const auto* lobe = std::get_if<shapes::Lobe>(&term.shape)) arguments = absl::StrCat(lobe->order);
  if (const auto* lag = std::get_if<shapes::ThermalLag>(&term.shape)) arguments = lag->channel;
  if (const auto* crossed = std::get_if<shapes::Crossed>(&term.shape))
    arguments = machine.axes[crossed->second_axis].name;
  const std::optional<int> axis = shapes::VariableAxis(term.shape);
  const bool is_named = shapes::TimesOf(term.shape) != nullptr;
  if (axis && (*axis != term.joint || is_named)) {
    arguments = machine.axes[*axis].name + (arguments.empty() ? "" : "," + arguments);
  }
  return absl::StrCat(SymbolOf(machine, term), ":", shapes::Name(term.shape),
                      arguments.empty() ? "" : "(" + arguments + ")");
}

std::vector<std::string> NamesOf(const Machine& machine, const ErrorModel& model) {
  std::vector<std::string> names;
  std::map<std::string, int> count;
  for (const ErrorTerm& term : model.terms) {
    std::string name = NameOf(machine, term);
    const int which = ++count[name];
    if (which > 1) absl::StrAppend(&name, "#", which);
    names.push_back(std::move(name));
  }
  return names;
}

double UnknownAt(const ErrorTerm& term, const shapes::State& state) {
  if (const auto* lag = std::get_if<shapes::ThermalLag>(&term.shape))
    return std::abs(term.amplitude[0] * lag->times.FactorAt(state)) * lag->BeyondSeen(state);
  if (const auto* drift = std::get_if<shapes::Drift>(&term.shape))
    return std::abs(term.amplitude[0]) * drift->BeyondSeen(state) / shapes::Drift::kReferenceS;
  const double kept = shapes::KeptAt(term.shape, state);
  if (kept >= 1.0) return 0.0;
  // Functions have mean square 1: without a prior the curve's own size says how far it may go.
  double square = 0.0;
  for (int k = 0; k < shapes::BasisCount(term.shape); ++k) square += term.amplitude[k] * term.amplitude[k];
  const double own = term.prior_sigma > 0.0 ? term.prior_sigma : std::sqrt(square);
  return own * std::abs(shapes::FactorAt(term.shape, state)) * std::sqrt(1.0 - kept * kept);
}

JointErrors<double> ErrorsAt(const Machine& machine, const ErrorModel& model, const shapes::State& state) {
  JointErrors<double> errors;
  for (const ErrorTerm& term : model.terms) AddErrors(term, state, &errors);
  return errors;
}

absl::Status RequireState(const Machine& machine, const ErrorTerm& term, bool has_time,
                          const std::vector<std::string>& channels) {
  const auto refuse = [&](const std::string& column, const char* what) {
    return absl::InvalidArgumentError(
        absl::StrCat("column ", column, " is missing: the error ", NameOf(machine, term), " depends on the ", what));
  };
  const std::optional<std::string> channel = shapes::ChannelOf(term.shape);
  if (channel && std::find(channels.begin(), channels.end(), *channel) == channels.end())
    return refuse(*channel, "temperature");
  if (!has_time && shapes::DependsOnTime(term.shape)) return refuse("t_s", "time");
  return absl::OkStatus();
}

bool DependsOnMoreThanPosition(const ErrorTerm& term) {
  return !std::holds_alternative<shapes::Constant>(term.shape) && !std::holds_alternative<shapes::Linear>(term.shape) &&
         !std::holds_alternative<shapes::Quadratic>(term.shape) &&
         !std::holds_alternative<shapes::Harmonic>(term.shape) &&
         !std::holds_alternative<shapes::Tabulated>(term.shape) && !std::holds_alternative<shapes::Curve>(term.shape) &&
         !std::holds_alternative<shapes::Crossed>(term.shape);
}

}  // namespace axiscal::machine
