#include "core/loop/search.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace axiscal::loop {

double LikelihoodRatio(double squares, double gain, int dof) {
  if (!(gain > 0.0) || squares <= 0.0) return 0.0;
  constexpr double kExplainedAtMost = 1.0 - 1e-12;
  return -dof * std::log1p(-std::min(gain / squares, kExplainedAtMost));
}

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
  std::sort(scored.begin(), scored.end(), [](const Scored& a, const Scored& b) { return a.score > b.score; });
  constexpr size_t kRanked = 20, kCompared = 400;
  result.ranking.assign(scored.begin(), scored.begin() + std::min(kRanked, scored.size()));
  if (scored.empty() || scored[0].score <= options.evidence) return result;
  result.is_significant = true;

  // The class: what correlates so closely with the best that no data of this kind separates them, or explains as much
  // within chance.
  const Scored best = scored[0];
  constexpr double kNear = 0.9;
  std::erase_if(scored, [&](const Scored& one) {
    return one.likelihood_ratio <
           std::min(kNear * best.likelihood_ratio, best.likelihood_ratio - options.indistinguishable);
  });
  scored.resize(std::min(kCompared, scored.size()));
  std::vector<Candidate> compared;
  for (const Scored& one : scored) compared.push_back(one.candidate);
  const std::vector<double> correlations = signatures.CorrelationsWith(best.candidate, compared);
  std::vector<Scored> compatible, correlated;
  for (size_t i = 0; i < scored.size(); ++i) {
    const bool explains_as_much = scored[i].likelihood_ratio >= best.likelihood_ratio - options.indistinguishable;
    const bool is_same = correlations[i] > options.same_class_correlation;
    constexpr double kRelated = 0.7;
    // The best is in its class even where one of its columns shows in no reading.
    if (i == 0 || (explains_as_much && correlations[i] > kRelated)) {
      compatible.push_back(scored[i]);
    } else if (is_same) {
      correlated.push_back(scored[i]);
    }
  }
  const auto simpler = [&machine](const Scored& a, const Scored& b) {
    const int ca = Complexity(machine, a.candidate), cb = Complexity(machine, b.candidate);
    return ca != cb ? ca < cb : a.score > b.score;
  };
  std::stable_sort(compatible.begin(), compatible.end(), simpler);
  std::stable_sort(correlated.begin(), correlated.end(), simpler);
  result.finding.effect = compatible.front();
  result.finding.equivalent.assign(compatible.begin() + 1, compatible.end());
  result.finding.equivalent.insert(result.finding.equivalent.end(), correlated.begin(), correlated.end());
  return result;
}

}  // namespace axiscal::loop
