// What an error will be, and when it crosses a limit, if nothing jumps: the thirty models of core/drift/outlook.h,
// weighed by how well they foretold the error so far.
#ifndef AXISCAL_CORE_DRIFT_FORECAST_H_
#define AXISCAL_CORE_DRIFT_FORECAST_H_

#include <optional>
#include <string>
#include <vector>

#include "core/drift/state.h"

namespace axiscal::drift {

// How often each model fits the errors of a group of machines; they sum to 1.
using GroupPrior = ModelWeights;
// Four fifths what the errors of these machines are like, one fifth what any may be like. States without errors that
// were seen ten times count nothing.
GroupPrior PriorOfGroup(const std::vector<const State*>& machines);

struct ForecastOptions {
  double coverage = 0.9;            // of intervals, between 0 and 1 (exclusive)
  std::optional<GroupPrior> prior;  // of the machine's group; else the same for all machines
};

struct Forecast {
  base::UtcTime at;
  Unit unit = Unit::kUm;
  double value = 0.0;                              // median
  double low = 0.0, high = 0.0;                    // of the error itself
  double measured_low = 0.0, measured_high = 0.0;  // of what a usual calibration would measure then
};

// NOT_FOUND where the machine has no such error, FAILED_PRECONDITION where `at` is before its last calibration or the
// error was seen fewer than three times, INVALID_ARGUMENT for options out of range.
absl::StatusOr<Forecast> ForecastOf(const State& state, const std::string& symbol, base::UtcTime at,
                                    const ForecastOptions& options = {});

// A tolerance: low <= error <= high, in the error's unit.
struct Limits {
  double low = 0.0, high = 0.0;
};

struct Crossing {
  double probability_now = 0.0;          // that the error is outside already
  double probability_within_year = 0.0;  // that it is or comes outside within a year, even if it goes back
  // With 52 calibrations or more: dates by which it is outside with a probability of (1 - coverage) / 2, 1/2, and
  // (1 + coverage) / 2; unset where that is not reached within five years.
  std::optional<base::UtcTime> earliest, median, latest;
};

// As ForecastOf, from the last calibration on; INVALID_ARGUMENT unless low < high. The same state gives the same
// answer: the thousand courses that are drawn have a fixed seed, so probabilities are good to 0.02.
absl::StatusOr<Crossing> CrossingOf(const State& state, const std::string& symbol, const Limits& limits,
                                    const ForecastOptions& options = {});

}  // namespace axiscal::drift

#endif  // AXISCAL_CORE_DRIFT_FORECAST_H_
