#include "core/loop/validation.h"

#include <algorithm>
#include <cmath>

#include "core/loop/fitting.h"

namespace axiscal::loop {

using identify::Fit;
using machine::ErrorModel;

absl::StatusOr<bool> Validation::Run(Fit* fit) {
  bool has_replaced = false;
  if (check_.is_empty() || effects().empty()) return has_replaced;
  RETURN_IF_ERROR(check_.Settle(*fit));
  for (size_t i = effects().size(); i-- > 0;) {
    if (IsUnnamed(effects()[i].candidate.family)) continue;
    std::vector<Added> without = effects();
    without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
    ErrorModel lacking = fit->result.model;
    lacking.terms.erase(lacking.terms.begin() + extension().TermOf(i));
    ASSIGN_OR_RETURN(const Fit reduced, Refit(*fit, lacking, identify_options_));
    ASSIGN_OR_RETURN(const double squares_without, check_.Squares(reduced.result.model));
    ASSIGN_OR_RETURN(const double squares_with, check_.Squares(fit->result.model));
    constexpr double kSpeaksAgainst = 9.0;  // chi-square units
    const bool speaks_against = squares_with > squares_without + kSpeaksAgainst || !std::isfinite(squares_with);
    if (!speaks_against && check_.IsAdequate(squares_with)) continue;
    // Of effects that the fit sessions could not tell apart another may be the one.
    ASSIGN_OR_RETURN(const bool is_replaced, Replace(i, std::min(squares_without, squares_with - kSpeaksAgainst), fit));
    if (!is_replaced && !speaks_against) continue;
    if (!is_replaced) {
      attempt_->report.withdrawn.push_back(extension().NameOf(i));
      effects() = std::move(without);
    }
    has_replaced = has_replaced || is_replaced;
    ASSIGN_OR_RETURN(*fit, FitExtension(machine_, extension(), identify_options_));
    attempt_->Note(is_replaced ? Step::kReplaced : Step::kWithdrawn,
                   is_replaced ? extension().NameOf(i) : attempt_->report.withdrawn.back(), *fit);
    RETURN_IF_ERROR(check_.Settle(*fit));
  }
  return has_replaced;
}

// Puts the member of effect i's class in its place that the check sessions speak for most; false when none leaves
// less than `least` of their squares.
absl::StatusOr<bool> Validation::Replace(size_t i, double least, Fit* fit) {
  constexpr size_t kTried = 40;
  std::vector<Candidate> members = effects()[i].equivalent;
  members.insert(members.end(), effects()[i].rivals.begin(), effects()[i].rivals.end());
  members.resize(std::min(kTried, members.size()));
  std::vector<Added> best;
  for (const Candidate& member : members) {
    ErrorModel model = fit->result.model;
    model.terms[extension().TermOf(i)] = member.term;
    const absl::StatusOr<Fit> replaced = Refit(*fit, model, identify_options_);
    if (absl::IsCancelled(replaced.status())) return replaced.status();
    if (!replaced.ok()) continue;  // a member that does not fit is no alternative
    ASSIGN_OR_RETURN(const double squares, check_.Squares(replaced->result.model));
    if (squares >= least) continue;
    least = squares;
    best = effects();
    best[i].candidate = member;
    const auto is_it = [&](const Candidate& one) { return IsSameEffect(one.term, member.term); };
    std::erase_if(best[i].equivalent, is_it);
    std::erase_if(best[i].rivals, is_it);
    best[i].equivalent.push_back(effects()[i].candidate);
  }
  if (best.empty()) return false;
  effects() = std::move(best);
  return true;
}

}  // namespace axiscal::loop
