// A multi-tasking machine measured by ball bar, as Yao 2022 measured it: five patterns, two tools.
#ifndef AXISCAL_CORE_IDENTIFY_TESTING_SCENARIO_H_
#define AXISCAL_CORE_IDENTIFY_TESTING_SCENARIO_H_

#include <string>
#include <vector>

#include "core/instruments/ballbar/ballbar_plan.h"
#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"
#include "core/synthetic/simulate.h"

namespace axiscal::identify::testing {

inline machine::ErrorModel Errors(const machine::Machine& machine, const std::string& json) {
  return machine::ReadErrors(json, machine).value();
}

struct Measured {
  std::string name;
  ballbar::Pattern pattern;
  double tool_length_mm;
};

inline std::vector<Measured> FivePatterns() {
  return {{"BX", ballbar::Pattern::kBX, 356.4},
          {"BY", ballbar::Pattern::kBY, 356.4},
          {"CR", ballbar::Pattern::kCR, 356.4},
          {"CA", ballbar::Pattern::kCA, 356.4},
          {"CR-long", ballbar::Pattern::kCR, 406.4}};
}

inline std::vector<session::Session> Measure(const machine::Machine& machine, const machine::ErrorModel& truth,
                                             synthetic::NoiseOptions noise,
                                             const std::vector<Measured>& patterns = FivePatterns(),
                                             ballbar::PatternOptions options = {}) {
  std::vector<session::Session> sessions;
  for (const Measured& measured : patterns) {
    options.tool_length_mm = measured.tool_length_mm;
    const session::Session planned = ballbar::PlanPattern(machine, measured.name, measured.pattern, options).value();
    noise.seed = noise.seed * 31 + sessions.size() + 1;
    sessions.push_back(synthetic::Simulate(machine, truth, planned, noise).value());
    options.start_s += 720.0;
  }
  return sessions;
}

}  // namespace axiscal::identify::testing

#endif  // AXISCAL_CORE_IDENTIFY_TESTING_SCENARIO_H_
