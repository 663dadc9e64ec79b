// Propagation of distributions through the whole identification (JCGM 101:2008, GUM Supplement 1): the sessions are
// simulated again and again at their own commands, with the fitted errors as the truth and everything that the budget
// names drawn anew, and identified as the measured ones were.
#ifndef AXISCAL_CORE_IDENTIFY_MONTE_CARLO_H_
#define AXISCAL_CORE_IDENTIFY_MONTE_CARLO_H_

#include <functional>
#include <string>
#include <vector>

#include "core/identify/budget.h"
#include "core/identify/identify.h"

namespace axiscal::identify {

inline constexpr int kMaxMonteCarloRuns = 100'000;

// Calls body(0) .. body(count - 1) in any order, on any threads, and returns when all have returned.
using ForEach = std::function<void(int count, const std::function<void(int)>& body)>;

struct MonteCarloOptions {
  int runs = 1000;  // 1 .. kMaxMonteCarloRuns; 95 % intervals need some hundreds
  uint64_t seed = 1;
  Budget budget;
  ForEach for_each;                 // one after the other where unset
  std::function<bool()> cancelled;  // polled before every run, from any thread
  std::function<void(double fraction)> progress;
};

// How one identified error came out, mm or rad per the shape's reference.
struct Spread {
  std::string name, unit;
  double factor = 1.0;        // mm or rad per unit
  double value = 0.0;         // as identified: the truth of the simulation
  double linear_sigma = 0.0;  // standard uncertainty by linear propagation, of the readings' noise and held errors
  double mean = 0.0, sigma = 0.0;
  double low = 0.0, high = 0.0;  // 2.5 and 97.5 % quantiles
};

struct MonteCarloResult {
  int runs = 0, failed = 0;  // failed: fits that did not converge; they are in no spread
  uint64_t seed = 0;
  std::vector<Spread> spreads;  // identifiable errors in the order of the result
  Eigen::MatrixXd correlation;  // of them
};

// INVALID_ARGUMENT for `runs` out of range and for sessions that the budget names and the fit has not, CANCELLED,
// FAILED_PRECONDITION when more than one fit in ten fails: what remains would be a choice. The same for the same seed,
// whatever `for_each` does.
absl::StatusOr<MonteCarloResult> MonteCarlo(const Fit& fit, const MonteCarloOptions& options);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_MONTE_CARLO_H_
