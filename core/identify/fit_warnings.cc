#include "core/identify/fit_warnings.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/identify/plausible_errors.h"
#include "core/instruments/resolution.h"

namespace axiscal::identify {

std::vector<Warning> WarningsOf(const Result& result, const std::vector<Parameter>& parameters,
                                const std::vector<bool>& without_interval, const std::vector<bool>& unsupported) {
  std::vector<Warning> warnings;
  constexpr double kPoorFit = 4.0;  // twice the stated sigma
  if (result.fit.chi2_per_dof > kPoorFit) {
    warnings.push_back({"scatter", absl::StrFormat("the readings scatter by %.1f times their stated sigma about this "
                                                   "model: it lacks something, or a session is bad",
                                                   std::sqrt(result.fit.chi2_per_dof))});
  }
  const auto set_aside = std::count_if(result.outliers.begin(), result.outliers.end(),
                                       [](const Outlier& outlier) { return !outlier.gate.has_value(); });
  constexpr double kChips = 0.05;  // of all readings: dirty sessions have one or two in a hundred
  constexpr int kFew = 3;
  if (set_aside > std::max<double>(kFew, kChips * result.fit.readings)) {
    warnings.push_back({"set-aside", absl::StrFormat("%d of %d readings stand out and were set aside, too many for "
                                                     "chips: the model lacks something that they show",
                                                     set_aside, result.fit.readings)});
  }
  std::string names;
  for (size_t i = 0; i < without_interval.size(); ++i) {
    if (without_interval[i]) absl::StrAppend(&names, names.empty() ? "" : ", ", result.estimates[i].name);
  }
  if (!names.empty()) {
    warnings.push_back(
        {"interval", names + ": the readings leave the set-up so open that no interval can be stated (another set-up "
                             "with other errors explains them as well)"});
  }
  names.clear();
  for (size_t i = 0; i < unsupported.size(); ++i) {
    const Estimate& estimate = result.estimates[i];
    const double size = ValueOf(result.model, parameters[i]) / estimate.factor;
    if (!unsupported[i] || parameters[i].is_nonlinear || !(std::abs(size) > kPlausible)) continue;
    absl::StrAppend(&names, names.empty() ? "" : ", ",
                    absl::StrFormat("%s at %.0f %s", estimate.name, size, estimate.unit));
  }
  if (!names.empty()) {
    warnings.push_back({"no-number", names + ": the fit ended there because something had to take up what the readings "
                                             "show, but no reading supports such a size; do not compensate with this "
                                             "model away from the measured poses"});
  }
  return warnings;
}

std::vector<Warning> CoarseReadings(const Problem& problem) {
  std::vector<Warning> warnings;
  for (const instruments::MeasuringRun& run : problem.runs) {
    const double resolution_mm = instruments::CoarseResolutionOf(run);
    if (resolution_mm == 0.0) continue;
    warnings.push_back(
        {"resolution",
         absl::StrFormat(
             "session '%s': readings stand in steps of %.4g um, expected at most %g times the stated sigma of "
             "%.4g um: what rounding hides is counted as noise of %.4g um",
             run.session, resolution_mm * base::kUmPerMm, instruments::kCoarse, run.sigma_mm * base::kUmPerMm,
             instruments::RoundingSigma(run) * base::kUmPerMm)});
  }
  return warnings;
}

std::vector<Warning> SharedWithHeld(const Problem& problem, const Covariance& covariance,
                                    const std::vector<MeasuredIn>& held_from) {
  std::string readings, offsets;
  const auto append = [](const std::string& text, std::string* to) {
    absl::StrAppend(to, to->empty() ? "" : ", ", text);
  };
  const auto is_shared = [&](std::string MeasuredIn::*what, const std::string& name) {
    return std::any_of(held_from.begin(), held_from.end(), [&](const MeasuredIn& from) { return from.*what == name; });
  };
  for (const instruments::MeasuringRun& run : problem.runs) {
    if (is_shared(&MeasuredIn::session, run.session)) append(run.session, &readings);
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
        append(absl::StrCat(parameter.name, " of set-up ", group.name), &offsets);
    }
  }
  constexpr char kAdvice[] =
      ": the stated sigmas take both stages for independent; identify from all sessions together";
  std::vector<Warning> warnings;
  if (!readings.empty()) {
    warnings.push_back(
        {"held", absl::StrCat("the held errors come from sessions that are used again (", readings, ")", kAdvice)});
  } else if (!offsets.empty()) {
    warnings.push_back(
        {"held", absl::StrCat("the held errors rest on the same stated sigma as this fit (", offsets, ")", kAdvice)});
  }
  return warnings;
}

}  // namespace axiscal::identify
