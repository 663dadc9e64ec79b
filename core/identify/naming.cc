#include "core/identify/naming.h"

#include <cmath>

#include "core/machine/error_covariance.h"

namespace axiscal::identify {

Estimate NamedEstimate(const machine::Machine& machine, const machine::ErrorModel& model, const Parameter& parameter) {
  const machine::ErrorTerm& term = model.terms[parameter.term];
  const machine::NamedNumber number =
      machine::NameNumber(machine, model, parameter.term, parameter.basis, parameter.is_nonlinear);
  Estimate estimate;
  estimate.name = number.name;
  estimate.symbol = machine::SymbolOf(machine, term);
  estimate.unit = number.unit;
  estimate.factor = number.factor;
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
