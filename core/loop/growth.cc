#include "core/loop/growth.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/units.h"
#include "core/loop/dictionary.h"
#include "core/loop/fitting.h"
#include "core/loop/refine.h"

namespace axiscal::loop {

using identify::Fit;
using machine::ErrorModel;

absl::Status Growth::Extend(Fit* fit) {
  // A dropped effect may be found again, and both ends of each session may be bad: twice their number limits the steps.
  const int most_steps = 2 * (attempt_->way.most_effects + static_cast<int>(fit->problem.runs.size()));
  for (int step = 0; step < most_steps; ++step) {
    if (static_cast<int>(effects().size()) >= attempt_->way.most_effects) {
      attempt_->report.has_stopped_early = attempt_->way.most_effects == options_.max_effects;
      return absl::OkStatus();
    }
    ASSIGN_OR_RETURN(const bool has_found, Forward(fit));
    if (!has_found) {
      // The last effect was not refitted while the others changed.
      ASSIGN_OR_RETURN(const bool is_straight, Straighten(fit));
      if (is_straight) continue;
      ASSIGN_OR_RETURN(const bool has_taken_back, TakeBack(fit));
      const size_t before = effects().size();
      RETURN_IF_ERROR(Prune(fit));
      ASSIGN_OR_RETURN(bool is_simpler, Consolidate(fit));
      if (!is_simpler) {
        ASSIGN_OR_RETURN(is_simpler, TakeOneForTwo(fit));
      }
      if (effects().size() == before && !is_simpler && !has_taken_back) return absl::OkStatus();
      continue;
    }
    RETURN_IF_ERROR(Swap(fit));
    // There is no effect yet where the first one was tried and refused.
    if (!effects().empty()) RETURN_IF_ERROR(Backward(effects().size() - 1, fit));
  }
  return Prune(fit);
}

absl::Status Growth::Prune(Fit* fit) {
  RETURN_IF_ERROR(Backward(effects().size(), fit));
  return DropSlips(fit);
}

namespace {

// The same effect, structure or slip, apart from the exact place that the scan or its refinement gave it.
bool IsNear(const Candidate& a, const Candidate& b) {
  if (a.family != b.family) return false;
  constexpr int kNearReadings = 12;
  if (a.family == Family::kStep) {
    return a.run == b.run && a.carrier == b.carrier && std::abs(a.first_reading - b.first_reading) <= kNearReadings;
  }
  if (const auto* one = std::get_if<shapes::Bump>(&a.term.shape)) {
    const auto& other = std::get<shapes::Bump>(b.term.shape);
    return a.term.joint == b.term.joint && a.term.component == b.term.component && one->axis == other.axis &&
           std::abs(one->at - other.at) < std::max(one->width, other.width);
  }
  return IsSameEffect(a.term, b.term);
}

// True where a named effect explains nearly as much as the local defect: a real defect explains about twice as much.
bool HasCloseName(const SearchResult& found) {
  constexpr double kClose = 0.6;
  const Scored& best = found.finding.effect;
  return best.candidate.family == Family::kBump &&
         std::any_of(found.ranking.begin(), found.ranking.end(), [&best](const Scored& one) {
           return !IsUnnamed(one.candidate.family) && one.likelihood_ratio > kClose * best.likelihood_ratio;
         });
}

}  // namespace

// The dictionary without candidates that were tried and refused.
std::vector<Candidate> Growth::Candidates(const Fit& fit) const {
  std::vector<Candidate> candidates = MakeDictionary(fit.problem, fit.point.model);
  if (effects().size() == attempt_->way.prefix.size() && !attempt_->way.not_first.empty()) {
    std::erase_if(candidates, [this](const Candidate& one) {
      return IsUnnamed(one.family) ||
             std::any_of(attempt_->way.not_first.begin(), attempt_->way.not_first.end(),
                         [&](const Candidate& other) { return IsSameEffect(one.term, other.term); });
    });
  }
  std::erase_if(candidates, [this](const Candidate& one) {
    return std::any_of(attempt_->refused.begin(), attempt_->refused.end(),
                       [&one](const Candidate& other) { return IsNear(one, other); });
  });
  return candidates;
}

absl::StatusOr<bool> Growth::Forward(Fit* fit) {
  const Signatures signatures(fit->problem, fit->point, identify::ListParameters(fit->point.model, true));
  const std::vector<Candidate> candidates = Candidates(*fit);
  SearchResult found = Search(machine_, signatures, candidates, options_.search);
  if (attempt_->way.names_first && found.is_significant && found.finding.effect.candidate.family == Family::kBump) {
    std::vector<Candidate> named = candidates;
    std::erase_if(named, [](const Candidate& one) { return one.family == Family::kBump; });
    SearchResult other = Search(machine_, signatures, named, options_.search);
    if (other.is_significant) found = std::move(other);
  }
  if (attempt_->report.candidates == 0) {
    attempt_->report.ranking = found.ranking;
    attempt_->report.candidates = found.candidate_count;
    attempt_->report.not_visible = found.not_visible;
  }
  if (!found.is_significant) return false;
  attempt_->has_close_name |= HasCloseName(found);
  if (found.finding.effect.candidate.family == Family::kStep) {
    ASSIGN_OR_RETURN(const bool is_end, SetEndAside(found.finding.effect, fit));
    if (is_end) return true;
  }
  ASSIGN_OR_RETURN(const Finding named, NamedInstead(*fit, signatures, candidates, found.finding));
  ASSIGN_OR_RETURN(const Finding finding, Decide(*fit, signatures, named));
  Added added;
  added.candidate = finding.effect.candidate;
  for (int b = 0; b < kMostAmplitudes; ++b) added.candidate.term.amplitude[b] = finding.effect.amplitude[b];
  added.score = finding.effect.score;
  SetClass(finding, &added);
  const bool is_slip = added.candidate.family == Family::kStep;
  if (is_slip) added.candidate = WithCarrierTold(signatures, added.candidate, options_.search.indistinguishable);
  effects().push_back(added);
  // A candidate that is nearly explained already may promise much and fit nothing: its amplitude grows without limit.
  if (!is_slip) {
    const absl::StatusOr<Fit> refit = Refit(*fit, extension().Model(), identify_options_);
    if (absl::IsCancelled(refit.status())) return refit.status();
    if (!refit.ok() || !(SquaresOf(*refit) < SquaresOf(*fit) - options_.search.indistinguishable)) {
      if (refit.ok()) attempt_->Note(SelectionStep::kRefused, extension().NameOf(effects().size() - 1), *refit);
      effects().pop_back();
      attempt_->refused.push_back(finding.effect.candidate);
      return true;
    }
  }
  absl::StatusOr<Fit> extended = FitExtension(machine_, extension(), identify_options_);
  if (absl::IsCancelled(extended.status())) return extended.status();
  if (!extended.ok()) {  // with the noise judged anew it does not converge
    effects().pop_back();
    attempt_->refused.push_back(finding.effect.candidate);
    return true;
  }
  *fit = *std::move(extended);
  attempt_->Note(SelectionStep::kAdded, extension().NameOf(effects().size() - 1), *fit);
  if (is_slip) {
    ASSIGN_OR_RETURN(const bool is_bad, SettleSlip(effects().size() - 1, fit));
    if (is_bad) return true;
  }
  if (!attempt_->first.has_value()) attempt_->first = added;
  if (options_.progress) {
    options_.progress(
        {"closing the loop", static_cast<double>(effects().size()) / options_.max_effects,
         absl::StrFormat("%d candidates, added %s, rms %.3f um", found.candidate_count,
                         extension().NameOf(effects().size() - 1), fit->result.fit.rms_mm * base::kUmPerMm)});
  }
  return true;
}

// A local defect can fit what several weak effects leave: its place and width are free. Faint structure gets a name
// where one explains at least half as much. Beside a local defect that was added, it is the rest of that one's form.
Finding Growth::NamedOfWeak(const Signatures& signatures, const std::vector<Candidate>& named, Finding local) const {
  constexpr double kFaint = 80.0, kHalf = 0.5, kEvidenceShare = 0.6;
  const bool has_local = std::any_of(effects().begin(), effects().end(),
                                     [](const Added& one) { return one.candidate.family == Family::kBump; });
  if (has_local || local.effect.likelihood_ratio > kFaint) return local;
  SearchOptions options = options_.search;
  options.evidence *= kEvidenceShare;  // that something is there was decided
  SearchResult found = Search(machine_, signatures, named, options);
  const bool is_named =
      found.is_significant && found.finding.effect.likelihood_ratio > kHalf * local.effect.likelihood_ratio;
  return is_named ? std::move(found.finding) : std::move(local);
}

// Two effects that reverse together look like a slipped artefact: its three offsets can fit both. A slip is taken only
// where up to two named effects do not explain as much for their number of parameters.
absl::StatusOr<Finding> Growth::NamedInstead(const Fit& fit, const Signatures& signatures,
                                             std::vector<Candidate> candidates, Finding unnamed) const {
  if (!IsUnnamed(unnamed.effect.candidate.family)) return unnamed;
  std::erase_if(candidates, [](const Candidate& one) { return IsUnnamed(one.family); });
  if (unnamed.effect.candidate.family == Family::kBump) return NamedOfWeak(signatures, candidates, std::move(unnamed));
  constexpr double kNamesFirst = 2.0;  // in score
  SearchResult found = Search(machine_, signatures, candidates, options_.search);
  if (!found.is_significant) return unnamed;
  const Finding first = std::move(found.finding);
  ErrorModel model = fit.result.model;
  double penalty = -options_.search.evidence;  // the slip needed as much as the first name
  for (const Finding* next = &first;; next = &found.finding) {
    penalty += options_.search.evidence + next->effect.likelihood_ratio - next->effect.score;
    model.terms.push_back(next->effect.candidate.term);
    const absl::StatusOr<Fit> refit = Refit(fit, model, identify_options_);
    if (absl::IsCancelled(refit.status())) return refit.status();
    if (!refit.ok()) return unnamed;
    const Signatures left(refit->problem, refit->point, identify::ListParameters(refit->point.model, true));
    const double explained =
        LikelihoodRatio(signatures.residual_squares(), signatures.residual_squares() - left.residual_squares(),
                        signatures.degrees_of_freedom());
    if (explained - penalty >= unnamed.effect.score - kNamesFirst) return first;
    if (next != &first) return unnamed;
    found = Search(machine_, left, candidates, options_.search);
    if (!found.is_significant) return unnamed;
  }
}

// The linear estimate fails for large amplitudes of signatures that set-ups nearly explain. A full refit decides which
// of equally simple members fits best, and whether a close rival fits clearly better.
absl::StatusOr<Finding> Growth::Decide(const Fit& fit, const Signatures& signatures, Finding finding) const {
  if (finding.effect.candidate.family == Family::kStep) return finding;
  constexpr size_t kContenders = 5, kRivals = 3;
  constexpr double kClose = 0.95;  // of the likelihood ratio: the estimate may be wrong by a share
  const auto squares_with = [&](const Scored& one) -> absl::StatusOr<double> {
    ErrorModel model = fit.result.model;
    model.terms.push_back(one.candidate.term);
    const absl::StatusOr<Fit> refit = Refit(fit, model, identify_options_);
    if (absl::IsCancelled(refit.status())) return refit.status();
    if (!refit.ok()) return INFINITY;
    // An error across all bars changes their length only by its square: absurdly large, it would fit even so.
    const machine::ErrorTerm& fitted = refit->result.model.terms.back();
    const Eigen::Vector3d amplitude(fitted.amplitude[0], fitted.amplitude[1], 0.0);
    return IsPlausible(signatures, {one.candidate.family, fitted}, amplitude) ? SquaresOf(*refit) : INFINITY;
  };
  const int complexity = Complexity(machine_, finding.effect.candidate);
  size_t contenders = 0;
  while (contenders < std::min(kContenders, finding.equivalent.size()) &&
         Complexity(machine_, finding.equivalent[contenders].candidate) == complexity)
    ++contenders;
  std::vector<Scored> close;
  for (const Scored& rival : finding.rivals) {
    const bool is_close =
        !IsUnnamed(rival.candidate.family) && rival.likelihood_ratio > kClose * finding.effect.likelihood_ratio;
    if (is_close && close.size() < kRivals) close.push_back(rival);
  }
  if (contenders == 0 && close.empty()) return finding;
  double least = INFINITY;
  size_t best = 0;  // 0: the effect itself, k: equivalent[k - 1]
  for (size_t k = 0; k <= contenders; ++k) {
    ASSIGN_OR_RETURN(const double squares, squares_with(k == 0 ? finding.effect : finding.equivalent[k - 1]));
    if (squares >= least) continue;
    least = squares;
    best = k;
  }
  if (best > 0) std::swap(finding.effect, finding.equivalent[best - 1]);
  for (const Scored& rival : close) {
    ASSIGN_OR_RETURN(const double squares, squares_with(rival));
    if (squares >= least - options_.search.indistinguishable) continue;
    least = squares;
    // Swap() looks for the class of the new one among what was close to the old one.
    finding.rivals.insert(finding.rivals.end(), finding.equivalent.begin(), finding.equivalent.end());
    finding.equivalent.clear();
    finding.rivals.push_back(std::exchange(finding.effect, rival));
  }
  return finding;
}

// Drops those of the first `count` effects that the refitted model no longer needs.
absl::Status Growth::Backward(size_t count, Fit* fit) {
  for (; count > 0; --count) {
    int weakest = -1;
    double least = options_.search.evidence;
    for (size_t i = 0; i < count; ++i) {
      if (effects()[i].candidate.family == Family::kStep) continue;
      const double evidence = EvidenceOf(*fit, extension().TermOf(i));
      if (evidence < least) {
        least = evidence;
        weakest = static_cast<int>(i);
      }
    }
    if (weakest < 0) return absl::OkStatus();
    // A length or time constant that is fitted along makes the amplitude uncertain, though the effect is certain.
    ErrorModel lacking = fit->result.model;
    lacking.terms.erase(lacking.terms.begin() + extension().TermOf(weakest));
    const absl::StatusOr<Fit> without = Refit(*fit, lacking, identify_options_);
    if (absl::IsCancelled(without.status())) return without.status();
    if (!without.ok() || SquaresOf(*without) - SquaresOf(*fit) > options_.search.evidence) return absl::OkStatus();
    const std::string name = extension().NameOf(weakest);
    const Extension before = extension();
    effects().erase(effects().begin() + weakest);
    ASSIGN_OR_RETURN(const bool is_fitted, Change(before, fit));
    if (!is_fitted) return absl::OkStatus();
    attempt_->Note(SelectionStep::kDropped, name, *fit);
  }
  return absl::OkStatus();
}

}  // namespace axiscal::loop
