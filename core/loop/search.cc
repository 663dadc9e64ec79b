#include "core/loop/search.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/identify/reduction.h"
#include "core/instruments/resolution.h"
#include "core/loop/dictionary.h"
#include "core/loop/refine.h"
#include "core/loop/resolution.h"

namespace axiscal::loop {

double LikelihoodRatio(double squares, double gain, int dof) {
  if (!(gain > 0.0) || squares <= 0.0) return 0.0;
  constexpr double kExplainedAtMost = 1.0 - 1e-12;
  return -dof * std::log1p(-std::min(gain / squares, kExplainedAtMost));
}

namespace {

// One effect at different points of its family's grid.
bool IsNeighbour(const Candidate& a, const Candidate& b) {
  return a.family == b.family && a.term.joint == b.term.joint && a.term.component == b.term.component &&
         shapes::VariableAxis(a.term.shape) == shapes::VariableAxis(b.term.shape);
}

void Estimate(const Signatures& signatures, Scored* one) {
  const Projection projection = signatures.Project({one->candidate})[0];
  const double gain = Gain(projection, &one->amplitude);
  const double better =
      LikelihoodRatio(signatures.residual_squares(), gain, signatures.degrees_of_freedom()) - one->likelihood_ratio;
  one->likelihood_ratio += better;
  one->score += better;
}

// Puts one between the points of its family's grid.
void Refine(const Signatures& signatures, double range, Scored* one) {
  one->candidate = Refined(signatures, one->candidate, range);
  Estimate(signatures, one);
}

// The leading members of the families that stand on a grid, between its points: only so do they compare with each
// other and with the rest. Their neighbours on the grid leave the list.
void RefineLeaders(const Signatures& signatures, std::vector<Scored>* scored) {
  constexpr size_t kLeaders = 4;      // of each family and axis
  constexpr double kFarBehind = 0.6;  // of the best likelihood ratio
  if (scored->empty()) return;
  double best = 0.0;
  for (const Scored& one : *scored) best = std::max(best, one.likelihood_ratio);
  std::vector<AxisSpan> spans;
  std::map<std::pair<Family, int>, std::vector<Candidate>> leaders;
  for (size_t i = 0; i < scored->size(); ++i) {
    Scored& leader = (*scored)[i];
    const Family family = leader.candidate.family;
    if (!IsGrid(family) || leader.likelihood_ratio < kFarBehind * best) continue;
    const std::optional<int> axis = shapes::VariableAxis(leader.candidate.term.shape);
    std::vector<Candidate>& refined = leaders[{family, axis.value_or(-1)}];
    if (spans.empty()) spans = SpansOf(signatures.problem());
    const double range = axis ? spans[*axis].highest - spans[*axis].lowest : 0.0;
    if (refined.size() == kLeaders) {
      leader.candidate = AtPlaceOf(signatures, leader.candidate, refined);
      Estimate(signatures, &leader);
    } else {
      Refine(signatures, range, &leader);
      refined.push_back(leader.candidate);
    }
    const Candidate kept = leader.candidate;
    scored->erase(std::remove_if(scored->begin() + static_cast<std::ptrdiff_t>(i) + 1, scored->end(),
                                 [&](const Scored& other) { return IsNeighbour(other.candidate, kept); }),
                  scored->end());
  }
}

// A local defect shows in several readings; fewer are bad ones that lie near each other.
bool HasFewReadings(const identify::Problem& problem, const Candidate& candidate) {
  const auto* bump = std::get_if<shapes::Bump>(&candidate.term.shape);
  if (bump == nullptr) return false;
  constexpr int kFewest = 4;
  int count = 0;
  for (size_t i = 0; i < problem.runs.size() && count < kFewest; ++i) {
    const instruments::MeasuringRun& run = problem.runs[i];
    for (int k = 0; k < run.reading_count(); ++k) {
      const auto rows = problem.is_used[i].begin() + std::ptrdiff_t{k} * run.row_count;
      count += std::abs(run.PositionsOf(k)[bump->axis] - bump->at) < bump->width &&
               std::any_of(rows, rows + run.row_count, [](bool used) { return used; });
    }
  }
  return count < kFewest;
}

// The best slip of each session, of table and of tool, at its best moment: the search looked at every few. Its
// neighbours leave the list.
void RefineSlips(const Signatures& signatures, const SearchOptions& options, std::vector<Scored>* scored) {
  std::set<std::pair<int, instruments::Carrier>> seen;
  std::vector<Scored> kept;
  for (Scored& one : *scored) {
    if (one.candidate.family == Family::kStep && one.score >= 0.5 * options.evidence) {
      if (!seen.insert({one.candidate.run, one.candidate.carrier}).second) continue;
      one.candidate = AtBestMoment(signatures, one.candidate, options.indistinguishable);
      Estimate(signatures, &one);
    }
    kept.push_back(std::move(one));
  }
  *scored = std::move(kept);
}

// Other pitches by which the best, a pitch, would pass as well where these readings were taken join the list.
void AddAliases(const Signatures& signatures, const std::vector<Candidate>& candidates, double indistinguishable,
                std::vector<Scored>* scored) {
  const Scored best = scored->front();
  const double least = best.likelihood_ratio - indistinguishable;
  std::vector<Candidate> others;
  for (const Candidate& one : candidates) {
    if (IsNeighbour(one, best.candidate) && !IsSameEffect(one.term, best.candidate.term)) others.push_back(one);
  }
  const std::vector<Projection> projections = signatures.Project(others);
  std::vector<Scored> promising;
  for (size_t i = 0; i < others.size(); ++i) {
    Scored one{others[i], 0.0, best.score - best.likelihood_ratio, {}};
    if (projections[i].visible <= kVisible) continue;
    Estimate(signatures, &one);
    constexpr double kOnGrid = 0.7;  // of what a pitch explains between the points of the grid
    if (one.likelihood_ratio > kOnGrid * least) promising.push_back(std::move(one));
  }
  std::sort(promising.begin(), promising.end(),
            [](const Scored& a, const Scored& b) { return a.likelihood_ratio > b.likelihood_ratio; });
  const AxisSpan span = SpansOf(signatures.problem())[*shapes::VariableAxis(best.candidate.term.shape)];
  constexpr size_t kMost = 2;
  std::vector<Scored> aliases = {best};
  for (Scored& one : promising) {
    if (aliases.size() > kMost) break;
    Refine(signatures, span.highest - span.lowest, &one);
    const auto is_it = [&](const Scored& other) { return IsSameEffect(other.candidate.term, one.candidate.term); };
    if (one.likelihood_ratio > least && std::none_of(aliases.begin(), aliases.end(), is_it)) aliases.push_back(one);
  }
  scored->insert(scored->begin() + 1, aliases.begin() + 1, aliases.end());
}

// What would leave no trace. Constants are mostly only where a machine's zero is; crossed variables and fine scans
// would flood the list.
std::vector<machine::ErrorTerm> NotVisible(const std::vector<Candidate>& candidates,
                                           const std::vector<Projection>& projections) {
  std::vector<machine::ErrorTerm> terms, visible;  // at any time constant or length
  for (size_t i = 0; i < candidates.size(); ++i) {
    const Family family = candidates[i].family;
    const bool is_told = family != Family::kConstant && family != Family::kCross && family != Family::kFineHarmonic &&
                         family != Family::kPitch && !IsUnnamed(family);
    if (!is_told) continue;
    const machine::ErrorTerm& term = candidates[i].term;
    const auto is_it = [&term](const machine::ErrorTerm& other) { return IsSameEffect(term, other); };
    std::vector<machine::ErrorTerm>& list =
        projections[i].is_screened || projections[i].visible > kVisible ? visible : terms;
    if (std::none_of(list.begin(), list.end(), is_it)) list.push_back(term);
  }
  std::erase_if(terms, [&visible](const machine::ErrorTerm& term) {
    return std::any_of(visible.begin(), visible.end(),
                       [&term](const machine::ErrorTerm& other) { return IsSameEffect(term, other); });
  });
  return terms;
}

// How much an effect may explain of readings with a coarse step although it is not there: rounding of a smooth signal
// leaves a sawtooth, whose first harmonic has the amplitude resolution / pi.
double RoundingSquares(const identify::Problem& problem) {
  double squares = 0.0;
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const double sawtooth = instruments::CoarseResolutionOf(problem.runs[i]) / (M_PI * problem.noise[i].sigma_mm);
    const auto used = std::count(problem.is_used[i].begin(), problem.is_used[i].end(), true);
    squares += 0.5 * sawtooth * sawtooth * static_cast<double>(used);
  }
  return squares;
}

}  // namespace

