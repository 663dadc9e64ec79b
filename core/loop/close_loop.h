// Closing the loop: fit the declared model, find what it lacks, add it, prove it on data that was not used
// (docs/loop.md).
#ifndef AXISCAL_CORE_LOOP_CLOSE_LOOP_H_
#define AXISCAL_CORE_LOOP_CLOSE_LOOP_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/identify/identify.h"
#include "core/identify/monte_carlo.h"
#include "core/loop/report.h"

namespace axiscal::loop {

struct Options {
  SearchOptions search;
  int max_effects = 8;
  // Simulates the fit sessions under the extended model when the loop has ended; its `cancelled` and `progress` are the
  // loop's. The budget's text goes into the report.
  std::optional<identify::MonteCarloOptions> monte_carlo;
  std::string budget_json;
  std::function<bool()> cancelled;
  std::function<void(const identify::Progress&)> progress;  // of a simulation from any thread
};

// INVALID_ARGUMENT or FAILED_PRECONDITION as Identify and MonteCarlo; CANCELLED.
absl::StatusOr<Report> CloseLoop(const machine::Machine& machine, std::vector<instruments::MeasuringRun> fit,
                                 std::vector<instruments::MeasuringRun> check, const Options& options = {});

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_CLOSE_LOOP_H_
