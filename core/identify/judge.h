// The second stage of a fit: what its numbers are worth.
#ifndef AXISCAL_CORE_IDENTIFY_JUDGE_H_
#define AXISCAL_CORE_IDENTIFY_JUDGE_H_

#include <string>
#include <vector>

#include "core/identify/result.h"
#include "core/identify/solve.h"

namespace axiscal::identify {

// Errors whose numbers rest on weak priors of the set-up ("mounted by hand") and not on readings: the priors at least
// halve the variance that readings alone leave, and what remains is still more than kMeasuredWithin of a plausible
// size.
struct PriorDominated {
  std::vector<bool> involved;               // per error
  std::vector<Eigen::VectorXd> directions;  // each in units of the errors (mm, rad), as NullSpace::directions
};

// How a stated fact (instruments/stated.h) that is off by one standard uncertainty moves the fitted errors.
struct StatedPart {
  std::string of;
  Eigen::VectorXd moved;  // per error, mm or rad
};

struct Judgement {
  FitStatistics statistics;
  // By how much the readings scatter more than stated (Birge ratio, sqrt(chi-square / degrees of freedom)), at least 1;
  // 1 without options.scale_uncertainties. All uncertainties from readings are multiplied by it.
  double sigma_scale = 1.0;
  double coverage_factor = 0.0;    // Result::coverage_factor
  Covariance covariance;           // of the fitted errors and, behind them, those that are held from elsewhere
  std::vector<StatedPart> stated;  // what stated facts have in it
  PriorDominated prior_dominated;
  std::vector<bool> without_interval;  // per error (profile_likelihood.h)
  // Per error: the model holds it at a value that readings do not support. Prior-dominated, without an interval, of a
  // direction that was freed (gauge.h), or the carrier of a combination that has not been measured.
  std::vector<bool> unsupported;

  // Such an error gets no number, beside those of the null space.
  bool HasNoNumber(size_t error) const { return prior_dominated.involved[error] || without_interval[error]; }
};

// CANCELLED as Solve().
absl::StatusOr<Judgement> Judge(const SolvedProblem& solved, const Options& options);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_JUDGE_H_
