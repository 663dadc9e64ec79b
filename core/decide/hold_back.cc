#include "core/decide/hold_back.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <variant>

#include "core/loop/fitting.h"
#include "core/predict/over_poses.h"

namespace axiscal::decide {
namespace {

using loop::Extension;

machine::KnownErrors KnownOf(const machine::Machine& machine, const identify::Result& result) {
  machine::KnownErrors known{result.model, {}};
  auto covariance = machine::CovarianceOf(result.covariance, machine, result.model);
  if (covariance.ok()) known.covariance = *std::move(covariance);
  return known;
}

// Without effects, by their place.
Extension Without(Extension extension, std::vector<size_t> effects) {
  std::sort(effects.rbegin(), effects.rend());
  for (const size_t effect : effects)
    extension.effects.erase(extension.effects.begin() + static_cast<std::ptrdiff_t>(effect));
  return extension;
}

// Whether a program or a table is corrected for it. What is not cleans the constants of what it takes up: structure
// without a name, and curves of the time of the readings.
bool IsCorrected(const machine::ErrorTerm& term) {
  return machine::HasName(term) && !std::holds_alternative<shapes::TimeCurve>(term.shape);
}

// Of `effects`: those of the component of an acceleration that this outweighs in the readings, on the whole or at its
// largest. What an axis does between readings where it sets off, stops and turns is not known, so that an acceleration
// from differences of positions is off by as much as it is large, and leaves what reads like lost motion, a lag or an
// error of the positions where it does so.
std::vector<size_t> OfAccelerations(const Extension& extension, const std::vector<size_t>& effects,
                                    const identify::Fit& fit) {
  const auto term_of = [&](size_t effect) -> const machine::ErrorTerm& {
    return fit.result.model.terms[extension.TermOf(effect)];
  };
  std::vector<size_t> out;
  for (const size_t one : effects) {
    const machine::ErrorTerm& acceleration = term_of(one);
    if (!std::holds_alternative<shapes::Acceleration>(acceleration.shape)) continue;
    const auto of_acceleration = loop::InReadings(fit.problem.runs, acceleration);
    for (const size_t other : effects) {
      const machine::ErrorTerm& term = term_of(other);
      if (other == one || term.joint != acceleration.joint || term.component != acceleration.component) continue;
      const auto of_term = loop::InReadings(fit.problem.runs, term);
      if (of_term.rms < of_acceleration.rms || of_term.largest < of_acceleration.largest) out.push_back(other);
    }
  }
  return out;
}

// What is held back may be there or not, and what was fitted beside it goes with it.
predict::OpenChoice WhetherHeldBack(const machine::Machine& machine, const std::vector<int>& terms,
                                    const machine::ErrorModel& as_found, const machine::ErrorModel& without) {
  constexpr double kOdds = 1.0;  // nobody knows
  predict::OpenChoice choice{"", as_found, {{without, kOdds}}, {}};
  for (const int term : terms)
    choice.overrules.push_back(machine::NameOf(machine, as_found.terms[static_cast<size_t>(term)]));
  return choice;
}

// What the declared model leaves of the readings that the amplitudes are fitted to, mm rms.
double LeftByDeclared(const loop::Report& report) {
  const identify::FitStatistics &fit = report.fit_before, &check = report.check_before;
  if (!report.is_check_fitted) return fit.rms_mm;
  return std::sqrt((fit.readings * fit.rms_mm * fit.rms_mm + check.readings * check.rms_mm * check.rms_mm) /
                   (fit.readings + check.readings));
}

// Of errors by themselves over the measured box: root of the sum of their mean squares, mm.
double ApartMm(const machine::Machine& machine, const std::vector<instruments::MeasuringRun>& runs,
               const std::vector<machine::ErrorTerm>& terms) {
  const predict::BoxPoses poses(runs, predict::kBoxPoses);
  const predict::OverPoses over(machine, poses, runs.front().tip_mm);
  double square = 0.0;
  for (const machine::ErrorTerm& term : terms) square += std::pow(predict::RmsOver(over.ErrorsOf({{term}})), 2);
  return std::sqrt(square);
}

// Of `effects`: those to take off, one by one, until the corrections for all others together do no more than this over
// the measured box, mm rms; first the one without which that is least. All as large as in `fit`.
std::vector<size_t> Hiding(const machine::Machine& machine, const Extension& extension, std::vector<size_t> effects,
                           const identify::Fit& fit, double most_mm) {
  const std::vector<instruments::MeasuringRun>& runs = fit.problem.runs;
  const predict::BoxPoses poses(runs, predict::kBoxPoses);
  const predict::OverPoses over(machine, poses, runs.front().tip_mm);
  std::vector<Eigen::VectorXd> errors;
  Eigen::VectorXd all = Eigen::VectorXd::Zero(over.rows());
  std::erase_if(effects, [&](size_t effect) { return !IsCorrected(fit.result.model.terms[extension.TermOf(effect)]); });
  for (const size_t effect : effects) {
    errors.push_back(over.ErrorsOf({{fit.result.model.terms[extension.TermOf(effect)]}}));
    all += errors.back();
  }
  std::vector<size_t> out;
  while (predict::RmsOver(all) > most_mm && !effects.empty()) {
    std::vector<double> left;
    for (const Eigen::VectorXd& one : errors) left.push_back(predict::RmsOver(all - one));
    const auto least = std::min_element(left.begin(), left.end()) - left.begin();
    out.push_back(effects[static_cast<size_t>(least)]);
    all -= errors[static_cast<size_t>(least)];
    effects.erase(effects.begin() + least);
    errors.erase(errors.begin() + least);
  }
  return out;
}

}  // namespace

absl::Status HoldBack(const machine::Machine& machine, const Extension& extension, const identify::Fit& fit,
                      const identify::Result& declared, const objective::Policy& policy,
                      const identify::Options& options, loop::Report* report) {
  const auto over = [&](const machine::ErrorModel& before, const std::vector<predict::OpenChoice>& choices) {
    return predict::BoxOdds::Over(machine, fit.problem.runs, before, KnownOf(machine, fit.result), choices);
  };
  std::unique_ptr<const predict::BoxOdds> figures = over(report->declared, report->choices);
  if (figures == nullptr) return absl::OkStatus();
  const predict::Worse worse{policy.harm_share, policy.harm_mm};
  std::vector<size_t> kept, out;  // effects that may be held back, those that are
  std::vector<int> terms;         // of those that are
  for (size_t i = 0; i < extension.effects.size(); ++i) {
    const loop::Candidate& candidate = extension.effects[i].candidate;
    if (IsTerm(candidate.family) && !std::holds_alternative<shapes::Constant>(candidate.term.shape)) kept.push_back(i);
  }
  std::unique_ptr<const predict::BoxOdds> odds;
  double harm = 0.0;
  if (!kept.empty()) {
    ASSIGN_OR_RETURN(const identify::Fit constants, FitExtension(machine, Without(extension, kept), options));
    odds = over(constants.result.model, report->choices);
    harm = odds->ProbabilityOf(worse, fit.result.model);
  }
  const auto term_of = [&](size_t effect) -> const machine::ErrorTerm& {
    return fit.result.model.terms[extension.TermOf(effect)];
  };
  const auto hold_back = [&](std::vector<size_t>::iterator effect, loop::HeldBack::Why why) {
    const machine::ErrorTerm& term = term_of(*effect);
    if (machine::HasName(term)) report->held_back.push_back({term, extension.effects[*effect].score, harm, why});
    terms.push_back(extension.TermOf(*effect));
    out.push_back(*effect);
    kept.erase(effect);
  };
  const auto fit_again = [&]() -> absl::Status {
    ASSIGN_OR_RETURN(const identify::Fit again, FitExtension(machine, Without(extension, out), options));
    report->fitted = again.result;
    std::vector<predict::OpenChoice> choices = report->choices;
    choices.push_back(WhetherHeldBack(machine, terms, fit.result.model, again.result.model));
    figures = over(report->declared, choices);
    harm = odds->ProbabilityOf(worse, report->fitted.model);
    return absl::OkStatus();
  };
  const auto hold_back_all = [&](const std::vector<size_t>& effects, loop::HeldBack::Why why) -> absl::Status {
    for (const size_t effect : effects) hold_back(std::find(kept.begin(), kept.end(), effect), why);
    return effects.empty() ? absl::OkStatus() : fit_again();
  };
  RETURN_IF_ERROR(hold_back_all(OfAccelerations(extension, kept, fit), loop::HeldBack::kUndecided));
  const double shown_mm = LeftByDeclared(*report);
  RETURN_IF_ERROR(
      hold_back_all(Hiding(machine, extension, kept, fit, policy.largest_hidden * shown_mm), loop::HeldBack::kHidden));
  while (harm > policy.harm_probability && !kept.empty()) {
    do {
      const auto without = [&](size_t effect) {
        std::vector<int> all = terms;
        all.push_back(extension.TermOf(effect));
        return odds->ProbabilityWithout(all, worse);
      };
      std::vector<double> left;
      for (const size_t effect : kept) left.push_back(without(effect));
      const auto least = std::min_element(left.begin(), left.end());
      const double harm_without = *least;
      hold_back(kept.begin() + (least - left.begin()), loop::HeldBack::kHarm);
      harm = harm_without;
    } while (harm > policy.harm_probability && !kept.empty());
    RETURN_IF_ERROR(fit_again());
  }
  const auto take_figures = [&] {
    std::vector<std::string> unknown;
    for (const identify::Estimate& estimate : report->fitted.estimates)
      if (!estimate.identifiable) unknown.push_back(estimate.name);
    std::vector<machine::ErrorTerm> corrected;
    for (const size_t effect : kept)
      if (IsCorrected(term_of(effect))) corrected.push_back(term_of(effect));
    const predict::Unsure unsure{policy.form_share * ApartMm(machine, fit.problem.runs, corrected), policy.sigma_share};
    report->volumetric = figures->Figures(report->fitted.model, unknown, unsure);
  };
  take_figures();
  // What promises no gain is no reason to move a machine: rivals that nobody thought of come on top of what the
  // interval holds.
  std::erase_if(kept, [&](size_t effect) { return !IsCorrected(term_of(effect)); });
  if (!report->volumetric->is_gain_held && !kept.empty()) {
    while (!kept.empty()) hold_back(kept.begin(), loop::HeldBack::kNoGain);
    RETURN_IF_ERROR(fit_again());
    take_figures();
  }
  const predict::VolumetricError& left = *report->volumetric;
  if (!left.is_gain_held && left.after.expected_mm > (1.0 - policy.least_gain) * left.before.expected_mm) {
    std::vector<identify::Outlier> outliers = std::move(report->fitted.outliers);  // bad readings are bad for any model
    report->fitted = declared;
    report->fitted.outliers = std::move(outliers);
    take_figures();
  }
  return absl::OkStatus();
}

}  // namespace axiscal::decide
