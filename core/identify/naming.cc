#include "core/identify/naming.h"

#include <cmath>

#include "core/base/units.h"
#include "core/machine/error_json.h"

namespace axiscal::identify {
namespace {

void NameNonlinear(const machine::Machine& machine, const machine::ErrorTerm& term, Estimate* estimate) {
  const std::optional<int> axis = shapes::VariableAxis(term.shape);
  const bool is_rotary = axis && machine.axes[*axis].kind == machine::AxisKind::kRotary;
  if (std::holds_alternative<shapes::Harmonic>(term.shape)) {
    estimate->name += ".frequency";
    estimate->unit = is_rotary ? "1/turn" : "rad/mm";
    return;
  }
  const bool is_length = std::holds_alternative<shapes::Reversal>(term.shape);
  estimate->name += is_length ? ".length" : ".tau";
  estimate->unit = !is_length ? "s" : is_rotary ? "deg" : "mm";
  estimate->factor = is_length && is_rotary ? base::kRadPerDeg : 1.0;
}

}  // namespace

Estimate NamedEstimate(const machine::Machine& machine, const machine::ErrorModel& model, const Parameter& parameter) {
  const machine::ErrorTerm& term = model.terms[parameter.term];
  Estimate estimate;
  estimate.name = machine::NameOf(machine, term);
  estimate.symbol = machine::SymbolOf(machine, term);
  if (parameter.is_nonlinear) {
    NameNonlinear(machine, term, &estimate);
    return estimate;
  }
  if (shapes::BasisCount(term.shape) == 2) estimate.name += parameter.basis == 0 ? ".cos" : ".sin";
  estimate.unit = machine::AmplitudeUnit(term, machine);
  estimate.factor = machine::AmplitudeFactor(term);
  return estimate;
}

std::string CombinationName(const std::vector<Estimate>& estimates, const Eigen::VectorXd& coefficients) {
  std::string name;
  double first = 0.0;
  for (size_t i = 0; i < estimates.size(); ++i) {
    if (coefficients[i] == 0.0) continue;
    // A direction moves the errors by its coefficients; in file units each is larger by 1 / factor.
    const double in_file_units = coefficients[i] / estimates[i].factor;
    if (first == 0.0) first = in_file_units;
    const double ratio = in_file_units / first;
    const std::string number = std::abs(std::abs(ratio) - 1.0) < 5e-4 ? "" : absl::StrFormat("%.4g ", std::abs(ratio));
    absl::StrAppend(&name, name.empty() ? "" : ratio > 0.0 ? " + " : " - ", number, estimates[i].name);
  }
  return name;
}

}  // namespace axiscal::identify
