// Growth: effects that were alike when one of them was added change places once more is known.
#include <algorithm>

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
    const Added before = added;
    ASSIGN_OR_RETURN(const bool is_swapped, SwapOne(i, fit));
    if (!is_swapped) continue;
    absl::StatusOr<Fit> swapped = FitExtension(machine_, extension(), identify_options_);
    if (absl::IsCancelled(swapped.status())) return swapped.status();
    if (!swapped.ok()) {
      effects()[i] = before;
      continue;
    }
    *fit = *std::move(swapped);
    attempt_->Note(Step::kReplaced, extension().NameOf(i), *fit);
  }
  return absl::OkStatus();
}

// Among effects that were alike when one of them was added, the others that have been found since may tell: the
// member that fits clearly better takes the place, and the class is what is alike now.
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
    if (is_alike && IsGrid(members[k].family)) members[k] = AtPlaceOf(signatures, members[k], {members[0]});
  }
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
    scored.push_back(one);
  }
  const double own = scored[0].likelihood_ratio;
  std::stable_sort(scored.begin(), scored.end(),
                   [](const Scored& a, const Scored& b) { return a.likelihood_ratio > b.likelihood_ratio; });
  Finding finding = ClassOf(machine_, signatures, scored, options_.search);
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

}  // namespace axiscal::loop
