#include "tests/rates/coverage.h"

#include <algorithm>
#include <cmath>

#include "core/decide/close_loop.h"
#include "core/identify/identify.h"
#include "tests/rates/score.h"

namespace axiscal::rates {
namespace {

// Every keep_every-th reading; what led to a reading stays as it was measured.
instruments::MeasuringRun Thin(const instruments::MeasuringRun& run, int keep_every) {
  instruments::MeasuringRun thin = run;
  thin.positions.clear();
  std::vector<shapes::AxisState>& states = thin.axis_states.Own();
  states.clear();
  thin.time_s.clear();
  thin.temperature_celsius.clear();
  thin.measured_mm.resize(run.row_count, (run.reading_count() + keep_every - 1) / keep_every);
  for (int k = 0; k < run.reading_count(); k += keep_every) {
    const int at = k * run.axis_count;
    for (int i = at; i < at + run.axis_count; ++i) {
      thin.positions.push_back(run.positions[i]);
      states.push_back((*run.axis_states)[i]);
    }
    thin.time_s.push_back(run.time_s[k]);
    thin.temperature_celsius.push_back(run.temperature_celsius[k]);
    thin.measured_mm.col(k / keep_every) = run.measured_mm.col(k);
  }
  return thin;
}

}  // namespace

bool AddIdentified(const SimulatedCase& simulated, int keep_every, CoverageByKind* coverage) {
  machine::ErrorModel truth = simulated.declared;
  truth.terms.insert(truth.terms.end(), simulated.effects.terms.begin(), simulated.effects.terms.end());
  identify::Options options;
  options.fit_nonlinear = false;
  options.model = truth;
  for (machine::ErrorTerm& term : options.model->terms) term.amplitude.fill(0.0);
  std::vector<instruments::MeasuringRun> runs;
  for (const instruments::MeasuringRun& run : simulated.fit) runs.push_back(Thin(run, keep_every));
  const absl::StatusOr<identify::Fit> fit = identify::FitRuns(simulated.machine, runs, options);
  if (!fit.ok()) return false;

  const std::string machine = "machine " + simulated.machine.id;
  const size_t declared = simulated.declared.terms.size();
  AddResult(
      fit->result, truth, {"all", machine},
      [&](const identify::Parameter* parameter) -> std::string {
        if (parameter == nullptr) return "combination";
        if (parameter->term >= static_cast<int>(declared)) return "effect";
        return machine::IsAngle(truth.terms[parameter->term].component) ? "angle" : "length";
      },
      coverage);
  return true;
}

void AddClosed(const SimulatedCase& simulated, CoverageByKind* coverage) {
  const absl::StatusOr<loop::Report> report = decide::CloseLoop(simulated.machine, simulated.fit, simulated.check);
  if (!report.ok()) return;
  for (const loop::Effect& effect : report->effects) {
    for (const machine::ErrorTerm& truth : simulated.effects.terms) {
      if (!IsSame(effect.term, truth)) continue;
      const bool has_phase = shapes::HasPhase(truth.shape);
      const double amplitude =
          has_phase ? std::hypot(truth.amplitude[0], truth.amplitude[1]) : std::abs(truth.amplitude[0]);
      Count(std::abs(effect.amplitude) - amplitude, effect.amplitude_sigma, report->fitted.coverage_factor,
            {"all", "effect"}, coverage);
    }
  }
}

}  // namespace axiscal::rates
