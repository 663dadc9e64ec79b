#include "core/plan/situation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/units.h"

namespace axiscal::plan {
namespace {

using instruments::Kind;
using instruments::MeasuringRun;

constexpr double kSameMm = 0.5;

void AddPoint(const Eigen::Vector3d& point_mm, std::vector<Eigen::Vector3d>* points_mm) {
  const auto is_same = [&](const Eigen::Vector3d& other) { return (other - point_mm).norm() < kSameMm; };
  if (std::none_of(points_mm->begin(), points_mm->end(), is_same)) points_mm->push_back(point_mm);
}

void AddUse(const MeasuringRun& run, InstrumentUse* use) {
  use->sigma_mm = use->is_used ? std::min(use->sigma_mm, run.sigma_mm) : run.sigma_mm;
  use->is_used = true;
  const int count = run.reading_count();
  if (run.has_time && count > 1 && run.time_s.back() > run.time_s.front())
    use->seconds_per_reading = (run.time_s.back() - run.time_s.front()) / (count - 1);
}

// A point of the last rotary axis of a branch, where tool or artefact stand if nobody says; else the origin.
Eigen::Vector3d OnOutermostAxis(const machine::Machine& machine, const std::vector<int>& branch) {
  for (auto axis = branch.rbegin(); axis != branch.rend(); ++axis) {
    if (machine.axes[*axis].kind == machine::AxisKind::kRotary) return machine.axes[*axis].point_mm;
  }
  return Eigen::Vector3d::Zero();
}

constexpr double kTurn = 2.0 * std::numbers::pi;

bool HasTravel(const machine::Axis& axis) { return axis.min_position && axis.max_position; }

bool IsOfTable(const machine::Machine& machine, int axis) {
  return std::find(machine.work_branch.begin(), machine.work_branch.end(), axis) != machine.work_branch.end();
}

// `range` cut by whatever limit is stated.
Range Within(const machine::Axis& axis, Range range) {
  if (axis.min_position) range.lowest = std::max(range.lowest, *axis.min_position);
  if (axis.max_position) range.highest = std::min(range.highest, *axis.max_position);
  return range.lowest < range.highest ? range : Range{};
}

Range RangeOf(const machine::Machine& machine, int axis) {
  const machine::Axis& a = machine.axes[axis];
  if (TurningOf(machine, axis) == Turning::kRound) {
    if (!HasTravel(a)) return Within(a, {0.0, kTurn});
    // One turn from zero where the travel has it, else from its lower end.
    const double lowest = *a.min_position <= 0.0 && *a.max_position >= kTurn ? 0.0 : *a.min_position;
    return {lowest, std::min(lowest + kTurn, *a.max_position)};
  }
  const Range upright = Within(a, {-0.25 * kTurn, 0.25 * kTurn});
  const bool is_elsewhere = upright.lowest == upright.highest && HasTravel(a);
  return is_elsewhere ? Range{*a.min_position, *a.max_position} : upright;
}

}  // namespace

Turning TurningOf(const machine::Machine& machine, int axis) {
  const machine::Axis& a = machine.axes[axis];
  if (!IsOfTable(machine, axis)) return Turning::kTilts;
  constexpr double kWholeTurn = 359.0 * base::kRadPerDeg, kAlong = 0.9;
  if (HasTravel(a) && *a.max_position - *a.min_position > kWholeTurn) return Turning::kRound;
  return std::abs(a.direction.dot(machine.tool_direction)) > kAlong ? Turning::kRound : Turning::kTilts;
}

std::vector<std::string> TiltingWithoutTravel(const machine::Machine& machine) {
  std::vector<std::string> names;
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    const machine::Axis& a = machine.axes[axis];
    if (a.kind == machine::AxisKind::kRotary && !HasTravel(a) && TurningOf(machine, axis) == Turning::kTilts)
      names.push_back(a.name);
  }
  return names;
}

