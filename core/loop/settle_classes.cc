#include "core/loop/settle_classes.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/loop/dictionary.h"
#include "core/loop/fitting.h"
#include "core/loop/refine.h"
#include "core/loop/same_always.h"
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
  std::vector<std::pair<double, size_t>> best_first;
  for (size_t i = 0; i < others.size(); ++i) {
    if (projections[i].visible <= kVisible) continue;
    Eigen::Vector3d amplitude;
    const double gain = Gain(projections[i], &amplitude);
    if (gain >= own - indistinguishable && IsPlausible(signatures, others[i], amplitude))
      best_first.push_back({-gain, i});
  }
  std::sort(best_first.begin(), best_first.end());
  std::vector<Candidate> alike;
  for (const auto& [gain, i] : best_first) alike.push_back(others[i]);
  constexpr double kRelated = 0.7;
  const std::vector<double> correlations = signatures.CorrelationsWith(members[0], alike);
  std::vector<Candidate> related;
  for (size_t i = 0; i < alike.size(); ++i) {
    if (correlations[i] > kRelated) related.push_back(alike[i]);
  }
  return related;
}

// Chi-square with another effect in the place of the model's `term`, everything refitted. NAN where nothing fits,
// infinite for a warming that becomes any drift once it is slow enough, or a spike any backlash: as what they then are.
absl::StatusOr<double> SquaresWith(const Fit& fit, int term, const machine::ErrorTerm& other,
                                   const identify::Options& options) {
  machine::ErrorModel model = fit.result.model;
  model.terms[term] = other;
  const absl::StatusOr<Fit> swapped = Refit(fit, model, options);
  if (absl::IsCancelled(swapped.status())) return swapped.status();
  if (!swapped.ok()) return NAN;
  if (StraightFormOf(swapped->problem, swapped->result.model.terms[term])) return INFINITY;
  return SquaresOf(*swapped);
}

// What the linear estimate says of effects in the place of the model's `term`.
struct Estimate {
  std::vector<bool> is_alike;   // per member of the class
  std::vector<Candidate> more;  // what is not in it
};

// None where it says nothing: without the effect set-ups stand far off, or nothing fits at all.
absl::StatusOr<std::optional<Estimate>> EstimateOf(const Fit& fit, int term, const std::vector<Candidate>& members,
                                                   const SearchOptions& search, const identify::Options& options) {
  machine::ErrorModel lacking = fit.result.model;
  lacking.terms.erase(lacking.terms.begin() + term);
  const absl::StatusOr<Fit> reduced = Refit(fit, lacking, options);
  if (absl::IsCancelled(reduced.status())) return reduced.status();
  if (!reduced.ok()) return std::nullopt;
  const Signatures signatures(reduced->problem, reduced->point, identify::ListParameters(reduced->point.model, true));
  const std::vector<Projection> projections = signatures.Project(members);
  Eigen::Vector3d amplitude;
  const double own = Gain(projections[0], &amplitude), explained = SquaresOf(*reduced) - SquaresOf(fit);
  constexpr double kWrong = 0.05;
  if (std::abs(own - explained) > kWrong * explained) return std::nullopt;
  Estimate estimate;
  for (const Projection& one : projections) estimate.is_alike.push_back(Gain(one, &amplitude) >= own - kToldApart);
  estimate.more = AsGoodAs(*reduced, signatures, members, own, search.indistinguishable);
  return estimate;
}

// Members that are alike by linear estimate stay unasked; of others, and of what is to come into the class, the full
// refit says. One of those that are the same by another name speaks for all.
absl::Status Settle(const Fit& fit, int term, const SearchOptions& search, const identify::Options& options,
                    Added* added) {
  std::vector<Candidate> members = {added->candidate};
  members[0].term = fit.result.model.terms[term];
  members.insert(members.end(), added->equivalent.begin(), added->equivalent.end());
  ASSIGN_OR_RETURN(const std::optional<Estimate> estimate, EstimateOf(fit, term, members, search, options));
  const size_t known = members.size();
  if (estimate) members.insert(members.end(), estimate->more.begin(), estimate->more.end());
  std::vector<machine::ErrorTerm> terms;
  for (const Candidate& one : members) terms.push_back(one.term);
  const std::vector<int> first = FirstOfTheSame(*fit.problem.machine, fit.problem.runs.front().tip_mm, terms);
  const double squares = SquaresOf(fit);
  std::vector<double> with(members.size(), squares);
  constexpr int kMostNew = 12;
  int asked_new = 0;
  added->equivalent.clear();
  for (size_t i = 1; i < members.size(); ++i) {
    const bool is_known = i < known;
    if (first[i] < static_cast<int>(i)) {
      with[i] = with[first[i]];
    } else if (!is_known && ++asked_new > kMostNew) {
      with[i] = INFINITY;
    } else if (!is_known || !estimate || !estimate->is_alike[i]) {
      ASSIGN_OR_RETURN(with[i], SquaresWith(fit, term, terms[i], options));
    }
    if (is_known && with[i] > squares + kToldApart) {
      added->rivals.push_back(members[i]);
    } else if (is_known || with[i] < squares + search.indistinguishable) {
      added->equivalent.push_back(members[i]);
    }
  }
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
