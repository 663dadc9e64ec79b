// Identification of thirteen errors from ball-bar readings (eight sessions of six patterns, two of them with a second
// tool), with covariance, rank and named combinations, on one core. Arg is the number of readings: time must grow no
// faster.
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/identify/identify.h"
#include "core/instruments/ballbar/ballbar_plan.h"
#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"
#include "core/synthetic/simulate.h"

namespace axiscal::identify {
namespace {

using ballbar::Pattern;

const machine::Machine& Machine() {
  static const machine::Machine* const machine = new machine::Machine(machine::testing::MultiTasking());
  return *machine;
}

// All thirteen deviations that Yao's model of this machine has; one combination of them no ball bar can see.
machine::ErrorModel Errors() {
  return machine::ReadErrors(R"({"EA0T": 40, "EX0T": -12, "EZ0T": 30, "EA0B": 82, "EB0B": 40, "EC0B": -61, "EC0X": 30,
      "EA0Y": 0, "EB0Y": 50, "EA0C": -43, "EB0C": 46, "EX0C": -22, "EY0C": 15})",
                             Machine())
      .value();
}

struct Measured {
  const char* name;
  Pattern pattern;
  double tool_length_mm;
};
constexpr Measured kMeasured[] = {{"BX", Pattern::kBX, 356.4},      {"BY", Pattern::kBY, 356.4},
                                  {"BZ", Pattern::kBZ, 356.4},      {"CR", Pattern::kCR, 356.4},
                                  {"CA", Pattern::kCA, 356.4},      {"CX", Pattern::kCX, 356.4},
                                  {"CR-long", Pattern::kCR, 406.4}, {"CX-long", Pattern::kCX, 406.4}};

// Eight sessions of readings / 8 readings each, there and back.
std::vector<session::Session> Sessions(int64_t readings) {
  std::vector<session::Session> sessions;
  for (const Measured& measured : kMeasured) {
    ballbar::PatternOptions options;
    options.tool_length_mm = measured.tool_length_mm;
    const double steps = std::round((static_cast<double>(readings) / std::size(kMeasured) - 1.0) / 2.0);
    options.step_deg = (ballbar::TurnsB(measured.pattern) ? 90.0 : 360.0) / steps;
    options.start_s = 600.0 * static_cast<double>(sessions.size());
    const auto planned = ballbar::PlanPattern(Machine(), measured.name, measured.pattern, options);
    synthetic::NoiseOptions noise;
    noise.seed = sessions.size() + 1;
    sessions.push_back(synthetic::Simulate(Machine(), Errors(), planned.value(), noise).value());
  }
  return sessions;
}

void Count(benchmark::State& state, const std::vector<instruments::MeasuringRun>& runs) {
  int64_t readings = 0;
  for (const auto& run : runs) readings += run.reading_count();
  state.counters["readings"] = static_cast<double>(readings);
  state.counters["readings/s"] =
      benchmark::Counter(static_cast<double>(state.iterations() * readings), benchmark::Counter::kIsRate);
}

Options ThirteenErrors(bool with_shapes) {
  Options options;
  options.model = Errors();
  if (with_shapes) {
    const machine::ErrorModel more = machine::ReadErrors(R"({"terms": [
        {"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 1},
        {"symbol": "EYY", "shape": "backlash", "variable": "Y", "amplitude": 1},
        {"symbol": "EZC", "shape": "harmonic", "variable": "C", "order": 2, "amplitude": 1, "phase_deg": 0},
        {"symbol": "EZT", "shape": "drift", "amplitude": 1}]})",
                                                         Machine())
                                         .value();
    options.model->terms.insert(options.model->terms.end(), more.terms.begin(), more.terms.end());
  }
  for (machine::ErrorTerm& term : options.model->terms) term.amplitude.fill(0.0);
  return options;
}

// From sessions in memory to bound runs: columns to core units, the motion that led to each reading.
void BM_Bind(benchmark::State& state) {
  const std::vector<session::Session> sessions = Sessions(state.range(0));
  std::vector<instruments::MeasuringRun> runs;
  for (auto _ : state) {
    runs = BindSessions(Machine(), sessions).value();
    benchmark::DoNotOptimize(runs.data());
  }
  Count(state, runs);
}
BENCHMARK(BM_Bind)->Arg(3'000)->Arg(30'000)->Arg(300'000)->Unit(benchmark::kMillisecond);

// From bound runs to the report: rank and null directions, iterations, outliers, covariance, correlations, names.
void BM_Fit(benchmark::State& state, bool with_shapes) {
  const std::vector<instruments::MeasuringRun> runs = BindSessions(Machine(), Sessions(state.range(0))).value();
  const Options options = ThirteenErrors(with_shapes);
  for (auto _ : state) {
    const auto fit = FitRuns(Machine(), runs, options);
    if (!fit.ok()) state.SkipWithError(std::string(fit.status().message()).c_str());
    state.counters["rank"] = fit->result.rank;
    state.counters["iterations"] = fit->result.iterations;
    state.counters["outliers"] = static_cast<double>(fit->result.outliers.size());
  }
  Count(state, runs);
}
BENCHMARK_CAPTURE(BM_Fit, thirteen_errors, false)->Arg(3'000)->Arg(30'000)->Arg(300'000)->Unit(benchmark::kMillisecond);
// Beside them a scale error, a backlash, a harmonic and a drift: errors that differ from reading to reading.
BENCHMARK_CAPTURE(BM_Fit, and_four_shapes, true)->Arg(3'000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace axiscal::identify