bool IsPlausible(const Signatures& signatures, const Candidate& candidate, const Eigen::Vector3d& amplitude) {
  if (candidate.family == Family::kStep) return true;
  // A tool or a table may stand centimetres off, and an axis may lag its command by as much; errors that vary along an
  // axis are much smaller.
  const bool is_large = candidate.family == Family::kConstant || candidate.family == Family::kLag;
  constexpr double kFarOffMm = 30.0, kFarOffRad = 0.1;
  // No usable machine has more play than that.
  const bool is_play = candidate.family == Family::kBacklash || candidate.family == Family::kReversal;
  constexpr double kPlayMm = 1.0, kPlayRad = 0.01;  // either way; of backlash, peak to peak, twice that
  const double most_mm = is_large ? kFarOffMm : is_play ? kPlayMm : identify::kLargestErrorMm;
  const double most_rad = is_large ? kFarOffRad : is_play ? kPlayRad : identify::kLargestErrorRad;
  const double most = machine::IsAngle(candidate.term.component) ? most_rad : most_mm;
  return signatures.LargestValue(candidate.term, amplitude) < most;
}

SearchResult Search(const machine::Machine& machine, const Signatures& signatures,
                    const std::vector<Candidate>& candidates, const SearchOptions& options) {
  SearchResult result;
  result.candidate_count = static_cast<int>(candidates.size());
  // What explains less than this is not significant: half of a family's members are taken to be visible.
  std::map<Family, double> worth;
  for (const Candidate& candidate : candidates) worth[candidate.family] += 0.5;
  const double noise_square = signatures.residual_squares() / signatures.degrees_of_freedom();
  const double rounding = RoundingSquares(signatures.problem());
  for (auto& [family, value] : worth)
    value = std::max(rounding, noise_square * (options.evidence + 2.0 * std::log(std::max(1.0, value))));
  constexpr double kClearlyLess = 0.8;
  const std::vector<Projection> projections = signatures.ProjectWorthy(candidates, worth, kClearlyLess);
  result.not_visible = NotVisible(candidates, projections);
  // Slips of table and tool are two families.
  const auto kin_of = [](const Candidate& one) { return std::pair(one.family, one.carrier); };
  std::map<std::pair<Family, instruments::Carrier>, int> members;
  for (size_t i = 0; i < candidates.size(); ++i)
    members[kin_of(candidates[i])] += projections[i].is_screened || projections[i].visible > kVisible;
  const Resolution resolution(signatures);
  std::vector<Scored> scored;
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (!resolution.Resolves(candidates[i].term)) continue;
    if (projections[i].is_screened || projections[i].visible <= kVisible) continue;
    Scored one;
    one.candidate = candidates[i];
    const double gain = Gain(projections[i], &one.amplitude);
    if (gain < rounding) continue;
    one.likelihood_ratio = LikelihoodRatio(signatures.residual_squares(), gain, signatures.degrees_of_freedom());
    one.score = one.likelihood_ratio - 2.0 * std::log(std::max(1, members[kin_of(candidates[i])])) -
                options.per_column * (projections[i].columns - 1);
    scored.push_back(std::move(one));
  }
  std::erase_if(scored, [&](const Scored& one) {
    return one.score > 0.5 * options.evidence && !IsPlausible(signatures, one.candidate, one.amplitude);
  });
  const auto better = [](const Scored& a, const Scored& b) { return a.score > b.score; };
  std::sort(scored.begin(), scored.end(), better);
  if (!scored.empty() && scored[0].score > 0.5 * options.evidence) {
    RefineLeaders(signatures, &scored);
    RefineSlips(signatures, options, &scored);
    std::erase_if(scored, [&](const Scored& one) {
      return one.score > 0.5 * options.evidence && HasFewReadings(signatures.problem(), one.candidate);
    });
    std::sort(scored.begin(), scored.end(), better);
  }
  constexpr size_t kRanked = 20, kCompared = 400;
  result.ranking.assign(scored.begin(), scored.begin() + std::min(kRanked, scored.size()));
  if (scored.empty() || scored[0].score <= options.evidence) return result;
  result.is_significant = true;

  // Far behind the best nothing is a rival.
  constexpr double kRival = 0.65;
  const double least =
      std::min(kRival * scored[0].likelihood_ratio, scored[0].likelihood_ratio - options.indistinguishable);
  std::erase_if(scored, [&](const Scored& one) { return one.likelihood_ratio < least; });
  scored.resize(std::min(kCompared, scored.size()));
  if (scored[0].candidate.family == Family::kPitch)
    AddAliases(signatures, candidates, options.indistinguishable, &scored);
  result.finding = ClassOf(machine, signatures, scored, options);
  return result;
}