Situation SituationOf(const machine::Machine& machine, const std::vector<MeasuringRun>& runs) {
  Situation situation;
  situation.machine = &machine;
  situation.ranges.assign(machine.axis_count(), {INFINITY, -INFINITY});
  situation.ballbar = {false, 0.3 * base::kMmPerUm, 0.25};
  situation.rtest = {false, 0.7 * base::kMmPerUm, 10.0};
  double celsius = 0.0, readings = 0.0, end_s = 0.0;
  for (const MeasuringRun& run : runs) {
    situation.runs.push_back(&run);
    for (int k = 0; k < run.reading_count(); ++k) {
      for (int axis = 0; axis < machine.axis_count(); ++axis) {
        Range& range = situation.ranges[axis];
        range.lowest = std::min(range.lowest, run.PositionsOf(k)[axis]);
        range.highest = std::max(range.highest, run.PositionsOf(k)[axis]);
      }
      celsius += run.temperature_celsius[k];
    }
    readings += run.reading_count();
    AddPoint(run.tip_mm, &situation.tips_mm);
    const bool has_ball = run.kind != Kind::kTracker && run.kind != Kind::kLength && run.kind != Kind::kDirection;
    if (has_ball) AddPoint(run.ball_mm, &situation.balls_mm);
    if (run.kind == Kind::kBallbar) {
      AddUse(run, &situation.ballbar);
      const auto is_same = [&](double length_mm) { return std::abs(length_mm - run.bar_length_mm) < kSameMm; };
      if (std::none_of(situation.bars_mm.begin(), situation.bars_mm.end(), is_same))
        situation.bars_mm.push_back(run.bar_length_mm);
    }
    if (run.kind == Kind::kTouch) situation.stylus_radius_mm = run.touches.stylus_radius_mm;
    if (run.kind == Kind::kRtest) AddUse(run, &situation.rtest);
    situation.has_time |= run.has_time;
    situation.has_temperature |= run.has_temperature;
    if (run.has_time) end_s = std::max(end_s, run.time_s.back());
  }
  for (Range& range : situation.ranges) {
    if (range.lowest > range.highest) range = {};
  }
  if (readings > 0.0) situation.temperature_celsius = celsius / readings;
  constexpr double kMountingS = 600.0, kToolMm = 150.0, kBarMm = 100.0;
  situation.start_s = runs.empty() ? 0.0 : end_s + kMountingS;
  if (situation.tips_mm.empty())
    situation.tips_mm.push_back(OnOutermostAxis(machine, machine.tool_branch) + kToolMm * machine.tool_direction);
  if (situation.balls_mm.empty()) situation.balls_mm.push_back(OnOutermostAxis(machine, machine.work_branch));
  if (situation.bars_mm.empty()) situation.bars_mm.push_back(kBarMm);
  std::sort(situation.tips_mm.begin(), situation.tips_mm.end(), [&](const auto& a, const auto& b) {
    return a.dot(machine.tool_direction) < b.dot(machine.tool_direction);
  });
  std::sort(situation.bars_mm.begin(), situation.bars_mm.end());
  return situation;
}

Situation SituationOfMachine(const machine::Machine& machine, const Mounted& mounted) {
  Situation situation = SituationOf(machine, {});
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    if (machine.axes[axis].kind == machine::AxisKind::kRotary) situation.ranges[axis] = RangeOf(machine, axis);
  }
  situation.stylus_radius_mm = mounted.stylus_radius_mm;
  situation.sphere_radius_mm = mounted.sphere_radius_mm;
  if (!mounted.tips_mm.empty()) situation.tips_mm = mounted.tips_mm;
  if (!mounted.balls_mm.empty()) situation.balls_mm = mounted.balls_mm;
  if (!mounted.bars_mm.empty()) situation.bars_mm = mounted.bars_mm;
  return situation;
}

}  // namespace axiscal::plan
