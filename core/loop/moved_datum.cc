#include "core/loop/moved_datum.h"

#include <algorithm>
#include <utility>

#include "core/identify/datum.h"
#include "core/loop/fitting.h"

namespace axiscal::loop {
namespace {

using reports::DatumMoved;

// What explains an effect explains it to the readings' noise; what only looks like it leaves more.
constexpr double kAllOfIt = 0.9;

// Of the model without the terms `left_out`.
absl::StatusOr<std::vector<reports::WarningFacts>> DatumWithout(const std::vector<size_t>& left_out,
                                                                const identify::Fit& fit, const Extension& extension,
                                                                const identify::Options& options) {
  machine::ErrorModel model = fit.point.model;
  std::vector<int> terms;
  std::vector<std::string> names;
  for (const size_t effect : left_out) {
    terms.push_back(extension.TermOf(effect));
    names.push_back(extension.NameOf(effect));
  }
  std::sort(terms.rbegin(), terms.rend());
  for (const int term : terms) model.terms.erase(model.terms.begin() + term);
  const absl::StatusOr<identify::Fit> smaller = Refit(fit, model, options);
  if (absl::IsCancelled(smaller.status())) return smaller.status();
  if (!smaller.ok()) return std::vector<reports::WarningFacts>();
  std::vector<reports::WarningFacts> found = identify::FindMovedDatum(*smaller, kAllOfIt);
  for (reports::WarningFacts& facts : found) std::get<DatumMoved>(facts).in_place_of = names;
  return found;
}

}  // namespace

absl::StatusOr<std::vector<reports::WarningFacts>> ProposeDatum(const identify::Fit& fit, const Extension& extension,
                                                                const identify::Options& options) {
  if (identify::CountSetups(fit.problem) < 2) return std::vector<reports::WarningFacts>();
  std::vector<reports::WarningFacts> found = identify::FindMovedDatum(fit);
  if (!found.empty()) return found;
  std::vector<size_t> effects;
  for (size_t i = 0; i < extension.effects.size(); ++i) {
    if (extension.effects[i].candidate.family != Family::kStep) effects.push_back(i);
  }
  if (effects.size() > 1) {
    ASSIGN_OR_RETURN(found, DatumWithout(effects, fit, extension, options));
    if (!found.empty()) return found;
  }
  for (const size_t effect : effects) {
    ASSIGN_OR_RETURN(std::vector<reports::WarningFacts> of_one, DatumWithout({effect}, fit, extension, options));
    std::move(of_one.begin(), of_one.end(), std::back_inserter(found));
  }
  return found;
}

}  // namespace axiscal::loop
