// Identification as published measurements ask for it: columns probed at 24 poses of a tilting table, twelve errors and
// the columns' place (Ibaraki; goal: 20 ms), and 1,000 runs of a grinder's error budget (Fang, ch. 4; goal: 2
// s).
#include <benchmark/benchmark.h>

#include "core/base/files.h"
#include "core/base/testing/source_path.h"
#include "core/identify/identify.h"
#include "core/identify/monte_carlo.h"
#include "core/machine/error_json.h"
#include "core/machine/machine_json.h"
#include "core/session/read_session.h"

namespace axiscal::identify {
namespace {

std::string Example(const std::string& name) { return base::SourcePath("/deploy/examples/") + name; }

void Report(const absl::Status& status, benchmark::State& state) {
  if (!status.ok()) state.SkipWithError(std::string(status.message()).c_str());
}

// Eight location errors, a sag of A, and what varies with C: twelve numbers from 360 touches.
void BM_ColumnsAt24Poses(benchmark::State& state) {
  const machine::Machine machine = machine::ReadMachineFile(Example("ibaraki-columns/machine.json")).value();
  const std::vector<session::Session> sessions = {
      session::ReadSessionFile(Example("ibaraki-columns/fit/columns.csv")).value()};
  Options options;
  options.model = machine::ReadErrors(R"({"EY0A": 0, "EZ0A": 0, "EB0A": 0, "EC0A": 0, "EX0C": 0, "EY0C": 0, "EA0C": 0,
      "EB0C": 0, "terms": [{"symbol": "EZA", "shape": "quadratic", "amplitude": 0},
      {"symbol": "EYA", "shape": "quadratic", "amplitude": 0},
      {"symbol": "ECC", "shape": "harmonic", "order": 2, "amplitude": 0, "phase_deg": 0}]})",
                                      machine)
                      .value();
  for (auto _ : state) {
    const auto result = Identify(machine, sessions, options);
    Report(result.status(), state);
    if (result.ok()) state.counters["rank"] = result->rank;
  }
}
BENCHMARK(BM_ColumnsAt24Poses)->Unit(benchmark::kMillisecond);

// Twelve functions at 24 poses as maps, a value per node: 144 numbers and the columns' place.
void BM_MapsAt24Poses(benchmark::State& state) {
  const machine::Machine machine = machine::ReadMachineFile(Example("ibaraki-columns/machine.json")).value();
  const std::vector<session::Session> sessions = {
      session::ReadSessionFile(Example("ibaraki-columns/fit/columns.csv")).value()};
  std::string terms;
  for (const char* component : {"EX", "EY", "EZ", "EA", "EB", "EC"}) {
    absl::StrAppend(&terms, terms.empty() ? "" : ",", R"({"symbol": ")", component,
                    R"(A", "shape": "tabulated", "nodes_deg": [-90, -60, -30, 0], "amplitude": 0}, {"symbol": ")",
                    component,
                    R"(C", "shape": "tabulated", "nodes_deg": [0, 60, 120, 180, 240, 300], "zero_mean": true,
                    "over": {"variable": "A", "nodes_deg": [-90, -60, -30, 0]}, "amplitude": 0})");
  }
  Options options;
  options.model = machine::ReadErrors(absl::StrCat("{\"terms\": [", terms, "]}"), machine).value();
  for (auto _ : state) {
    const auto result = Identify(machine, sessions, options);
    Report(result.status(), state);
    if (result.ok()) state.counters["rank"] = result->rank;
  }
}
BENCHMARK(BM_MapsAt24Poses)->Unit(benchmark::kMillisecond);

void BM_MonteCarloOfTheGrinder(benchmark::State& state) {
  const machine::Machine machine = machine::ReadMachineFile(Example("fang-grinder/machine.json")).value();
  const std::vector<session::Session> sessions = {
      session::ReadSessionFile(Example("fang-grinder/fit/pattern-1.csv")).value(),
      session::ReadSessionFile(Example("fang-grinder/fit/pattern-2.csv")).value()};
  MonteCarloOptions options;
  options.runs = static_cast<int>(state.range(0));
  options.budget = ReadBudget(base::ReadFile(Example("fang-grinder/budget.json"), 1 << 20).value(), machine).value();
  Options fit_options;
  fit_options.budget = options.budget;
  const Fit fit = FitSessions(machine, sessions, fit_options).value();
  for (auto _ : state) {
    const auto result = MonteCarlo(fit, options);
    Report(result.status(), state);
    if (result.ok()) state.counters["failed"] = result->failed;
  }
}
BENCHMARK(BM_MonteCarloOfTheGrinder)->Arg(1'000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace axiscal::identify