Finding ClassOf(const machine::Machine& machine, const Signatures& signatures, const std::vector<Scored>& scored,
                const SearchOptions& options) {
  const Scored& best = scored[0];
  std::vector<Candidate> compared;
  for (const Scored& one : scored) compared.push_back(one.candidate);
  const std::vector<double> correlations = signatures.CorrelationsWith(best.candidate, compared);
  constexpr double kRelated = 0.7;
  const auto simpler = [&machine](const Scored& a, const Scored& b) {
    const int ca = Complexity(machine, a.candidate), cb = Complexity(machine, b.candidate);
    return ca != cb ? ca < cb : a.score > b.score;
  };
  // Two pitches of one component share but one of their two amplitudes where one passes for the other.
  constexpr double kRelatedPitch = 0.5;
  const auto related = [&](size_t i) {
    return best.candidate.family == Family::kPitch && IsNeighbour(scored[i].candidate, best.candidate) ? kRelatedPitch
                                                                                                       : kRelated;
  };
  const auto explains_as_much = [&](size_t i) {
    return scored[i].likelihood_ratio >= best.likelihood_ratio - options.indistinguishable;
  };
  // The simplest of what is related to the best; what is related to that may be it as well (of two amplitudes each one
  // may stand for another single one without the two pairs being alike).
  const Scored* simplest = &best;
  for (size_t i = 1; i < scored.size(); ++i) {
    if (explains_as_much(i) && correlations[i] > related(i) && simpler(scored[i], *simplest)) simplest = &scored[i];
  }
  std::vector<double> with_simplest = correlations;
  if (simplest != &best) with_simplest = signatures.CorrelationsWith(simplest->candidate, compared);
  std::vector<Scored> compatible, correlated;
  Finding finding;
  for (size_t i = 0; i < scored.size(); ++i) {
    const double closest = std::max(correlations[i], with_simplest[i]);
    // The best is in its class even where one of its columns shows in no reading.
    if (i == 0 || &scored[i] == simplest || (explains_as_much(i) && closest > related(i))) {
      compatible.push_back(scored[i]);
    } else if (closest > options.same_class_correlation) {
      correlated.push_back(scored[i]);
    } else {
      finding.rivals.push_back(scored[i]);
    }
  }
  std::stable_sort(compatible.begin(), compatible.end(), simpler);
  std::stable_sort(correlated.begin(), correlated.end(), simpler);
  finding.effect = compatible.front();
  finding.equivalent.assign(compatible.begin() + 1, compatible.end());
  finding.equivalent.insert(finding.equivalent.end(), correlated.begin(), correlated.end());
  return finding;
}

}  // namespace axiscal::loop
