#include "core/loop/settle_classes.h"

#include <algorithm>

#include "core/loop/dictionary.h"
#include "core/loop/fitting.h"
#include "core/loop/refine.h"
#include "core/loop/signature_scan.h"
#include "core/loop/signatures.h"

namespace axiscal::loop {
namespace {

using identify::Fit;

// Members of the dictionary that by linear estimate explain as much as the effect whose columns stand first in
// `members`, and are related to it. Of scans there are too many to ask each: their aliases are told elsewhere.
std::vector<Candidate> AsGoodAs(const Fit& reduced, const Signatures& signatures, const std::vector<Candidate>& members,
                                double own, double indistinguishable) {
  std::vector<Candidate> others = MakeDictionary(reduced.problem, reduced.point.model);
  std::erase_if(others, [&](const Candidate& one) {
    const auto is_it = [&one](const Candidate& known) { return IsSameEffect(known.term, one.term); };
    return IsUnnamed(one.family) || IsScan(one.family) || IsGrid(one.family) ||
           std::any_of(members.begin(), members.end(), is_it);
  });
  const std::vector<Projection> projections = signatures.Project(others);
  std::vector<Candidate> alike;
  for (size_t i = 0; i < others.size(); ++i) {
    Eigen::Vector3d amplitude;
    if (projections[i].visible <= kVisible || Gain(projections[i], &amplitude) < own - indistinguishable) continue;
    if (IsPlausible(signatures, others[i], amplitude)) alike.push_back(others[i]);
  }
  constexpr double kRelated = 0.7;
  const std::vector<double> correlations = signatures.CorrelationsWith(members[0], alike);
  std::vector<Candidate> related;
  for (size_t i = 0; i < alike.size(); ++i) {
    if (correlations[i] > kRelated) related.push_back(alike[i]);
  }
  return related;
}

// Completes the class of an effect, the model's `term`, and returns which of it explain less by linear estimate, which
// is quick and may be wrong.
absl::StatusOr<std::vector<size_t>> Suspects(const Fit& fit, int term, const SearchOptions& search,
                                             const identify::Options& options, Added* added) {
  machine::ErrorModel lacking = fit.result.model;
  lacking.terms.erase(lacking.terms.begin() + term);
  ASSIGN_OR_RETURN(const Fit reduced, Refit(fit, lacking, options));
  const Signatures signatures(reduced.problem, reduced.point, identify::ListParameters(reduced.point.model, true));
  std::vector<Candidate> members = {added->candidate};
  members[0].term = fit.result.model.terms[term];
  members.insert(members.end(), added->equivalent.begin(), added->equivalent.end());
  const std::vector<Projection> projections = signatures.Project(members);
  Eigen::Vector3d amplitude;
  const double own = Gain(projections[0], &amplitude);
  std::vector<size_t> suspects;
  for (size_t i = 1; i < members.size(); ++i) {
    if (Gain(projections[i], &amplitude) < own - kToldApart) suspects.push_back(i - 1);
  }
  for (Candidate& one : AsGoodAs(reduced, signatures, members, own, search.indistinguishable))
    added->equivalent.push_back(std::move(one));
  return suspects;
}

absl::Status Settle(const Fit& fit, int term, const SearchOptions& search, const identify::Options& options,
                    Added* added) {
  const absl::StatusOr<std::vector<size_t>> suspects = Suspects(fit, term, search, options, added);
  if (absl::IsCancelled(suspects.status())) return suspects.status();
  if (!suspects.ok()) return absl::OkStatus();  // without the effect nothing fits: nothing can be compared
  const double least = SquaresOf(fit) + kToldApart;
  std::vector<bool> is_told(added->equivalent.size(), false);
  for (const size_t i : *suspects) {
    machine::ErrorModel other = fit.result.model;
    other.terms[term] = added->equivalent[i].term;
    const absl::StatusOr<Fit> swapped = Refit(fit, other, options);
    if (absl::IsCancelled(swapped.status())) return swapped.status();
    // A warming becomes any drift once it is slow enough, and a spike any backlash: as what they then are.
    is_told[i] = swapped.ok() && (SquaresOf(*swapped) > least ||
                                  StraightFormOf(swapped->problem, swapped->result.model.terms[term]).has_value());
  }
  std::vector<Candidate> kept;
  for (size_t i = 0; i < is_told.size(); ++i) (is_told[i] ? added->rivals : kept).push_back(added->equivalent[i]);
  added->equivalent = std::move(kept);
  return absl::OkStatus();
}

}  // namespace

absl::Status SettleClasses(const Fit& fit, const SearchOptions& search, const identify::Options& options,
                           Extension* extension) {
  for (size_t i = 0; i < extension->effects.size(); ++i) {
    Added& added = extension->effects[i];
    if (IsUnnamed(added.candidate.family)) continue;
    RETURN_IF_ERROR(Settle(fit, extension->TermOf(i), search, options, &added));
  }
  return absl::OkStatus();
}

}  // namespace axiscal::loop
