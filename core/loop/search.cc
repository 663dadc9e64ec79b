#include "core/loop/search.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/loop/dictionary.h"
#include "core/loop/refine.h"

namespace axiscal::loop {

double LikelihoodRatio(double squares, double gain, int dof) {
  if (!(gain > 0.0) || squares <= 0.0) return 0.0;
  constexpr double kExplainedAtMost = 1.0 - 1e-12;
  return -dof * std::log1p(-std::min(gain / squares, kExplainedAtMost));
}

namespace {

bool IsGrid(Family family) {
  return family == Family::kBump || family == Family::kPitch || family == Family::kReversal ||
         family == Family::kDriftExp;
}

// One effect at different points of its family's grid.
bool IsNeighbour(const Candidate& a, const Candidate& b) {
  return a.family == b.family && a.term.joint == b.term.joint && a.term.component == b.term.component &&
         shapes::VariableAxis(a.term.shape) == shapes::VariableAxis(b.term.shape);
}

// The leading members of the families that stand on a grid, between its points: only so do they compare with each
// other and with the rest. Their neighbours on the grid leave the list.
void RefineLeaders(const Signatures& signatures, std::vector<Scored>* scored) {
  constexpr int kLeaders = 4;         // of each family and axis
  constexpr double kFarBehind = 0.6;  // of the best likelihood ratio
  if (scored->empty()) return;
  double best = 0.0;
  for (const Scored& one : *scored) best = std::max(best, one.likelihood_ratio);
  std::vector<AxisSpan> spans;
  std::map<std::pair<Family, int>, int> refined;
  for (size_t i = 0; i < scored->size(); ++i) {
    Scored& leader = (*scored)[i];
    const Family family = leader.candidate.family;
    if (!IsGrid(family) || leader.likelihood_ratio < kFarBehind * best) continue;
    const std::optional<int> axis = shapes::VariableAxis(leader.candidate.term.shape);
    if (++refined[{family, axis.value_or(-1)}] > kLeaders) continue;
    if (spans.empty()) spans = SpansOf(signatures.problem());
    const double range = axis ? spans[*axis].highest - spans[*axis].lowest : 0.0;
    leader.candidate = Refined(signatures, leader.candidate, range);
    const Projection projection = signatures.Project({leader.candidate})[0];
    const double gain = Gain(projection, &leader.amplitude);
    const double better =
        LikelihoodRatio(signatures.residual_squares(), gain, signatures.degrees_of_freedom()) - leader.likelihood_ratio;
    leader.likelihood_ratio += better;
    leader.score += better;
    const Candidate kept = leader.candidate;
    scored->erase(std::remove_if(scored->begin() + static_cast<std::ptrdiff_t>(i) + 1, scored->end(),
                                 [&](const Scored& other) { return IsNeighbour(other.candidate, kept); }),
                  scored->end());
  }
}

}  // namespace

SearchResult Search(const machine::Machine& machine, const Signatures& signatures,
                    const std::vector<Candidate>& candidates, const SearchOptions& options) {
  SearchResult result;
  result.candidate_count = static_cast<int>(candidates.size());
  // What explains less than this is not significant: half of a family's members are taken to be visible.
  std::map<Family, double> worth;
  for (const Candidate& candidate : candidates) worth[candidate.family] += 0.5;
  const double noise_square = signatures.residual_squares() / signatures.degrees_of_freedom();
  for (auto& [family, value] : worth) value = noise_square * (options.evidence + 2.0 * std::log(std::max(1.0, value)));
  const std::vector<Projection> projections = signatures.ProjectWorthy(candidates, worth);
  std::map<Family, int> members;
  for (size_t i = 0; i < candidates.size(); ++i)
    members[candidates[i].family] += projections[i].is_screened || projections[i].visible > kVisible;
  std::vector<Scored> scored;
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (projections[i].is_screened || projections[i].visible <= kVisible) continue;
    Scored one;
    one.candidate = candidates[i];
    const double gain = Gain(projections[i], &one.amplitude);
    one.likelihood_ratio = LikelihoodRatio(signatures.residual_squares(), gain, signatures.degrees_of_freedom());
    one.score = one.likelihood_ratio - 2.0 * std::log(std::max(1, members[candidates[i].family])) -
                options.per_column * (projections[i].columns - 1);
    scored.push_back(std::move(one));
  }
  const auto better = [](const Scored& a, const Scored& b) { return a.score > b.score; };
  std::sort(scored.begin(), scored.end(), better);
  if (!scored.empty() && scored[0].score > 0.5 * options.evidence) {
    RefineLeaders(signatures, &scored);
    std::sort(scored.begin(), scored.end(), better);
  }
  constexpr size_t kRanked = 20, kCompared = 400;
  result.ranking.assign(scored.begin(), scored.begin() + std::min(kRanked, scored.size()));
  if (scored.empty() || scored[0].score <= options.evidence) return result;
  result.is_significant = true;

  // Far behind the best nothing is a rival.
  constexpr double kRival = 0.8;
  const double least =
      std::min(kRival * scored[0].likelihood_ratio, scored[0].likelihood_ratio - options.indistinguishable);
  std::erase_if(scored, [&](const Scored& one) { return one.likelihood_ratio < least; });
  scored.resize(std::min(kCompared, scored.size()));
  result.finding = ClassOf(machine, signatures, scored, options);
  return result;
}

Finding ClassOf(const machine::Machine& machine, const Signatures& signatures, const std::vector<Scored>& scored,
                const SearchOptions& options) {
  const Scored& best = scored[0];
  std::vector<Candidate> compared;
  for (const Scored& one : scored) compared.push_back(one.candidate);
  const std::vector<double> correlations = signatures.CorrelationsWith(best.candidate, compared);
  std::vector<Scored> compatible, correlated;
  Finding finding;
  for (size_t i = 0; i < scored.size(); ++i) {
    const bool explains_as_much = scored[i].likelihood_ratio >= best.likelihood_ratio - options.indistinguishable;
    const bool is_same = correlations[i] > options.same_class_correlation;
    constexpr double kRelated = 0.7;
    // The best is in its class even where one of its columns shows in no reading.
    if (i == 0 || (explains_as_much && correlations[i] > kRelated)) {
      compatible.push_back(scored[i]);
    } else if (is_same) {
      correlated.push_back(scored[i]);
    } else {
      finding.rivals.push_back(scored[i]);
    }
  }
  const auto simpler = [&machine](const Scored& a, const Scored& b) {
    const int ca = Complexity(machine, a.candidate), cb = Complexity(machine, b.candidate);
    return ca != cb ? ca < cb : a.score > b.score;
  };
  std::stable_sort(compatible.begin(), compatible.end(), simpler);
  std::stable_sort(correlated.begin(), correlated.end(), simpler);
  finding.effect = compatible.front();
  finding.equivalent.assign(compatible.begin() + 1, compatible.end());
  finding.equivalent.insert(finding.equivalent.end(), correlated.begin(), correlated.end());
  return finding;
}

}  // namespace axiscal::loop
