#include "core/loop/told_apart.h"

#include "core/loop/fitting.h"
#include "core/loop/signatures.h"

namespace axiscal::loop {
namespace {

using identify::Fit;

// Which of an effect's class explain less than it by linear estimate, which is quick and may be wrong.
absl::StatusOr<std::vector<size_t>> Suspects(const Fit& fit, const Added& added, int term,
                                             const identify::Options& options) {
  machine::ErrorModel lacking = fit.result.model;
  lacking.terms.erase(lacking.terms.begin() + term);
  ASSIGN_OR_RETURN(const Fit reduced, Refit(fit, lacking, options));
  const Signatures signatures(reduced.problem, reduced.point, identify::ListParameters(reduced.point.model, true));
  std::vector<Candidate> members = {added.candidate};
  members[0].term = fit.result.model.terms[term];
  members.insert(members.end(), added.equivalent.begin(), added.equivalent.end());
  const std::vector<Projection> projections = signatures.Project(members);
  Eigen::Vector3d amplitude;
  const double own = Gain(projections[0], &amplitude);
  std::vector<size_t> suspects;
  for (size_t i = 1; i < members.size(); ++i) {
    if (Gain(projections[i], &amplitude) < own - kToldApart) suspects.push_back(i - 1);
  }
  return suspects;
}

absl::Status DropFrom(const Fit& fit, int term, const identify::Options& options, Added* added) {
  const absl::StatusOr<std::vector<size_t>> suspects = Suspects(fit, *added, term, options);
  if (absl::IsCancelled(suspects.status())) return suspects.status();
  if (!suspects.ok()) return absl::OkStatus();  // without the effect nothing fits: nothing can be compared
  const double least = SquaresOf(fit) + kToldApart;
  std::vector<bool> is_told(added->equivalent.size(), false);
  for (const size_t i : *suspects) {
    machine::ErrorModel other = fit.result.model;
    other.terms[term] = added->equivalent[i].term;
    const absl::StatusOr<Fit> swapped = Refit(fit, other, options);
    if (absl::IsCancelled(swapped.status())) return swapped.status();
    is_told[i] = swapped.ok() && SquaresOf(*swapped) > least;
  }
  std::vector<Candidate> kept;
  for (size_t i = 0; i < is_told.size(); ++i) (is_told[i] ? added->rivals : kept).push_back(added->equivalent[i]);
  added->equivalent = std::move(kept);
  return absl::OkStatus();
}

}  // namespace

absl::Status DropToldApart(const Fit& fit, const identify::Options& options, Extension* extension) {
  for (size_t i = 0; i < extension->effects.size(); ++i) {
    Added& added = extension->effects[i];
    if (IsUnnamed(added.candidate.family) || added.equivalent.empty()) continue;
    RETURN_IF_ERROR(DropFrom(fit, extension->TermOf(i), options, &added));
  }
  return absl::OkStatus();
}

}  // namespace axiscal::loop
