// The loop over the full dictionary: time per reading stays level from 3,000 to 300,000 readings.
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include "core/decide/close_loop.h"
#include "core/identify/testing/scenario.h"

namespace axiscal {
namespace {

// Five ball-bar patterns of a multi-tasking machine that lacks a backlash, sampled until there are about `readings`.
std::vector<instruments::MeasuringRun> Sessions(const machine::Machine& machine, int readings) {
  const machine::ErrorModel truth = identify::testing::Errors(machine,
                                                              R"({"EA0B": 40, "EX0C": -22.2, "EY0C": 15.3, "EZ0T": 29.9,
           "terms": [{"symbol": "EXX", "shape": "backlash", "amplitude": -2.9}]})");
  constexpr double kDegrees = 2520.0;  // of all five patterns
  ballbar::PatternOptions options;
  options.step_deg = kDegrees / readings;
  return identify::BindSessions(
             machine, identify::testing::Measure(machine, truth, {}, identify::testing::FivePatterns(), options))
      .value();
}

void CloseTheLoop(benchmark::State& state) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const std::vector<instruments::MeasuringRun> runs = Sessions(machine, static_cast<int>(state.range(0)));
  int readings = 0, candidates = 0;
  for (const instruments::MeasuringRun& run : runs) readings += run.reading_count();
  for (auto _ : state) {
    const loop::Report report = decide::CloseLoop(machine, runs, {}).value();
    candidates = report.candidates;
    if (report.effects.size() != 1) state.SkipWithError("the lacking effect was not found");
  }
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  state.counters["readings"] = readings;
  state.counters["candidates"] = candidates;
  state.counters["us_per_reading"] =
      benchmark::Counter(readings * 1e-6, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["peak_MiB"] = static_cast<double>(usage.ru_maxrss) / 1024.0;
}

BENCHMARK(CloseTheLoop)->Arg(3000)->Arg(30000)->Arg(300000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace axiscal
