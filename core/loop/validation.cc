#include "core/loop/validation.h"

#include <algorithm>
#include <cmath>

#include "core/loop/fitting.h"
#include "core/loop/same_always.h"

namespace axiscal::loop {

using identify::Fit;
using machine::ErrorModel;

namespace {

constexpr double kSpeaksAgainst = 9.0;  // chi-square units

}  // namespace

absl::StatusOr<bool> Validation::Run(Fit* fit) {
  bool has_replaced = false;
  if (check_.is_empty() || effects().empty()) return has_replaced;
  RETURN_IF_ERROR(check_.Settle(*fit));
  // Of effects that the fit sessions could not tell apart another may be the one: the largest first, since what is
  // wrong there bends all that was found beside it.
  for (size_t i = 0; i < effects().size(); ++i) {
    if (IsUnnamed(effects()[i].candidate.family)) continue;
    ASSIGN_OR_RETURN(const double squares, check_.Squares(fit->result.model));
    if (check_.IsAdequate(squares)) break;
    ASSIGN_OR_RETURN(const double squares_without, SquaresWithout(i, *fit, nullptr));
    const std::vector<Added> before = effects();
    ASSIGN_OR_RETURN(const bool is_replaced, Replace(i, std::min(squares_without, squares - kSpeaksAgainst), *fit));
    if (!is_replaced) continue;
    ASSIGN_OR_RETURN(const bool is_fitted, Change(before, fit));
    if (!is_fitted) continue;
    has_replaced = true;
    attempt_->Note(Step::kReplaced, extension().NameOf(i), *fit);
  }
  for (size_t i = effects().size(); i-- > 0;) {
    if (IsUnnamed(effects()[i].candidate.family)) continue;
    ASSIGN_OR_RETURN(const double squares, check_.Squares(fit->result.model));
    double worth = 0.0;
    ASSIGN_OR_RETURN(const double squares_without, SquaresWithout(i, *fit, &worth));
    if (!std::isfinite(squares) && !std::isfinite(squares_without)) continue;  // they say nothing of it
    // What is plain in the fit sessions is not wrong because what stands beside it disturbs the check sessions a
    // little.
    constexpr double kLittle = 0.1;
    if (!(squares > squares_without + std::max(kSpeaksAgainst, kLittle * worth))) continue;
    const std::vector<Added> before = effects();
    const std::string name = extension().NameOf(i);
    // A member that the check sessions cannot see is better than none: the fit sessions do see it.
    ASSIGN_OR_RETURN(const bool is_replaced, Replace(i, squares_without + kSpeaksAgainst, *fit));
    if (!is_replaced) effects().erase(effects().begin() + static_cast<std::ptrdiff_t>(i));
    ASSIGN_OR_RETURN(const bool is_fitted, Change(before, fit));
    if (!is_fitted) continue;
    has_replaced = has_replaced || is_replaced;
    if (!is_replaced) attempt_->report.withdrawn.push_back(name);
    attempt_->Note(is_replaced ? Step::kReplaced : Step::kWithdrawn, is_replaced ? extension().NameOf(i) : name, *fit);
  }
  return has_replaced;
}

absl::StatusOr<double> Validation::SquaresWithout(size_t effect, const Fit& fit, double* worth) const {
  ErrorModel lacking = fit.result.model;
  lacking.terms.erase(lacking.terms.begin() + extension().TermOf(effect));
  const absl::StatusOr<Fit> reduced = Refit(fit, lacking, identify_options_);
  if (absl::IsCancelled(reduced.status())) return reduced.status();
  if (!reduced.ok()) return INFINITY;
  if (worth != nullptr) *worth = SquaresOf(*reduced) - SquaresOf(fit);
  return check_.Squares(reduced->result.model);
}

// Fits the changed extension; false, and the effects as they were, where that does not converge.
absl::StatusOr<bool> Validation::Change(const std::vector<Added>& before, Fit* fit) {
  absl::StatusOr<Fit> changed = FitExtension(machine_, extension(), identify_options_);
  if (absl::IsCancelled(changed.status())) return changed.status();
  if (!changed.ok()) {
    effects() = before;
    return false;
  }
  *fit = *std::move(changed);
  RETURN_IF_ERROR(check_.Settle(*fit));
  return true;
}

// Puts the member of effect i's class in its place that the check sessions speak for most; false when none leaves
// less than `least` of their squares.
absl::StatusOr<bool> Validation::Replace(size_t i, double least, const Fit& fit) {
  constexpr size_t kTried = 24;
  std::vector<Candidate> all = {effects()[i].candidate};
  all.insert(all.end(), effects()[i].equivalent.begin(), effects()[i].equivalent.end());
  all.insert(all.end(), effects()[i].rivals.begin(), effects()[i].rivals.end());
  std::vector<machine::ErrorTerm> terms;
  for (const Candidate& one : all) terms.push_back(one.term);
  // One effect by two names says the same to any session.
  const std::vector<int> first = FirstOfTheSame(machine_, fit.problem.runs.front().tip_mm, terms);
  std::vector<Candidate> members;
  for (size_t m = 1; m < all.size() && members.size() < kTried; ++m) {
    if (first[m] == static_cast<int>(m)) members.push_back(all[m]);
  }
  std::vector<std::pair<double, Candidate>> tried;
  for (const Candidate& member : members) {
    ErrorModel model = fit.result.model;
    model.terms[extension().TermOf(i)] = member.term;
    const absl::StatusOr<Fit> replaced = Refit(fit, model, identify_options_);
    if (absl::IsCancelled(replaced.status())) return replaced.status();
    if (!replaced.ok()) continue;  // a member that does not fit is no alternative
    ASSIGN_OR_RETURN(const double squares, check_.Squares(replaced->result.model));
    if (squares < least) tried.push_back({squares, member});
  }
  if (tried.empty()) return false;
  double lowest = INFINITY;
  for (const auto& [squares, member] : tried) lowest = std::min(lowest, squares);
  // Of those that the check sessions do not tell from the best, the simplest: members come in that order.
  constexpr double kAlike = 1.0;
  const Candidate best =
      std::find_if(tried.begin(), tried.end(), [&](const auto& one) { return one.first < lowest + kAlike; })->second;
  Added& effect = effects()[i];
  const Candidate before = effect.candidate;
  const auto is_it = [&](const Candidate& one) { return IsSameEffect(one.term, best.term); };
  effect.candidate = best;
  std::erase_if(effect.equivalent, is_it);
  std::erase_if(effect.rivals, is_it);
  effect.equivalent.push_back(before);
  return true;
}

}  // namespace axiscal::loop
