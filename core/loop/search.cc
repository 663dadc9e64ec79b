#include "core/loop/search.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace axiscal::loop {
namespace {

// A signature of which less than this share stands beyond the declared errors and setups cannot be seen in this data.
constexpr double kVisible = 1e-5;

}  // namespace

// What the projected columns explain of the residual, and the amplitudes that do so (the residual is predicted -
// measured).
double Gain(const Projection& projection, Eigen::Vector3d* amplitude) {
  const int n = projection.columns;
  const Eigen::MatrixXd own = projection.own.topLeftCorner(n, n);
  const Eigen::VectorXd right = projection.with_residual.head(n);
  const Eigen::LDLT<Eigen::MatrixXd> factor(own);
  constexpr double kRegular = 1e-9;
  if (factor.vectorD().minCoeff() <= kRegular * own.diagonal().maxCoeff()) {
    // Columns that are one column in this data count as one.
    int best = 0;
    own.diagonal().maxCoeff(&best);
    amplitude->setZero();
    (*amplitude)[best] = -right[best] / own(best, best);
    return right[best] * right[best] / own(best, best);
  }
  const Eigen::VectorXd solution = factor.solve(right);
  amplitude->setZero();
  amplitude->head(n) = -solution;
  return right.dot(solution);
}

double LikelihoodRatio(double squares, double gain, int dof) {
  if (!(gain > 0.0) || squares <= 0.0) return 0.0;
  constexpr double kExplainedAtMost = 1.0 - 1e-12;
  return -dof * std::log1p(-std::min(gain / squares, kExplainedAtMost));
}

SearchResult Search(const machine::Machine& machine, const Signatures& signatures,
                    const std::vector<Candidate>& candidates, const SearchOptions& options) {
  SearchResult result;
  result.candidate_count = static_cast<int>(candidates.size());
  const std::vector<Projection> projections = signatures.Project(candidates);
  std::map<Family, int> members;
  for (size_t i = 0; i < candidates.size(); ++i) members[candidates[i].family] += projections[i].visible > kVisible;
  std::vector<Scored> scored;
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (projections[i].visible <= kVisible) continue;
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
  scored.resize(std::min(kCompared, scored.size()));
  const Scored best = scored[0];
  std::vector<Candidate> compared;
  for (const Scored& one : scored) compared.push_back(one.candidate);
  const std::vector<double> correlations = signatures.CorrelationsWith(best.candidate, compared);
  std::vector<Scored> compatible, correlated;
  for (size_t i = 0; i < scored.size(); ++i) {
    const bool explains_as_much = scored[i].likelihood_ratio >= best.likelihood_ratio - options.indistinguishable;
    const bool is_same = correlations[i] > options.same_class_correlation;
    constexpr double kRelated = 0.7;
    if (explains_as_much && correlations[i] > kRelated) {
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
