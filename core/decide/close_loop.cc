#include "core/decide/close_loop.h"

#include <algorithm>

#include "core/decide/decide.h"
#include "core/instruments/repeated.h"
#include "core/predict/box_poses.h"

namespace axiscal::decide {
namespace {

using instruments::MeasuringRun;

// The loop's share of the progress, where a simulation comes after it.
constexpr double kLoopShare = 0.3;

// Fit and check sessions: errors that drift or follow a temperature are judged in both.
absl::Status CheckAllRecorded(const machine::Machine& machine, const std::vector<MeasuringRun>& fit,
                              const std::vector<MeasuringRun>& check) {
  std::vector<MeasuringRun> first;  // what is compared, without readings
  for (const std::vector<MeasuringRun>* runs : {&fit, &check}) {
    for (const MeasuringRun& run : *runs) {
      MeasuringRun& one = first.emplace_back();
      one.session = run.session;
      one.has_time = run.has_time;
      one.has_temperature = run.has_temperature;
      for (const MeasuringRun::Channel& channel : run.temperatures) one.temperatures.push_back({channel.name, {}});
      one.path_readings = run.path_readings;
    }
  }
  return identify::CheckRecorded(machine, first, machine::DeclaredModel(machine));
}

// Before any work: names of sessions that are not there.
absl::Status CheckBudget(const std::vector<MeasuringRun>& fit, const Options& options) {
  if (!options.monte_carlo) return absl::OkStatus();
  std::vector<std::string> names;
  for (const MeasuringRun& run : fit) names.push_back(run.session);
  return identify::CheckSessions(options.monte_carlo->budget, names);
}

absl::Status Simulate(const Options& options, loop::Report* report) {
  identify::MonteCarloOptions simulation = *options.monte_carlo;
  simulation.cancelled = options.cancelled;
  simulation.progress = [&options, runs = simulation.runs](double fraction) {
    if (options.progress)
      options.progress({"simulating", kLoopShare + (1.0 - kLoopShare) * fraction, absl::StrCat(runs, " runs")});
  };
  ASSIGN_OR_RETURN(report->monte_carlo, identify::MonteCarlo(*report->last_fit, simulation));
  report->budget_json = options.budget_json;
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<loop::Report> CloseLoop(const machine::Machine& machine, std::vector<MeasuringRun> fit,
                                       std::vector<MeasuringRun> check, const Options& options) {
  RETURN_IF_ERROR(instruments::CheckRepeated(fit, check));
  RETURN_IF_ERROR(CheckAllRecorded(machine, fit, check));
  RETURN_IF_ERROR(CheckBudget(fit, options));
  Options own = options;
  if (options.monte_carlo && options.progress) {
    own.progress = [&options](identify::Progress one) {
      one.fraction *= kLoopShare;
      options.progress(one);
    };
  }
  const predict::Box of_fit = predict::MeasuredBox(fit), of_check = predict::MeasuredBox(check);
  ASSIGN_OR_RETURN(loop::Report report, Decide(machine, std::move(fit), std::move(check), own));
  report.measured = predict::RangesOf(machine, report.is_check_fitted ? predict::Around(of_fit, of_check) : of_fit);
  if (options.monte_carlo) RETURN_IF_ERROR(Simulate(options, &report));
  return report;
}

}  // namespace axiscal::decide
