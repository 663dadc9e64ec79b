#include "core/identify/fit_warnings.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/identify/plausible_errors.h"
#include "core/instruments/resolution.h"

namespace axiscal::identify {

std::vector<reports::WarningFacts> WarningsOf(const Result& result, const std::vector<Parameter>& parameters,
                                              const std::vector<bool>& without_interval,
                                              const std::vector<bool>& unsupported) {
  std::vector<reports::WarningFacts> warnings;
  if (result.fit.chi2_per_dof > reports::kPoorFitChi2PerDof)
    warnings.push_back(reports::Scatter{.times_sigma = std::sqrt(result.fit.chi2_per_dof)});
  const auto set_aside = std::count_if(result.outliers.begin(), result.outliers.end(),
                                       [](const Outlier& outlier) { return !outlier.gate.has_value(); });
  constexpr double kChips = 0.05;  // of all readings: dirty sessions have one or two in a hundred
  constexpr int kFew = 3;
  if (set_aside > std::max<double>(kFew, kChips * result.fit.readings))
    warnings.push_back(reports::SetAside{static_cast<int>(set_aside), result.fit.readings});
  reports::NoInterval no_interval;
  for (size_t i = 0; i < without_interval.size(); ++i) {
    if (without_interval[i]) no_interval.errors.push_back(result.estimates[i].name);
  }
  if (!no_interval.errors.empty()) warnings.push_back(std::move(no_interval));
  reports::NoNumber without_number;
  for (size_t i = 0; i < unsupported.size(); ++i) {
    const Estimate& estimate = result.estimates[i];
    const double size = ValueOf(result.model, parameters[i]) / estimate.factor;
    if (!unsupported[i] || parameters[i].is_nonlinear || !(std::abs(size) > kPlausible)) continue;
    without_number.errors.push_back({estimate.name, size, estimate.unit});
  }
  if (!without_number.errors.empty()) warnings.push_back(std::move(without_number));
  return warnings;
}

std::vector<reports::WarningFacts> FindCoarseReadings(const Problem& problem) {
  std::vector<reports::WarningFacts> warnings;
  for (const instruments::MeasuringRun& run : problem.runs) {
    const double resolution_mm = instruments::CoarseResolutionOf(run);
    if (resolution_mm == 0.0) continue;
    warnings.push_back(reports::CoarseReadings{.session = run.session,
                                               .step_um = resolution_mm * base::kUmPerMm,
                                               .sigma_um = run.sigma_mm * base::kUmPerMm,
                                               .rounding_sigma_um = instruments::RoundingSigma(run) * base::kUmPerMm,
                                               .most_sigmas = instruments::kCoarse});
  }
  return warnings;
}

std::vector<reports::WarningFacts> SharedWithHeld(const Problem& problem, const Covariance& covariance,
                                                  const std::vector<MeasuredIn>& held_from) {
  reports::SharedStages shared;
  const auto is_shared = [&](std::string MeasuredIn::*what, const std::string& name) {
    return std::any_of(held_from.begin(), held_from.end(), [&](const MeasuredIn& from) { return from.*what == name; });
  };
  for (const instruments::MeasuringRun& run : problem.runs) {
    if (is_shared(&MeasuredIn::session, run.session)) shared.sessions.push_back(run.session);
  }
  // By how much of its sigma an error moves with the offset's stated one.
  constexpr double kRests = 0.3;  // less: the stages' errors correlate by less than a tenth
  for (size_t g = 0; g < problem.groups.size(); ++g) {
    const SetupGroup& group = problem.groups[g];
    if (!is_shared(&MeasuredIn::setup, group.name)) continue;
    for (size_t k = 0; k < group.parameters.size(); ++k) {
      const instruments::SetupParameter& parameter = group.parameters[k];
      if (parameter.is_weak || !std::isfinite(parameter.prior_sigma)) continue;
      const Eigen::ArrayXd moved = covariance.with_setup[g].col(static_cast<Eigen::Index>(k)) / parameter.prior_sigma;
      const Eigen::ArrayXd sigma = covariance.errors.diagonal().array().max(0.0).sqrt();
      if ((moved.abs() > kRests * sigma && sigma > 0.0).any())
        shared.offsets.push_back(absl::StrCat(parameter.name, " of set-up ", group.name));
    }
  }
  if (shared.sessions.empty() && shared.offsets.empty()) return {};
  return {std::move(shared)};
}

}  // namespace axiscal::identify
