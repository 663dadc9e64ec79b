// Looks for the effect that explains most of what is left, and for what the data cannot tell from it.
#ifndef AXISCAL_CORE_LOOP_SEARCH_H_
#define AXISCAL_CORE_LOOP_SEARCH_H_

#include <vector>

#include "core/loop/signatures.h"

namespace axiscal::loop {

struct SearchOptions {
  // An effect must be more likely than chance after all looks: likelihood ratio (as chi-square) above `evidence`
  // plus 2 ln(members of its family) plus `per_column` for each amplitude beyond the first.
  double evidence = 16.0;
  double per_column = 4.0;
  // Candidates whose likelihood ratios differ by less are not told apart by this data.
  double indistinguishable = 6.0;
  double same_class_correlation = 0.98;
};

struct Scored {
  Candidate candidate;
  double likelihood_ratio = 0.0;  // chi-square units, noise scale profiled out: dof ln(before / after)
  double score = 0.0;             // likelihood ratio less the penalty for looks; above `evidence`: significant
  Eigen::Vector3d amplitude = Eigen::Vector3d::Zero();  // linear estimate
};

struct Finding {
  Scored effect;                   // the simplest member of the class that explains as much as the best
  std::vector<Scored> equivalent;  // the others, simplest first
  std::vector<Scored> rivals;      // what explains nearly as much and could be it once more is known
};

struct SearchResult {
  bool is_significant = false;
  Finding finding;
  std::vector<Scored> ranking;  // the best twenty, best first
  int candidate_count = 0;
  std::vector<machine::ErrorTerm> not_visible;  // Report::not_visible
};

SearchResult Search(const machine::Machine& machine, const Signatures& signatures,
                    const std::vector<Candidate>& candidates, const SearchOptions& options);

// The class of the first of `scored` (not empty): candidates that correlate with it so closely that data of this kind
// cannot separate them, and related ones that explain as much within chance.
Finding ClassOf(const machine::Machine& machine, const Signatures& signatures, const std::vector<Scored>& scored,
                const SearchOptions& options);

// False for an amplitude that no machine has: with one, a signature that is nearly explained would fit anything.
bool IsPlausible(const Signatures& signatures, const Candidate& candidate, const Eigen::Vector3d& amplitude);

// Likelihood ratio (chi-square units) of explaining `gain` of `squares` at `dof` degrees of freedom with the noise
// scale unknown.
double LikelihoodRatio(double squares, double gain, int dof);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_SEARCH_H_
