// Closing the loop: fit the declared model, find what it lacks by the one objective, prove it on sessions that no
// amplitude was fitted to (docs/loop.md).
#ifndef AXISCAL_CORE_DECIDE_CLOSE_LOOP_H_
#define AXISCAL_CORE_DECIDE_CLOSE_LOOP_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/identify/identify.h"
#include "core/identify/monte_carlo.h"
#include "core/loop/report.h"
#include "core/objective/policy.h"

namespace axiscal::decide {

struct Options {
  // The search ends with this many effects and slips. None: with what pays.
  std::optional<int> max_effects;
  // Simulates the fit sessions under the extended model when the loop has ended; its `cancelled` and `progress` are the
  // loop's. The budget's text goes into the report.
  std::optional<identify::MonteCarloOptions> monte_carlo;
  std::string budget_json;
  std::function<bool()> cancelled;
  std::function<void(const identify::Progress&)> progress;  // of a simulation from any thread
  objective::Policy policy;
  // Of what can be wrong, what the search may name; bad readings always. Empty: everything.
  std::function<bool(const loop::Candidate&)> may_name;
};

// INVALID_ARGUMENT or FAILED_PRECONDITION as Identify and MonteCarlo; CANCELLED.
absl::StatusOr<loop::Report> CloseLoop(const machine::Machine& machine, std::vector<instruments::MeasuringRun> fit,
                                       std::vector<instruments::MeasuringRun> check, const Options& options = {});

}  // namespace axiscal::decide

#endif  // AXISCAL_CORE_DECIDE_CLOSE_LOOP_H_
