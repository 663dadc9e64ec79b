#include "tests/rates/coverage.h"

#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>

#include "core/decide/close_loop.h"
#include "core/identify/gauge.h"
#include "core/identify/identify.h"
#include "tests/rates/score.h"

namespace axiscal::rates {
namespace {

// One number with the half-width of its 95 % interval in standard uncertainties, counted under "all" and every other
// name once.
void Count(double deviation, double sigma, double factor, std::initializer_list<std::string> names,
           CoverageByKind* coverage) {
  for (const std::string& name : names) {
    Coverage& one = (*coverage)[name];
    ++one.intervals;
    one.held += std::abs(deviation) <= factor * sigma;  // false for NaN
    one.squares += deviation * deviation / (sigma * sigma);
  }
}

// Every keep_every-th reading; what led to a reading stays as it was measured.
instruments::MeasuringRun Thin(const instruments::MeasuringRun& run, int keep_every) {
  instruments::MeasuringRun thin = run;
  thin.positions.clear();
  thin.axis_states.clear();
  thin.time_s.clear();
  thin.temperature_celsius.clear();
  thin.measured_mm.resize(run.row_count, (run.reading_count() + keep_every - 1) / keep_every);
  for (int k = 0; k < run.reading_count(); k += keep_every) {
    const int at = k * run.axis_count;
    for (int i = at; i < at + run.axis_count; ++i) {
      thin.positions.push_back(run.positions[i]);
      thin.axis_states.push_back(run.axis_states[i]);
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
  const std::vector<identify::Parameter> parameters = identify::ListParameters(truth, false);
  const size_t declared = simulated.declared.terms.size();
  for (size_t i = 0; i < parameters.size(); ++i) {
    const identify::Estimate& estimate = fit->result.estimates[i];
    if (!estimate.identifiable) continue;
    const machine::ErrorTerm& term = truth.terms[parameters[i].term];
    const bool is_effect = parameters[i].term >= static_cast<int>(declared);
    Count(estimate.value - identify::ValueOf(truth, parameters[i]), estimate.sigma, fit->result.coverage_factor,
          {"all", machine,
           is_effect                          ? "effect"
           : machine::IsAngle(term.component) ? "angle"
                                              : "length"},
          coverage);
  }
  // In the order of Result::determined: what a free error carries of the held ones (core/identify/identify.cc).
  const identify::NullSpace space = identify::AtNominal(fit->problem, *options.model).null_space;
  size_t next = 0;
  for (int j = 0; j < static_cast<int>(parameters.size()); ++j) {
    const bool is_held = std::find(space.fixed.begin(), space.fixed.end(), j) != space.fixed.end();
    if (!space.involved[j] || is_held) continue;
    double true_value = identify::ValueOf(truth, parameters[j]);
    for (size_t k = 0; k < space.fixed.size(); ++k)
      true_value -= space.directions(k, j) * identify::ValueOf(truth, parameters[space.fixed[k]]);
    const identify::Combination& combination = fit->result.determined.at(next++);
    Count(combination.value - true_value, combination.sigma, fit->result.coverage_factor,
          {"all", machine, "combination"}, coverage);
  }
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

std::string ToText(const CoverageByKind& coverage) {
  std::string text;
  for (const auto& [name, one] : coverage) {
    absl::StrAppendFormat(&text, "%-28s %5d intervals, %6.2f %% hold the truth, deviation rms %.3f sigma\n", name,
                          one.intervals, 100.0 * one.share(), std::sqrt(one.squares / one.intervals));
  }
  return text;
}

}  // namespace axiscal::rates
