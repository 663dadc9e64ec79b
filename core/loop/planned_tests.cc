#include "core/loop/planned_tests.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "core/identify/noise.h"
#include "core/plan/passes.h"
#include "core/plan/planned_run.h"

namespace axiscal::loop {
namespace {

using instruments::Kind;
using instruments::MeasuringRun;

// Noise of one kind of instrument as the fit judged it.
identify::Noise NoiseOf(const identify::Problem& measured, const MeasuringRun& planned) {
  identify::Noise noise;
  int count = 0;
  for (size_t i = 0; i < measured.runs.size(); ++i) {
    if (measured.runs[i].kind != planned.kind) continue;
    noise.sigma_mm += measured.noise[i].sigma_mm;
    noise.ar1 += measured.noise[i].ar1;
    noise.white_share += measured.noise[i].white_share;
    ++count;
  }
  if (count == 0) return {planned.sigma_mm, 0.0};
  return {noise.sigma_mm / count, noise.ar1 / count, noise.white_share / count};
}

// At most `most` readings at irregular distances (a regular stride would alias harmonics), each with the motion that
// the whole session gives it. Sigma shrinks so that they weigh what all of them would; correlated readings weigh less.
MeasuringRun Thinned(const MeasuringRun& run, int most, identify::Noise* noise) {
  const int count = run.reading_count(), kept = std::min(most, count);
  const double stride = static_cast<double>(count) / kept, golden = 0.6180339887498949;
  MeasuringRun out = run;
  out.positions.clear();
  out.time_s.clear();
  out.temperature_celsius.clear();
  std::vector<shapes::AxisState> states;
  for (int i = 0; i < kept; ++i) {
    double whole = 0.0;
    const int k = std::min(count - 1, static_cast<int>(stride * (i + std::modf(golden * (i + 1), &whole))));
    const size_t from = static_cast<size_t>(k) * run.axis_count;
    out.positions.insert(out.positions.end(), run.positions.begin() + from,
                         run.positions.begin() + from + run.axis_count);
    states.insert(states.end(), run.AxisStatesOf(k), run.AxisStatesOf(k) + run.axis_count);
    out.time_s.push_back(run.time_s[k]);
    out.temperature_celsius.push_back(run.temperature_celsius[k]);
  }
  out.axis_states = std::move(states);
  out.measured_mm = run.measured_mm.leftCols(kept);
  *noise = {noise->sigma_mm * std::sqrt(identify::LongRunShare(*noise) / stride)};
  return out;
}

}  // namespace

std::vector<PlannedTest> PlanTests(const identify::Problem& measured, const machine::ErrorModel& fitted) {
  const machine::Machine& machine = *measured.machine;
  const plan::Situation situation = plan::SituationOf(machine, measured.runs);
  std::set<std::string> taken;
  for (const MeasuringRun& run : measured.runs) taken.insert(run.session);
  std::vector<PlannedTest> tests;
  const auto add = [&](const plan::Test& test, const plan::PlannedSession& planned, const std::string& beyond) {
    absl::StatusOr<MeasuringRun> run = plan::PlannedRun(machine, planned.session);
    if (!run.ok() || !taken.insert(run->session).second) return;
    const identify::Noise whole_noise = NoiseOf(measured, *run);
    identify::Noise noise = whole_noise;
    const int most = run->row_count == 1 ? 120 : 90;
    absl::StatusOr<identify::Problem> problem = identify::MakeProblem(machine, {Thinned(*run, most, &noise)});
    if (!problem.ok()) return;
    problem->noise[0] = noise;
    const bool is_bar = run->kind == Kind::kBallbar;
    const double begins_s = run->time_s.front(), ends_s = run->time_s.back();
    const bool has_time = run->has_time;
    tests.push_back({.test = test.name,
                     .planned = planned,
                     .run = *std::move(run),
                     .rows = TestRows(*std::move(problem), fitted),
                     .noise = whole_noise,
                     .beyond = beyond,
                     .has_used_instrument = is_bar ? situation.ballbar.is_used : situation.rtest.is_used,
                     .seconds = ends_s - begins_s,
                     .end_s = has_time ? ends_s : 0.0});
  };
  for (const plan::Test& test : plan::Tests()) {
    for (const plan::PlannedSession& planned : test.plan(situation)) {
      const plan::Reach reach = plan::ReachOf(situation, planned.session);
      constexpr double kFarMm = 200.0;
      if (!reach.is_reachable || reach.beyond_mm > kFarMm) continue;
      add(test, planned, reach.text);
      constexpr int kPasses = 4, kMostReadings = 4000;
      if (kPasses * planned.session.reading_count() < kMostReadings)
        add(test, plan::InPasses(planned, kPasses), reach.text);
    }
  }
  return tests;
}

identify::Problem Together(const identify::Problem& measured, const std::vector<const PlannedTest*>& tests) {
  identify::Problem together = measured;
  for (const PlannedTest* test : tests) {
    const int group = static_cast<int>(together.groups.size()), run = static_cast<int>(together.runs.size());
    together.runs.push_back(test->run);
    together.noise.push_back(test->noise);
    together.is_used.emplace_back(test->run.measured_mm.size(), true);
    together.groups.push_back({test->run.setup, {run}});
    together.group_of_run.push_back(group);
    std::vector<Eigen::Index>& offsets = together.offsets_of_run.emplace_back(test->run.setup.size());
    std::iota(offsets.begin(), offsets.end(), 0);
  }
  return together;
}

}  // namespace axiscal::loop
