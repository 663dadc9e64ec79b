#include "core/loop/validation.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/loop/dictionary.h"
#include "core/loop/fitting.h"
#include "core/loop/refine.h"
#include "core/loop/same_always.h"
#include "core/loop/signatures.h"

namespace axiscal::loop {

using identify::Fit;
using machine::ErrorModel;

namespace {

// Chi-square units.
constexpr double kSpeaksAgainst = 9.0, kClearly = 4.0, kMuchMore = 8.0, kAlike = 6.0;

}  // namespace

absl::StatusOr<bool> Validation::Run(Fit* fit) {
  bool has_replaced = false;
  if (check_.is_empty() || effects().empty()) return has_replaced;
  RETURN_IF_ERROR(check_.Settle(*fit));
  ASSIGN_OR_RETURN(std::optional<Fit> joint, Joint(*fit));
  // Of effects that the fit sessions could not tell apart another may be the true one. The largest comes first, because
  // a wrong one there falsifies all that was found beside it.
  for (size_t i = 0; i < effects().size() && joint.has_value(); ++i) {
    if (IsUnnamed(effects()[i].candidate.family)) continue;
    const std::vector<Added> before = effects();
    ASSIGN_OR_RETURN(const bool is_replaced, Replace(i, *fit, *joint));
    if (!is_replaced) continue;
    ASSIGN_OR_RETURN(const bool is_fitted, Change(before, fit));
    if (!is_fitted) continue;
    RETURN_IF_ERROR(PutSlip(i, kClearly, fit));
    has_replaced |= effects()[i].candidate.family != Family::kStep;
    attempt_->Note(SelectionStep::kReplaced, extension().NameOf(i), *fit);
    ASSIGN_OR_RETURN(joint, Joint(*fit));
  }
  for (size_t i = 0; i < effects().size() && joint.has_value(); ++i) {
    if (IsUnnamed(effects()[i].candidate.family) || effects()[i].equivalent.empty()) continue;
    const Candidate before = effects()[i].candidate;
    RETURN_IF_ERROR(Foretell(i, *joint, fit));
    if (IsSameEffect(before.term, effects()[i].candidate.term)) continue;
    attempt_->Note(SelectionStep::kReplaced, extension().NameOf(i), *fit);
    ASSIGN_OR_RETURN(joint, Joint(*fit));
  }
  for (size_t i = effects().size(); i-- > 0 && joint.has_value();) {
    if (IsUnnamed(effects()[i].candidate.family)) continue;
    RETURN_IF_ERROR(PutSlip(i, kMuchMore, fit));  // for two more amplitudes
    if (effects()[i].candidate.family == Family::kStep) {
      attempt_->Note(SelectionStep::kReplaced, extension().NameOf(i), *fit);
      ASSIGN_OR_RETURN(joint, Joint(*fit));
      continue;
    }
    ASSIGN_OR_RETURN(const bool speaks_against, SpeaksAgainst(i, *fit, *joint));
    if (!speaks_against) continue;
    const std::vector<Added> before = effects();
    const std::string name = extension().NameOf(i);
    effects().erase(effects().begin() + static_cast<std::ptrdiff_t>(i));
    ASSIGN_OR_RETURN(const bool is_fitted, Change(before, fit));
    if (!is_fitted) continue;
    attempt_->report.withdrawn.push_back(name);
    attempt_->Note(SelectionStep::kWithdrawn, name, *fit);
    ASSIGN_OR_RETURN(joint, Joint(*fit));
  }
  return has_replaced;
}

// Of members of effect i's class that all sessions leave alike, that takes its place whose amplitude, told by the fit
// sessions alone, foretells the check sessions best, where its own foretells them badly.
absl::Status Validation::Foretell(size_t i, const Fit& joint, Fit* fit) {
  constexpr double kBadly = 1.1, kWell = 1.05;  // chi-square over that with all sessions fitted
  const double within_reach = check_.SquaresIn(joint, fit->problem.runs.size());
  double least = check_.SquaresAlone();
  if (least < kBadly * within_reach) return absl::OkStatus();
  const std::vector<Added> before = effects();
  const Fit fit_before = *fit;
  Check::Settled settled_before = check_.settled();
  for (const Candidate& member : Contenders(i, joint, Wanted::kAlike)) {
    Added& effect = effects()[i];
    const Candidate own = before[i].candidate;
    effect = before[i];
    effect.candidate = member;
    std::erase_if(effect.equivalent, [&](const Candidate& one) { return IsSameEffect(one.term, member.term); });
    effect.equivalent.push_back(own);
    ASSIGN_OR_RETURN(const bool is_fitted, Change(before, fit));
    if (is_fitted && check_.SquaresAlone() < kWell * within_reach) return absl::OkStatus();
  }
  effects() = before;
  *fit = fit_before;
  check_.PutBack(std::move(settled_before));
  return absl::OkStatus();
}

// None where all sessions together cannot be fitted: then the check sessions say nothing.
absl::StatusOr<std::optional<Fit>> Validation::Joint(const Fit& fit) {
  const absl::StatusOr<std::shared_ptr<const Fit>> joint = check_.Joint(fit);
  if (absl::IsCancelled(joint.status())) return joint.status();
  if (!joint.ok()) return std::nullopt;
  return **joint;
}

// An effect that is there is worth as much with the check sessions as without them, or more.
absl::StatusOr<bool> Validation::SpeaksAgainst(size_t effect, const Fit& fit, const Fit& joint) const {
  const int term = extension().TermOf(effect);
  // An effect that is clear in the fit sessions is not wrong because another one disturbs the check sessions a little.
  constexpr double kLittle = 0.1;
  const double estimated = EvidenceOf(fit, term), joint_estimated = EvidenceOf(joint, term);
  // Far from doubt the quadratic estimate says enough.
  if (joint_estimated > estimated - 0.5 * std::max(kSpeaksAgainst, kLittle * estimated)) return false;
  const auto worth_in = [&](const Fit& whole) -> absl::StatusOr<double> {
    ErrorModel lacking = whole.result.model;
    lacking.terms.erase(lacking.terms.begin() + term);
    const absl::StatusOr<Fit> reduced = Refit(whole, lacking, identify_options_);
    if (absl::IsCancelled(reduced.status())) return reduced.status();
    return reduced.ok() ? SquaresOf(*reduced) - SquaresOf(whole) : INFINITY;
  };
  ASSIGN_OR_RETURN(const double worth, worth_in(fit));
  ASSIGN_OR_RETURN(const double joint_worth, worth_in(joint));
  return joint_worth < worth - std::max(kSpeaksAgainst, kLittle * worth);
}

// Fits the changed extension; false, and the effects as they were, where that does not converge.
absl::StatusOr<bool> Validation::Change(const std::vector<Added>& before, Fit* fit) {
  Extension unchanged = extension();
  unchanged.effects = before;
  ASSIGN_OR_RETURN(const bool is_fitted, FitChanged(machine_, identify_options_, unchanged, &attempt_->extension, fit));
  if (is_fitted) RETURN_IF_ERROR(check_.Settle(*fit));
  return is_fitted;
}

// Members of effect i's class, simplest first, that by linear estimate explain all sessions better than it, or nearly
// as well (the estimate may be wrong by a share): the best few; or alike: the simplest few. With amplitudes.
std::vector<Candidate> Validation::Contenders(size_t i, const Fit& joint, Wanted wanted) const {
  const int term = extension().TermOf(i);
  std::vector<Candidate> all = {effects()[i].candidate};
  all[0].term = joint.result.model.terms[term];
  all.insert(all.end(), effects()[i].equivalent.begin(), effects()[i].equivalent.end());
  all.insert(all.end(), effects()[i].rivals.begin(), effects()[i].rivals.end());
  std::vector<machine::ErrorTerm> terms;
  for (const Candidate& one : all) terms.push_back(one.term);
  // One effect by two names says the same to any session.
  const std::vector<int> first = FirstOfTheSame(machine_, joint.problem.runs.front().tip_mm, terms);
  std::vector<Candidate> members;
  for (size_t m = 0; m < all.size(); ++m) {
    if (first[m] == static_cast<int>(m)) members.push_back(all[m]);
  }
  if (members.size() < 2) return {};
  identify::Point lacking = joint.point;
  lacking.model.terms.erase(lacking.model.terms.begin() + term);
  const Signatures signatures(joint.problem, lacking, identify::ListParameters(lacking.model, true));
  const std::vector<Projection> projections = signatures.Project(members);
  std::vector<double> gains(members.size());
  for (size_t m = 0; m < members.size(); ++m) {
    Eigen::Vector3d amplitude;
    gains[m] = Gain(projections[m], &amplitude);
    for (int b = 0; b < projections[m].columns; ++b) members[m].term.amplitude[b] = amplitude[b];
  }
  constexpr double kShare = 0.05;
  constexpr size_t kTried = 4;
  double least = wanted == Wanted::kBetter         ? gains[0] + 0.5 * kSpeaksAgainst
                 : wanted == Wanted::kNearlyAsGood ? (1.0 - kShare) * gains[0]
                                                   : gains[0] - kAlike;
  std::vector<double> best(gains.begin() + 1, gains.end());
  std::sort(best.begin(), best.end(), std::greater<>());
  if (wanted != Wanted::kAlike && best.size() > kTried) least = std::max(least, best[kTried - 1]);
  // The class of another effect was looked for: the best one's own shape may stand elsewhere by a simpler name.
  const size_t leader = static_cast<size_t>(std::max_element(gains.begin(), gains.end()) - gains.begin());
  if (leader > 0) {
    const int complexity = Complexity(machine_, members[leader]);
    std::vector<Candidate> siblings = SiblingsOf(joint.problem, lacking.model, members[leader], members);
    std::erase_if(siblings, [&](const Candidate& one) { return Complexity(machine_, one) >= complexity; });
    const std::vector<Projection> of_siblings = signatures.Project(siblings);
    for (size_t m = 0; m < siblings.size(); ++m) {
      if (of_siblings[m].visible <= kVisible) continue;
      Eigen::Vector3d amplitude;
      gains.push_back(Gain(of_siblings[m], &amplitude));
      for (int b = 0; b < of_siblings[m].columns; ++b) siblings[m].term.amplitude[b] = amplitude[b];
      members.push_back(siblings[m]);
    }
  }
  std::vector<Candidate> contenders;
  for (size_t m = 1; m < members.size(); ++m) {
    const auto& amplitude = members[m].term.amplitude;
    if (gains[m] >= least && IsPlausible(signatures, members[m], {amplitude[0], amplitude[1], 0.0}))
      contenders.push_back(members[m]);
  }
  std::stable_sort(contenders.begin(), contenders.end(), [this](const Candidate& a, const Candidate& b) {
    return Complexity(machine_, a) < Complexity(machine_, b);
  });
  if (wanted == Wanted::kAlike) contenders.resize(std::min(kTried, contenders.size()));
  return contenders;
}

// A slip in a fit session that explains more than effect i does in `joint`, by more than `margin`. In the fit
// sessions a name is preferred to a slip that explains as much. If the name is wrong, the check sessions reject one
// member of its class after the other until one is left that they hardly see: then the slip is right.
std::optional<Candidate> Validation::SlipInstead(size_t i, double margin, const Fit& fit, const Fit& joint) const {
  const int term = extension().TermOf(i);
  identify::Point lacking = joint.point;
  lacking.model.terms.erase(lacking.model.terms.begin() + term);
  const Signatures signatures(joint.problem, lacking, identify::ListParameters(lacking.model, true));
  std::vector<Candidate> slips = MakeDictionary(joint.problem, lacking.model);
  std::erase_if(slips, [&fit](const Candidate& one) {
    return one.family != Family::kStep || one.run >= static_cast<int>(fit.problem.runs.size());
  });
  if (slips.empty()) return std::nullopt;
  Candidate own;
  own.term = joint.result.model.terms[term];
  const Candidate best = BestOf(signatures, slips);
  Candidate slip = AtBestMoment(signatures, best, kAlike);
  const std::vector<Projection> projections = signatures.Project({own, slip});
  Eigen::Vector3d amplitude;
  const double gain = Gain(projections[0], &amplitude);
  if (Gain(projections[1], &amplitude) < gain + margin) return std::nullopt;
  // Set-ups that stand far off without the effect are no place to estimate from.
  constexpr double kShare = 0.1;
  if (std::abs(signatures.residual_squares() - gain - SquaresOf(joint)) > kShare * gain) return std::nullopt;
  return WithCarrierTold(signatures, slip, kAlike);
}

absl::Status Validation::PutSlip(size_t i, double margin, Fit* fit) {
  ASSIGN_OR_RETURN(const std::optional<Fit> joint, Joint(*fit));
  if (!joint.has_value()) return absl::OkStatus();
  const std::optional<Candidate> slip = SlipInstead(i, margin, *fit, *joint);
  if (!slip.has_value()) return absl::OkStatus();
  const std::vector<Added> named = effects();
  effects()[i] = {*slip, named[i].score, {}, {}};
  return Change(named, fit).status();
}

// Puts the member of effect i's class in its place that all sessions together speak for most; false when none does
// better than the effect itself.
absl::StatusOr<bool> Validation::Replace(size_t i, const Fit& fit, const Fit& joint) {
  std::vector<std::pair<double, Candidate>> tried;
  double lowest = INFINITY;
  for (const Candidate& member :
       Contenders(i, joint, check_.IsExplained(joint, fit) ? Wanted::kBetter : Wanted::kNearlyAsGood)) {
    ErrorModel model = joint.result.model;
    model.terms[extension().TermOf(i)] = member.term;
    const absl::StatusOr<Fit> replaced = Refit(joint, model, identify_options_);
    if (absl::IsCancelled(replaced.status())) return replaced.status();
    if (!replaced.ok()) continue;  // a member that does not fit is no alternative
    tried.push_back({SquaresOf(*replaced), member});
    lowest = std::min(lowest, tried.back().first);
  }
  if (!(lowest < SquaresOf(joint) - kSpeaksAgainst)) return false;
  // Of those that the sessions do not tell from the best, the simplest: members come in that order.
  const Candidate best =
      std::find_if(tried.begin(), tried.end(), [&](const auto& one) { return one.first < lowest + kAlike; })->second;
  Added& effect = effects()[i];
  const Candidate before = effect.candidate;
  const auto is_it = [&](const Candidate& one) { return IsSameEffect(one.term, best.term); };
  effect.candidate = best;
  std::erase_if(effect.equivalent, is_it);
  std::erase_if(effect.rivals, is_it);
  effect.equivalent.push_back(before);
  AddSiblings(i, joint);
  return true;
}

// The class of another effect was looked for: alike the new effect i is its own shape on other joints, too.
void Validation::AddSiblings(size_t i, const Fit& joint) {
  Added& effect = effects()[i];
  identify::Point lacking = joint.point;
  lacking.model.terms.erase(lacking.model.terms.begin() + extension().TermOf(i));
  const Signatures signatures(joint.problem, lacking, identify::ListParameters(lacking.model, true));
  std::vector<Candidate> members = {effect.candidate};
  members.insert(members.end(), effect.equivalent.begin(), effect.equivalent.end());
  const std::vector<Candidate> siblings = SiblingsOf(joint.problem, lacking.model, effect.candidate, members);
  members.resize(1);
  members.insert(members.end(), siblings.begin(), siblings.end());
  const std::vector<Projection> projections = signatures.Project(members);
  Eigen::Vector3d amplitude;
  const double own = Gain(projections[0], &amplitude);
  for (size_t m = 1; m < members.size(); ++m) {
    if (projections[m].visible <= kVisible || Gain(projections[m], &amplitude) < own - kAlike) continue;
    if (IsPlausible(signatures, members[m], amplitude)) effect.equivalent.push_back(members[m]);
  }
}

}  // namespace axiscal::loop
