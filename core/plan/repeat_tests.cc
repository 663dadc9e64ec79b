#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/plan/session_builder.h"
#include "core/plan/tests_internal.h"

namespace axiscal::plan {
namespace {

using instruments::MeasuringRun;

constexpr double kPauseS = 7200.0, kWarmerCelsius = 4.0;
constexpr size_t kRepeated = 12;  // sessions; more are repeats of repeats

// Where a repeated session reads: at reading `index` plus `share` of the way to the next.
struct Moment {
  int index = 0;
  double share = 0.0;
};

PlannedSession Repeat(const Situation& situation, const MeasuringRun& run, const std::vector<Moment>& moments,
                      const std::string& suffix, double start_s, double warmer_celsius) {
  const machine::Machine& machine = *situation.machine;
  const bool is_ballbar = run.kind == instruments::Kind::kBallbar;
  session::Session session;
  session.header = HeaderOf(machine, run.session + suffix, run.tip_mm, run.ball_mm,
                            is_ballbar ? run.bar_length_mm : 0.0, run.sigma_mm);
  session.columns = ColumnsOf(situation);
  const int count = run.reading_count();
  const double step_s = run.has_time && count > 1
                            ? (run.time_s.back() - run.time_s.front()) / (count - 1)
                            : (is_ballbar ? situation.ballbar : situation.rtest).seconds_per_reading;
  for (size_t k = 0; k < moments.size(); ++k) {
    const double* from = run.PositionsOf(moments[k].index);
    const double* to = run.PositionsOf(std::min(moments[k].index + 1, count - 1));
    session.columns[0].values.push_back(Rounded(start_s + step_s * static_cast<double>(k)));
    for (int axis = 0; axis < machine.axis_count(); ++axis) {
      const double unit = machine.axes[axis].kind == machine::AxisKind::kRotary ? base::kDegPerRad : 1.0;
      session.columns[1 + axis].values.push_back(
          Rounded(unit * (from[axis] + moments[k].share * (to[axis] - from[axis]))));
    }
    if (situation.has_temperature)
      session.columns.back().values.push_back(Rounded(situation.temperature_celsius + warmer_celsius));
  }
  return {std::move(session), ""};
}

std::vector<Moment> Forwards(const MeasuringRun& run) {
  std::vector<Moment> moments;
  for (int k = 0; k < run.reading_count(); ++k) moments.push_back({k, 0.0});
  return moments;
}

// Sessions of instruments that can be planned.
std::vector<const MeasuringRun*> Repeatable(const Situation& situation) {
  std::vector<const MeasuringRun*> runs;
  for (const MeasuringRun* run : situation.runs) {
    const bool is_known = run->kind == instruments::Kind::kBallbar || run->kind == instruments::Kind::kRtest;
    if (is_known && runs.size() < kRepeated) runs.push_back(run);
  }
  return runs;
}

// The path goes one way: what comes after the middle is not what came before it, mirrored.
bool HasOneSense(const MeasuringRun& run) {
  const int count = run.reading_count();
  double gap = 0.0, travel = 0.0;
  for (int axis = 0; axis < run.axis_count; ++axis) {
    for (int k = 1; k < count / 2; ++k) {
      gap = std::max(gap, std::abs(run.PositionsOf(k)[axis] - run.PositionsOf(count - 1 - k)[axis]));
      travel = std::max(travel, std::abs(run.PositionsOf(k)[axis] - run.PositionsOf(0)[axis]));
    }
  }
  constexpr double kMirrored = 0.05;
  return gap > kMirrored * travel;
}

std::vector<PlannedSession> RepeatAll(const Situation& situation, const std::string& suffix, double after_s,
                                      double warmer_celsius, const std::string& text) {
  std::vector<PlannedSession> planned;
  for (const MeasuringRun* run : Repeatable(situation)) {
    planned.push_back(Repeat(situation, *run, Forwards(*run), suffix, situation.start_s + after_s, warmer_celsius));
    planned.back().text = absl::StrFormat("session %s again, %s", run->session, text);
  }
  return planned;
}

}  // namespace

std::vector<PlannedSession> OtherSense(const Situation& situation) {
  std::vector<PlannedSession> planned;
  for (const MeasuringRun* run : Repeatable(situation)) {
    if (!HasOneSense(*run)) continue;
    std::vector<Moment> moments = Forwards(*run);
    std::reverse(moments.begin(), moments.end());
    planned.push_back(Repeat(situation, *run, moments, "-reversed", situation.start_s, 0.0));
    planned.back().text = absl::StrFormat("session %s run backwards", run->session);
  }
  return planned;
}

std::vector<PlannedSession> Later(const Situation& situation) {
  if (!situation.has_time) return {};
  return RepeatAll(situation, "-later", kPauseS, 0.0, "two hours later");
}

std::vector<PlannedSession> Warmer(const Situation& situation) {
  if (!situation.has_temperature) return {};
  const std::string text =
      absl::StrFormat("at %.0f deg C (so far %.1f on average)", situation.temperature_celsius + kWarmerCelsius,
                      situation.temperature_celsius);
  std::vector<PlannedSession> planned = RepeatAll(situation, "-warmer", kPauseS, kWarmerCelsius, text);
  Situation warmer = situation;
  warmer.temperature_celsius += kWarmerCelsius;
  warmer.start_s += kPauseS;
  const auto is_planned = [&](const std::string& name) {
    return std::any_of(planned.begin(), planned.end(),
                       [&](const PlannedSession& one) { return session::FindHeader(one.session, "session") == name; });
  };
  for (PlannedSession& grid : RtestGrids(warmer)) {
    const std::string name = session::FindHeader(grid.session, "session").value_or("") + "-warmer";
    if (is_planned(name)) continue;  // a grid that was measured is repeated as it was
    for (session::HeaderEntry& entry : grid.session.header) {
      if (entry.key == "session") entry.value = name;
    }
    planned.push_back({std::move(grid.session), absl::StrCat(grid.text, ", ", text)});
  }
  return planned;
}

std::vector<PlannedSession> FartherTurned(const Situation& situation) {
  const machine::Machine& machine = *situation.machine;
  constexpr double kFartherRad = 30.0 * base::kRadPerDeg, kTurnRad = 360.0 * base::kRadPerDeg;
  std::vector<PlannedSession> planned;
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    const machine::Axis& a = machine.axes[axis];
    const Range range = situation.ranges[axis];
    if (a.kind != machine::AxisKind::kRotary || !situation.Turns(axis)) continue;
    if (range.highest - range.lowest + 2.0 * kFartherRad > kTurnRad) continue;
    // One axis at a time: the others stand still, and do not turn in the tests of grids.
    Situation farther = situation;
    for (int other = 0; other < machine.axis_count(); ++other) {
      if (other != axis && machine.axes[other].kind == machine::AxisKind::kRotary) farther.ranges[other] = {};
    }
    farther.ranges[axis] = {std::max(range.lowest - kFartherRad, a.min_position.value_or(-INFINITY)),
                            std::min(range.highest + kFartherRad, a.max_position.value_or(INFINITY))};
    std::vector<PlannedSession> tests = RtestGrids(farther);
    for (PlannedSession& turn : BallbarTurns(farther)) tests.push_back(std::move(turn));
    for (PlannedSession& test : tests) {
      for (session::HeaderEntry& entry : test.session.header) {
        if (entry.key == "session") absl::StrAppend(&entry.value, "-", a.name, "-farther");
      }
      absl::StrAppend(&test.text, ", farther than so far");
      planned.push_back(std::move(test));
    }
  }
  return planned;
}

std::vector<PlannedSession> Finer(const Situation& situation) {
  std::vector<PlannedSession> planned;
  for (const MeasuringRun* run : Repeatable(situation)) {
    if (run->kind != instruments::Kind::kBallbar) continue;
    std::vector<Moment> moments;
    for (int k = 0; k + 1 < run->reading_count(); ++k) {
      for (const double share : {0.0, 1.0 / 3.0, 2.0 / 3.0}) moments.push_back({k, share});
    }
    planned.push_back(Repeat(situation, *run, moments, "-finer", situation.start_s, 0.0));
    planned.back().text = absl::StrFormat("session %s again with three readings in place of one", run->session);
  }
  return planned;
}

}  // namespace axiscal::plan
