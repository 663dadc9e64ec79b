// Growth: effects that were alike when one of them was added change places once more is known.
#include <algorithm>
#include <optional>

#include "core/loop/dictionary.h"
#include "core/loop/fitting.h"
#include "core/loop/growth.h"
#include "core/loop/refine.h"

namespace axiscal::loop {

using identify::Fit;
using machine::ErrorModel;

absl::Status Growth::Swap(Fit* fit) {
  for (size_t i = 0; i < effects().size(); ++i) {
    const Added& added = effects()[i];
    if (added.candidate.family == Family::kStep || added.equivalent.size() + added.rivals.size() == 0) continue;
    const Extension before = extension();
    ASSIGN_OR_RETURN(const bool is_swapped, SwapOne(i, fit));
    if (!is_swapped) continue;
    ASSIGN_OR_RETURN(const bool is_fitted, Change(before, fit));
    if (!is_fitted) continue;
    attempt_->Note(SelectionStep::kReplaced, extension().NameOf(i), *fit);
  }
  return absl::OkStatus();
}

std::vector<Scored> Growth::ScoreOf(const Signatures& signatures, const std::vector<Candidate>& members) const {
  std::vector<Scored> scored;
  const std::vector<Projection> projections = signatures.Project(members);
  for (size_t k = 0; k < members.size(); ++k) {
    Scored one;
    one.candidate = members[k];
    if (projections[k].visible > kVisible) {
      const double gain = Gain(projections[k], &one.amplitude);
      one.likelihood_ratio = LikelihoodRatio(signatures.residual_squares(), gain, signatures.degrees_of_freedom());
      one.score = one.likelihood_ratio - options_.search.per_column * (projections[k].columns - 1);
    }
    scored.push_back(std::move(one));
  }
  return scored;
}

// Effects that were found since may decide between the members of an earlier class: the member that fits clearly better
// takes the place, and its class is determined anew.
absl::StatusOr<bool> Growth::SwapOne(size_t effect, Fit* fit) {
  Added changed = effects()[effect];
  ErrorModel lacking = fit->result.model;
  const int term = extension().TermOf(effect);
  lacking.terms.erase(lacking.terms.begin() + term);
  const absl::StatusOr<Fit> reduced = Refit(*fit, lacking, identify_options_);
  if (absl::IsCancelled(reduced.status())) return reduced.status();
  if (!reduced.ok()) return false;
  const Signatures signatures(reduced->problem, reduced->point, identify::ListParameters(reduced->point.model, true));
  std::vector<Candidate> members = {changed.candidate};
  members[0].term = fit->result.model.terms[term];  // its decay length or frequency as refitted
  members.insert(members.end(), changed.equivalent.begin(), changed.equivalent.end());
  members.insert(members.end(), changed.rivals.begin(), changed.rivals.end());
  for (size_t k = 1; k < members.size(); ++k) {
    const bool is_alike = members[k].family == members[0].family &&
                          shapes::VariableAxis(members[k].term.shape) == shapes::VariableAxis(members[0].term.shape);
    // A pitch of the same component that passes for the effect's own stays where it is.
    const bool is_alias = members[k].family == Family::kPitch && members[k].term.joint == members[0].term.joint &&
                          members[k].term.component == members[0].term.component;
    if (is_alike && !is_alias && IsGrid(members[k].family))
      members[k] = AtPlaceOf(signatures, members[k], {members[0]});
  }
  std::vector<Scored> scored = ScoreOf(signatures, members);
  const double own = scored[0].likelihood_ratio;
  const auto better = [](const Scored& a, const Scored& b) { return a.likelihood_ratio > b.likelihood_ratio; };
  std::stable_sort(scored.begin(), scored.end(), better);
  Finding finding = ClassOf(machine_, signatures, scored, options_.search);
  if (finding.effect.likelihood_ratio > own + options_.search.indistinguishable) {
    // The class of another effect was looked for: what is alike the new one is its own shape on other joints.
    const std::vector<Scored> siblings =
        ScoreOf(signatures, SiblingsOf(reduced->problem, reduced->point.model, finding.effect.candidate, members));
    scored.insert(scored.end(), siblings.begin(), siblings.end());
    std::stable_sort(scored.begin(), scored.end(), better);
    finding = ClassOf(machine_, signatures, scored, options_.search);
  }
  bool is_swapped = false;
  if (finding.effect.likelihood_ratio > own + options_.search.indistinguishable) {
    ErrorModel other = fit->result.model;
    other.terms[term] = finding.effect.candidate.term;
    const absl::StatusOr<Fit> swapped = Refit(*fit, other, identify_options_);
    if (absl::IsCancelled(swapped.status())) return swapped.status();
    is_swapped = swapped.ok() && SquaresOf(*swapped) < SquaresOf(*fit) - options_.search.indistinguishable;
  }
  if (is_swapped) changed.candidate = finding.effect.candidate;
  finding.equivalent.insert(finding.equivalent.begin(), finding.effect);
  SetClass(finding, &changed);
  effects()[effect] = std::move(changed);
  return is_swapped;
}

namespace {

bool ActsAlike(const Candidate& a, const Candidate& b) {
  return !IsUnnamed(a.family) && !IsUnnamed(b.family) && a.term.joint == b.term.joint &&
         a.term.component == b.term.component &&
         shapes::VariableAxis(a.term.shape) == shapes::VariableAxis(b.term.shape);
}

}  // namespace

// The search may have put together one shape from several others of the same component and variable.
absl::StatusOr<bool> Growth::Consolidate(Fit* fit) {
  for (size_t first = 0; first < effects().size(); ++first) {
    std::vector<Added> rest = effects();
    const Candidate leader = rest[first].candidate;
    std::erase_if(rest, [&leader](const Added& one) { return ActsAlike(one.candidate, leader); });
    const size_t parts = effects().size() - rest.size();
    if (parts < 2) continue;
    ErrorModel lacking = fit->result.model;
    for (size_t i = effects().size(); i-- > 0;) {
      if (ActsAlike(effects()[i].candidate, leader)) lacking.terms.erase(lacking.terms.begin() + extension().TermOf(i));
    }
    const absl::StatusOr<Fit> reduced = Refit(*fit, lacking, identify_options_);
    if (absl::IsCancelled(reduced.status())) return reduced.status();
    if (!reduced.ok()) continue;
    std::vector<Candidate> members = MakeDictionary(reduced->problem, lacking);
    std::erase_if(members, [&leader](const Candidate& one) { return !ActsAlike(one, leader); });
    if (members.empty()) continue;
    const Signatures signatures(reduced->problem, reduced->point, identify::ListParameters(reduced->point.model, true));
    const Candidate one = BestOf(signatures, members);
    ErrorModel model = lacking;
    model.terms.push_back(one.term);
    const absl::StatusOr<Fit> whole = Refit(*fit, model, identify_options_);
    if (absl::IsCancelled(whole.status())) return whole.status();
    // Each part had to be worth as much as the evidence that an effect needs; so must all but one together.
    const double worth = options_.search.evidence * static_cast<double>(parts - 1);
    if (!whole.ok() || SquaresOf(*whole) > SquaresOf(*fit) + worth) continue;
    const Extension before = extension();
    Finding finding = ClassOf(machine_, signatures, ScoreOf(signatures, SiblingsOf(reduced->problem, lacking, one, {})),
                              options_.search);
    Added merged;
    merged.candidate = one;
    merged.score = finding.effect.score;
    finding.equivalent.insert(finding.equivalent.begin(), finding.effect);
    SetClass(finding, &merged);
    rest.insert(rest.begin() + static_cast<std::ptrdiff_t>(std::min(first, rest.size())), std::move(merged));
    effects() = std::move(rest);
    ASSIGN_OR_RETURN(const bool is_fitted, Change(before, fit));
    if (!is_fitted) continue;
    attempt_->Note(SelectionStep::kReplaced, extension().NameOf(std::min(first, effects().size() - 1)), *fit);
    return true;
  }
  return false;
}

// When two effects were added in place of a single other one, each explains a part, and a part of the first one's worth
// has moved to the second. Where one effect explains what the two do, it takes their place.
absl::StatusOr<bool> Growth::TakeOneForTwo(Fit* fit) {
  constexpr double kGone = 0.5;
  constexpr int kMostPairs = 4;
  std::vector<std::pair<double, size_t>> gone;  // what is left of its worth, effect
  for (size_t i = 0; i < effects().size(); ++i) {
    if (IsUnnamed(effects()[i].candidate.family)) continue;
    const double left = EvidenceOf(*fit, extension().TermOf(i)) / effects()[i].score;
    if (left < kGone) gone.push_back({left, i});
  }
  std::sort(gone.begin(), gone.end());
  std::vector<std::pair<size_t, size_t>> pairs;
  for (const auto& [left, i] : gone) {
    for (size_t k = 0; k < effects().size(); ++k) {
      const std::pair<size_t, size_t> pair = std::minmax(i, k);
      if (k == i || IsUnnamed(effects()[k].candidate.family)) continue;
      if (std::find(pairs.begin(), pairs.end(), pair) == pairs.end()) pairs.push_back(pair);
    }
  }
  if (pairs.size() > kMostPairs) pairs.resize(kMostPairs);
  for (const std::pair<size_t, size_t>& pair : pairs) {
    const size_t first = pair.first, second = pair.second;
    ErrorModel lacking = fit->result.model;
    lacking.terms.erase(lacking.terms.begin() + extension().TermOf(second));
    lacking.terms.erase(lacking.terms.begin() + extension().TermOf(first));
    const absl::StatusOr<Fit> reduced = Refit(*fit, lacking, identify_options_);
    if (absl::IsCancelled(reduced.status())) return reduced.status();
    if (!reduced.ok()) continue;
    const Signatures signatures(reduced->problem, reduced->point, identify::ListParameters(reduced->point.model, true));
    std::vector<Candidate> others = MakeDictionary(reduced->problem, reduced->point.model);
    std::erase_if(others, [&](const Candidate& one) {
      return IsUnnamed(one.family) || IsSameEffect(one.term, effects()[first].candidate.term) ||
             IsSameEffect(one.term, effects()[second].candidate.term);
    });
    const SearchResult found = Search(machine_, signatures, others, options_.search);
    if (!found.is_significant) continue;
    ErrorModel model = lacking;
    model.terms.push_back(found.finding.effect.candidate.term);
    const absl::StatusOr<Fit> whole = Refit(*fit, model, identify_options_);
    if (absl::IsCancelled(whole.status())) return whole.status();
    if (!whole.ok() || SquaresOf(*whole) > SquaresOf(*fit) + options_.search.evidence) continue;
    const machine::ErrorTerm& fitted = whole->result.model.terms.back();
    if (!IsPlausible(signatures, {found.finding.effect.candidate.family, fitted},
                     {fitted.amplitude[0], fitted.amplitude[1], 0.0}))
      continue;
    const std::string dropped = extension().NameOf(second);
    const Extension before = extension();
    Added merged;
    merged.candidate = found.finding.effect.candidate;
    for (int b = 0; b < kMostAmplitudes; ++b) merged.candidate.term.amplitude[b] = found.finding.effect.amplitude[b];
    merged.score = found.finding.effect.score;
    SetClass(found.finding, &merged);
    effects()[first] = std::move(merged);
    effects().erase(effects().begin() + static_cast<std::ptrdiff_t>(second));
    ASSIGN_OR_RETURN(const bool is_fitted, Change(before, fit));
    if (!is_fitted) continue;
    attempt_->Note(SelectionStep::kDropped, dropped, *fit);
    attempt_->Note(SelectionStep::kReplaced, extension().NameOf(first), *fit);
    return true;
  }
  return false;
}

namespace {

bool GoesWithTime(Family family) { return family == Family::kDrift || family == Family::kThermal; }
bool GoesWithSense(Family family) { return family == Family::kBacklash || family == Family::kLag; }

}  // namespace

absl::StatusOr<bool> Growth::Straighten(Fit* fit) {
  for (size_t i = 0; i < effects().size(); ++i) {
    const machine::ErrorTerm& term = fit->point.model.terms[extension().TermOf(i)];
    if (IsUnnamed(effects()[i].candidate.family)) continue;
    const std::optional<Candidate> form = StraightFormOf(fit->problem, term);
    if (!form) continue;
    const Extension before = extension();
    ErrorModel lacking = fit->result.model;
    lacking.terms.erase(lacking.terms.begin() + extension().TermOf(i));
    Added plain;
    plain.candidate = *form;
    plain.score = before.effects[i].score;
    const auto is_alike = GoesWithTime(form->family) ? GoesWithTime : GoesWithSense;
    for (const Candidate& one : MakeDictionary(fit->problem, lacking)) {
      if (is_alike(one.family) && one.term.component == term.component && !IsSameEffect(one.term, form->term))
        plain.equivalent.push_back(one);
    }
    effects()[i] = std::move(plain);
    ASSIGN_OR_RETURN(const bool is_fitted, Change(before, fit));
    if (!is_fitted) continue;
    attempt_->Note(SelectionStep::kReplaced, extension().NameOf(i), *fit);
    RETURN_IF_ERROR(Swap(fit));
    return true;
  }
  return false;
}

}  // namespace axiscal::loop
