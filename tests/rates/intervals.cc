#include "tests/rates/intervals.h"

#include <absl/strings/str_format.h>

#include <cmath>

namespace axiscal::rates {

void Count(double deviation, double sigma, double factor, const std::vector<std::string>& names,
           CoverageByKind* coverage) {
  for (const std::string& name : names) {
    Coverage& one = (*coverage)[name];
    ++one.intervals;
    one.held += std::abs(deviation) <= factor * sigma;  // false for NaN
    one.within_three += std::abs(deviation) <= 3.0 * sigma;
    one.squares += deviation * deviation / (sigma * sigma);
  }
}

void AddResult(const identify::Result& result, const machine::ErrorModel& truth, const std::vector<std::string>& names,
               const std::function<std::string(const identify::Parameter*)>& kind, CoverageByKind* coverage) {
  const auto count = [&](double deviation, double sigma, const identify::Parameter* parameter) {
    std::vector<std::string> of = names;
    of.push_back(kind(parameter));
    Count(deviation, sigma, result.coverage_factor, of, coverage);
  };
  const std::vector<identify::Parameter> parameters = identify::ListParameters(truth, false);
  Eigen::VectorXd values(static_cast<Eigen::Index>(parameters.size()));
  for (size_t i = 0; i < parameters.size(); ++i) {
    const identify::Estimate& estimate = result.estimates[i];
    const double value = values[static_cast<Eigen::Index>(i)] = identify::ValueOf(truth, parameters[i]);
    if (estimate.identifiable) count(estimate.value - value, estimate.sigma, &parameters[i]);
  }
  for (const identify::Combination& combination : result.determined)
    count(combination.value - combination.of.dot(values), combination.sigma, nullptr);
}

std::string ToText(const CoverageByKind& coverage) {
  std::string text;
  for (const auto& [name, one] : coverage) {
    absl::StrAppendFormat(&text, "%-28s %5d intervals, %6.2f %% hold the truth, deviation rms %.3f sigma\n", name,
                          one.intervals, 100.0 * one.share(), std::sqrt(one.squares / one.intervals));
  }
  return text;
}

}  // namespace axiscal::rates
