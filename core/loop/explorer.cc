#include "core/loop/explorer.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/loop/dictionary.h"
#include "core/loop/fitting.h"
#include "core/loop/validation.h"

namespace axiscal::loop {

using identify::Fit;
using instruments::MeasuringRun;

namespace {

// The noise of dense series is judged from the scatter between neighbours, which does not include misfit. The noise of
// sessions with few readings does include it: such a session then seems to scatter more than others of its instrument.
bool IsMisfit(const Fit& fit) {
  constexpr double kBeyondChance = 2.0, kUnlike = 1.5;  // standard deviations; sigma
  constexpr double kHopeless = 4.0;  // what is twice the noise is no choice between names: the dictionary lacks it
  const identify::FitStatistics& all = fit.result.fit;
  if (all.chi2_per_dof > kHopeless) return false;
  if (all.chi2_per_dof > 1.0 + kBeyondChance * std::sqrt(2.0 / std::max(1, all.degrees_of_freedom))) return true;
  const identify::Problem& problem = fit.problem;
  const auto factor = [&](size_t i) { return problem.noise[i].sigma_mm / problem.runs[i].sigma_mm; };
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    for (size_t k = 0; k < problem.runs.size(); ++k) {
      if (problem.runs[i].kind == problem.runs[k].kind && factor(i) > kUnlike * factor(k)) return true;
    }
  }
  return false;
}

// Effects of `before` that `after` does not have, then those that it has in their place.
void NoteChanges(const Extension& before, const Fit& fit, Attempt* after) {
  const auto names_of = [](const Extension& extension) {
    std::vector<std::string> names;
    for (size_t i = 0; i < extension.effects.size(); ++i) names.push_back(extension.NameOf(i));
    return names;
  };
  const std::vector<std::string> old_names = names_of(before), new_names = names_of(after->extension);
  const auto has = [](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (const std::string& name : old_names)
    if (!has(new_names, name)) after->Note(SelectionStep::kDropped, name, fit);
  for (const std::string& name : new_names)
    if (!has(old_names, name)) after->Note(SelectionStep::kAdded, name, fit);
}

}  // namespace

absl::StatusOr<Outcome> Explorer::Explore() {
  Way way;
  way.most_effects = options_.max_effects;
  ASSIGN_OR_RETURN(Outcome best, Grow(&way));
  bool is_foretold = true, is_taken = false;
  ASSIGN_OR_RETURN(const bool is_more, IsMoreInAll(best, &is_foretold));
  if (is_more) {
    ASSIGN_OR_RETURN(is_taken, FitTogether(&best));
    if (!is_taken) RETURN_IF_ERROR(BeginElsewhere(way, &best));
  }
  if (!is_taken && !is_foretold) RETURN_IF_ERROR(FitSameTogether(&best));
  return best;
}

absl::StatusOr<Outcome> Explorer::Grow(Way* way) {
  ASSIGN_OR_RETURN(Outcome best, Try(*way));
  ASSIGN_OR_RETURN(way->names_first, PreferNames(*way, &best));
  RETURN_IF_ERROR(Detour(*way, &best));
  return best;
}

// Two effects where only one is expected can look like a local defect, because its place and width are free. Where a
// local defect was found that named effects nearly match, a search with names alone is tried, with one more effect than
// so far, and kept if it explains as much. Returns whether it was kept.
absl::StatusOr<bool> Explorer::PreferNames(Way way, Outcome* best) {
  const std::vector<Added>& found = best->attempt.extension.effects;
  const auto is_local = [](const Added& one) { return one.candidate.family == Family::kBump; };
  if (!best->attempt.has_close_name || best->attempt.report.has_stopped_early) return false;
  if (std::none_of(found.begin(), found.end(), is_local)) return false;
  way.names_first = true;
  way.most_effects = std::min(way.most_effects, static_cast<int>(found.size()) + 1);
  ASSIGN_OR_RETURN(Outcome named, Try(way));
  if (!IsBetter(named, *best)) return false;
  *best = std::move(named);
  return true;
}

// One effect may have been added in place of two others that would together have explained more. Where the noise does
// not explain what is left, the search is repeated with each effect in turn excluded at the step where it was added.
absl::Status Explorer::Detour(Way way, Outcome* best) {
  const std::vector<Added> found = best->attempt.extension.effects;
  for (size_t i = 0; i < found.size() && IsMisfit(best->fit) && !best->attempt.report.has_stopped_early; ++i) {
    if (IsUnnamed(found[i].candidate.family)) continue;
    way.prefix.assign(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(i));
    way.bad_rows = best->attempt.extension.bad_rows;
    way.not_first = {found[i].candidate};
    way.not_first.insert(way.not_first.end(), found[i].equivalent.begin(), found[i].equivalent.end());
    ASSIGN_OR_RETURN(Outcome other, Try(way));
    if (!IsBetter(other, *best)) continue;
    Report& report = other.attempt.report;
    report.ranking = best->attempt.report.ranking;
    report.candidates = best->attempt.report.candidates;
    report.not_visible = best->attempt.report.not_visible;
    other.attempt.first = best->attempt.first;
    *best = std::move(other);
  }
  return absl::OkStatus();
}

// True where it explains more for its number of parameters, and at least as many of the check sessions.
bool Explorer::IsBetter(const Outcome& one, const Outcome& other) const {
  return CostOf(one.attempt.extension, one.fit) < CostOf(other.attempt.extension, other.fit) &&
         one.unexplained_sessions.size() <= other.unexplained_sessions.size();
}

// What is left and what it took to explain the rest.
double Explorer::CostOf(const Extension& extension, const Fit& fit) const {
  double cost = ComparableSquaresOf(fit);
  for (const Added& one : extension.effects) {
    const bool is_named = !IsUnnamed(one.candidate.family);
    constexpr int kUnnamedColumns = 3;
    const int columns = is_named ? shapes::BasisCount(one.candidate.term.shape) : kUnnamedColumns;
    cost += options_.search.evidence + options_.search.per_column * (columns - 1);
  }
  return cost;
}

// Whether the check sessions show that something is wrong, even if less than would leave them unexplained; and whether
// amplitudes from the fit sessions predict them nearly as well as those from all sessions.
absl::StatusOr<bool> Explorer::IsMoreInAll(const Outcome& best, bool* is_foretold) {
  if (check_.is_empty() || best.attempt.report.has_stopped_early) return false;
  if (!best.unexplained_sessions.empty()) return true;
  if (best.attempt.extension.effects.empty()) return false;
  RETURN_IF_ERROR(check_.Settle(best.fit));
  const absl::StatusOr<std::shared_ptr<const Fit>> fit = check_.Joint(best.fit);
  if (absl::IsCancelled(fit.status())) return fit.status();
  if (!fit.ok()) return false;
  const Fit& joint = **fit;
  constexpr double kNearly = 1.2;
  *is_foretold = check_.SquaresAlone() < kNearly * check_.SquaresIn(joint, best.fit.problem.runs.size());
  const Signatures signatures(joint.problem, joint.point, identify::ListParameters(joint.point.model, true));
  std::vector<Candidate> named = MakeDictionary(joint.problem, joint.point.model);
  std::erase_if(named, [](const Candidate& one) { return IsUnnamed(one.family); });
  return Search(machine_, signatures, named, options_.search).is_significant;
}

Way Explorer::WayOfAll() {
  together_ = check_.After(runs_);
  Way way;
  way.most_effects = options_.max_effects;
  way.with_check = true;
  return way;
}

// The fit sessions may see only the sum of two effects, and one of them stands for both. Where a fit of all sessions
// together leaves no check session unexplained, at a lower cost than the result so far, it becomes the result: true.
absl::StatusOr<bool> Explorer::FitTogether(Outcome* best) {
  Way way = WayOfAll();
  ASSIGN_OR_RETURN(Outcome other, Grow(&way));
  if (!other.unexplained_sessions.empty()) return false;
  Extension known(machine_, together_);
  known.effects = best->attempt.extension.effects;
  known.bad_rows = best->attempt.extension.bad_rows;
  const absl::StatusOr<Fit> same = FitExtension(machine_, known, identify_options_);
  if (absl::IsCancelled(same.status())) return same.status();
  if (same.ok() && !(CostOf(other.attempt.extension, other.fit) < CostOf(known, *same))) return false;
  ASSIGN_OR_RETURN(const bool is_alone, FitAlone(other, best));
  if (!is_alone) *best = std::move(other);
  return true;
}

// The effects stay, but the fit sessions tell little more than the sum of their amplitudes: the same effects are fitted
// to all sessions.
absl::Status Explorer::FitSameTogether(Outcome* best) {
  Way way = WayOfAll();
  way.prefix = best->attempt.extension.effects;
  way.bad_rows = best->attempt.extension.bad_rows;
  ASSIGN_OR_RETURN(Outcome other, Try(way));
  if (other.unexplained_sessions.empty()) *best = std::move(other);
  return absl::OkStatus();
}

// The effects of `named`, which all sessions support, with amplitudes from the fit sessions alone, so that the check
// sessions still prove something. False, with `best` unchanged, where the fit sessions do not tell these amplitudes.
absl::StatusOr<bool> Explorer::FitAlone(const Outcome& named, Outcome* best) {
  constexpr double kNoWorse = 1.02;
  const std::vector<Added>& effects = named.attempt.extension.effects;
  Outcome alone{best->attempt, {}, {}, {}};
  alone.attempt.extension.effects = effects;
  alone.attempt.extension.bad_rows = named.attempt.extension.bad_rows;
  std::erase_if(alone.attempt.extension.bad_rows,
                [this](const BadRow& bad) { return bad.run >= static_cast<int>(runs_.size()); });
  for (const Added& one : effects) {
    if (one.candidate.run >= static_cast<int>(runs_.size())) return false;  // a slip in a check session
  }
  absl::StatusOr<Fit> fit = FitExtension(machine_, alone.attempt.extension, identify_options_);
  if (absl::IsCancelled(fit.status())) return fit.status();
  if (!fit.ok()) return false;
  for (size_t i = 0; i < effects.size(); ++i) {
    const bool is_named = !IsUnnamed(effects[i].candidate.family);
    if (is_named && EvidenceOf(*fit, alone.attempt.extension.TermOf(i)) < options_.search.evidence) return false;
  }
  Report& report = alone.attempt.report;
  ASSIGN_OR_RETURN(alone.check_after, CheckStatistics(*fit, &SessionResiduals::after_mm, &report));
  RETURN_IF_ERROR(check_.Settle(*fit));
  ASSIGN_OR_RETURN(alone.unexplained_sessions, check_.UnexplainedSessions(*fit));
  if (!alone.unexplained_sessions.empty() || alone.check_after.rms_mm > kNoWorse * named.check_after.rms_mm)
    return false;
  NoteChanges(best->attempt.extension, *fit, &alone.attempt);
  alone.fit = *std::move(fit);
  *best = std::move(alone);
  return true;
}

// A first effect that stands for two others misleads the search. Where check sessions stay unexplained, another first
// effect is tried, and its result taken if it explains them better and the fit sessions no worse. Where the limit of
// effects was reached, another first effect would not help.
absl::Status Explorer::BeginElsewhere(Way way, Outcome* best) {
  constexpr int kBeginnings = 3;
  std::optional<Added> first = best->attempt.first;
  bool is_explained = best->unexplained_sessions.empty();
  for (int round = 1; round < kBeginnings && !is_explained && first.has_value(); ++round) {
    // A member of the same class would lead to the same result.
    way.not_first.push_back(first->candidate);
    way.not_first.insert(way.not_first.end(), first->equivalent.begin(), first->equivalent.end());
    ASSIGN_OR_RETURN(Outcome other, Try(way));
    first = other.attempt.first;
    is_explained = other.unexplained_sessions.empty();
    constexpr double kBetter = 0.98, kNoWorse = 1.02;
    if (other.check_after.rms_mm < kBetter * best->check_after.rms_mm &&
        other.fit.result.fit.rms_mm < kNoWorse * best->fit.result.fit.rms_mm)
      *best = std::move(other);
  }
  return absl::OkStatus();
}

absl::StatusOr<Outcome> Explorer::Try(const Way& way) {
  const std::vector<MeasuringRun>& runs = way.with_check ? together_ : runs_;
  Outcome outcome{{Extension(machine_, runs), way, {}, {}, false, false, {}}, {}, {}, {}};
  Attempt* const attempt = &outcome.attempt;
  Report* const report = &attempt->report;
  std::vector<Added>& effects = attempt->extension.effects;
  attempt->extension.bad_rows = way.bad_rows;
  report->has_check = !check_.is_empty();
  report->is_check_fitted = way.with_check;
  Check none(machine_, {}, identify_options_);
  if (options_.progress) options_.progress({"fitting the declared model", 0.0, ""});
  ASSIGN_OR_RETURN(Fit fit, FitExtension(machine_, attempt->extension, identify_options_));
  report->fit_before = fit.result.fit;
  report->declared = fit.result.model;
  KeepResiduals(fit, runs_, &SessionResiduals::before_mm, report);
  ASSIGN_OR_RETURN(report->check_before, CheckStatistics(fit, &SessionResiduals::before_mm, report));
  for (const Added& one : way.prefix) {
    effects.push_back(one);
    ASSIGN_OR_RETURN(fit, FitExtension(machine_, attempt->extension, identify_options_));
    attempt->Note(SelectionStep::kAdded, attempt->extension.NameOf(effects.size() - 1), fit);
  }
  Growth growth(machine_, options_, identify_options_, attempt);
  Validation validation(machine_, identify_options_, way.with_check ? &none : &check_, attempt);
  RETURN_IF_ERROR(growth.Extend(&fit));
  ASSIGN_OR_RETURN(const bool has_replaced, validation.Run(&fit));
  if (has_replaced) {
    // Structure without a name beside the wrong effect may get a name beside the right one, or not be there at all.
    std::erase_if(effects, [](const Added& one) { return IsUnnamed(one.candidate.family); });
    ASSIGN_OR_RETURN(fit, FitExtension(machine_, attempt->extension, identify_options_));
    RETURN_IF_ERROR(growth.Prune(&fit));
    RETURN_IF_ERROR(growth.Extend(&fit));
    RETURN_IF_ERROR(validation.Run(&fit).status());
  }
  ASSIGN_OR_RETURN(outcome.check_after, CheckStatistics(fit, &SessionResiduals::after_mm, report));
  if (!check_.is_empty()) {
    RETURN_IF_ERROR(check_.Settle(fit));
    outcome.unexplained_sessions = check_.UnexplainedWhereFitted();
    if (!way.with_check) {
      ASSIGN_OR_RETURN(outcome.unexplained_sessions, check_.UnexplainedSessions(fit));
    }
  }
  outcome.fit = std::move(fit);
  return outcome;
}

void Explorer::KeepResiduals(const Fit& fit, const std::vector<MeasuringRun>& runs, ResidualField field,
                             Report* report) const {
  const bool is_check = &runs == &check_.runs();
  const size_t offset = is_check ? runs_.size() : 0;
  report->residuals.resize(runs_.size() + check_.runs().size());
  for (size_t i = 0; i < runs.size(); ++i) {
    SessionResiduals& kept = report->residuals[offset + i];
    kept.session = runs[i].session;
    kept.is_check = is_check;
    kept.*field = fit.residuals_mm[i];
  }
}

absl::StatusOr<identify::FitStatistics> Explorer::CheckStatistics(const Fit& fit, ResidualField field, Report* report) {
  if (check_.is_empty()) return identify::FitStatistics{};
  ASSIGN_OR_RETURN(const Fit check, check_.Under(fit));
  KeepResiduals(check, check_.runs(), field, report);
  return check.result.fit;
}

}  // namespace axiscal::loop
