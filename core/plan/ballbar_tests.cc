#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/units.h"
#include "core/instruments/ballbar/ballbar_plan.h"
#include "core/instruments/evaluation.h"
#include "core/plan/session_builder.h"
#include "core/plan/tests_internal.h"

namespace axiscal::plan {
namespace {

using base::kRadPerDeg;
using machine::Machine;

constexpr double kOtherToolMm = 120.0;  // a second holder: this much longer than the longest in use

std::vector<Eigen::Vector3d> TipsToTry(const Situation& situation) {
  return {situation.tips_mm.front(), situation.tips_mm.back() + kOtherToolMm * situation.machine->tool_direction};
}

std::string ToolText(const Situation& situation, const Eigen::Vector3d& tip_mm) {
  return absl::StrFormat("tool point %.0f mm from home", tip_mm.dot(situation.machine->tool_direction));
}

// A ball that stands at this distance from C's line at least, as the patterns of C want it.
double RadiusOf(const Situation& situation) {
  const int c = machine::FindAxis(*situation.machine, "C");
  const Eigen::Vector3d line_mm = c < 0 ? Eigen::Vector3d::Zero() : situation.machine->axes[c].point_mm;
  constexpr double kUsualMm = 50.0, kOffLineMm = 10.0;
  for (const Eigen::Vector3d& ball_mm : situation.balls_mm) {
    const double radius_mm = std::hypot(ball_mm.x() - line_mm.x(), ball_mm.y() - line_mm.y());
    if (radius_mm > kOffLineMm) return radius_mm;
  }
  return kUsualMm;
}

std::vector<double> Home(const Situation& situation) {
  return std::vector<double>(situation.machine->axis_count(), 0.0);
}

}  // namespace

bool KeepsTheBar(const Machine& machine, const session::Session& planned) {
  session::Session session = planned;
  session.columns.push_back({"dL_mm", std::vector<double>(planned.reading_count(), 0.0), {}});
  const auto run = instruments::BindSession(session, machine);
  if (!run.ok()) return false;
  const std::vector<double> setup(instruments::kMaxSetupParameters, 0.0);
  constexpr double kKeptMm = 0.1;
  for (int k = 0; k < run->reading_count(); ++k) {
    double length_mm[instruments::kMaxRows];
    instruments::Predict(machine, *run, k, {}, setup.data(), length_mm);
    if (!(std::abs(length_mm[0]) < kKeptMm)) return false;
  }
  return true;
}

std::vector<PlannedSession> BallbarPatterns(const Situation& situation) {
  std::vector<PlannedSession> planned;
  ballbar::PatternOptions options;
  options.bar_length_mm = situation.bars_mm.front();
  options.ball_height_mm = situation.balls_mm.front().z();
  options.ball_radius_mm = RadiusOf(situation);
  options.sigma_um = situation.ballbar.sigma_mm * base::kUmPerMm;
  options.seconds_per_reading = situation.ballbar.seconds_per_reading;
  options.start_s = situation.start_s;
  const int b = machine::FindAxis(*situation.machine, "B");
  if (b < 0) return {};
  const Eigen::Vector3d pivot_mm = situation.machine->axes[b].point_mm;
  for (const Eigen::Vector3d& tip_mm : TipsToTry(situation)) {
    constexpr double kOffPivotMm = 1e-6;
    const Eigen::Vector3d off_mm = tip_mm - pivot_mm;
    if (std::hypot(off_mm.x(), off_mm.y()) > kOffPivotMm) continue;  // the patterns hold for a tool through the pivot
    options.tool_length_mm = off_mm.dot(situation.machine->tool_direction);
    for (const auto& [name, pattern] : ballbar::Patterns()) {
      const std::string session_name = absl::StrFormat("%s-%.0f", name, options.tool_length_mm);
      auto session = ballbar::PlanPattern(*situation.machine, session_name, pattern, options);
      if (!session.ok()) return {};
      if (situation.has_temperature) {
        session->columns.push_back(
            {"temp_C", std::vector<double>(session->reading_count(), Rounded(situation.temperature_celsius)), {}});
      }
      if (!KeepsTheBar(*situation.machine, *session)) continue;
      planned.push_back(
          {std::move(*session), absl::StrFormat("ball-bar pattern %s there and back, bar %.0f mm, %s", name,
                                                options.bar_length_mm, ToolText(situation, tip_mm))});
    }
  }
  return planned;
}

namespace {

// A rotary axis out of the way: at 90 degrees, or as far as it has been.
struct Swung {
  int axis = 0;
  double degrees = 0.0;
  std::vector<double> positions;
};

std::vector<Swung> SwungAxes(const Situation& situation) {
  const Machine& machine = *situation.machine;
  std::vector<Swung> all;
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    if (machine.axes[axis].kind != machine::AxisKind::kRotary || !situation.Turns(axis)) continue;
    std::vector<double> positions = Home(situation);
    const Range range = situation.ranges[axis];
    positions[axis] = std::clamp(0.5 * std::numbers::pi, range.lowest, range.highest);
    if (positions[axis] <= 0.0) positions[axis] = std::clamp(-0.5 * std::numbers::pi, range.lowest, range.highest);
    all.push_back({axis, positions[axis] * base::kDegPerRad, positions});
  }
  return all;
}

// The tip keeps its distance from the ball along one direction of the bed, `directions` of x y z, while one rotary axis
// turns.
void AddTurns(const Situation& situation, int axis, const std::vector<int>& directions,
              const std::vector<double>& place, const std::string& suffix, const std::string& text,
              std::vector<PlannedSession>* planned) {
  const Machine& machine = *situation.machine;
  const double bar_mm = situation.bars_mm.front();
  const Range range = situation.ranges[axis];
  const int steps = std::max(1, static_cast<int>((range.highest - range.lowest) / (2.0 * kRadPerDeg)));
  for (const int direction : directions) {
    const std::string name = absl::StrCat(machine.axes[axis].name, "-bar-", std::string(1, "XYZ"[direction]), suffix);
    SessionBuilder builder(situation, name, situation.tips_mm.front(), situation.balls_mm.back(), bar_mm);
    for (int k = 0; k <= 2 * steps; ++k) {
      std::vector<double> positions = place;
      positions[axis] = range.lowest + (range.highest - range.lowest) * (k <= steps ? k : 2 * steps - k) / steps;
      builder.AddInBed(positions, bar_mm * Eigen::Vector3d::Unit(direction));
    }
    if (!builder.is_possible()) continue;
    planned->push_back(
        {builder.Finish(), absl::StrFormat("ball bar of %.0f mm along %c while %s turns there and back%s", bar_mm,
                                           "XYZ"[direction], machine.axes[axis].name, text)});
  }
}

}  // namespace

// The patterns on any structure.
std::vector<PlannedSession> BallbarTurns(const Situation& situation) {
  const Machine& machine = *situation.machine;
  if (!BallbarPatterns(situation).empty()) return {};
  std::vector<PlannedSession> planned;
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    if (machine.axes[axis].kind != machine::AxisKind::kRotary || !situation.Turns(axis)) continue;
    AddTurns(situation, axis, {0, 1, 2}, Home(situation), "", "", &planned);
  }
  return planned;
}

std::vector<PlannedSession> BallbarSwungTurns(const Situation& situation) {
  const Machine& machine = *situation.machine;
  std::vector<PlannedSession> planned;
  for (const Swung& swung : SwungAxes(situation)) {
    const std::string& name = machine.axes[swung.axis].name;
    for (int axis = 0; axis < machine.axis_count(); ++axis) {
      if (axis == swung.axis || machine.axes[axis].kind != machine::AxisKind::kRotary || !situation.Turns(axis))
        continue;
      // Along the axis of the turn two offsets of the ball would show in second order only: no fit likes that.
      std::vector<int> across;
      for (int direction = 0; direction < 3; ++direction) {
        if (std::abs(machine.axes[axis].direction[direction]) < 0.5) across.push_back(direction);
      }
      AddTurns(situation, axis, across, swung.positions, absl::StrFormat("-%s%.0f", name, swung.degrees),
               absl::StrFormat(", %s at %.0f deg", name, swung.degrees), &planned);
    }
  }
  return planned;
}

std::vector<PlannedSession> BallbarCircles(const Situation& situation) {
  struct Place {
    std::string name, text;
    Eigen::Vector3d shift_mm, longer_mm;
    std::vector<double> positions;
  };
  const Machine& machine = *situation.machine;
  constexpr double kShiftMm = 80.0;
  const Eigen::Vector3d none_mm(0, 0, 0);
  std::vector<Place> places = {
      {"", "", none_mm, none_mm, Home(situation)},
      {"-x80", ", the ball 80 mm further in x", {kShiftMm, 0, 0}, none_mm, Home(situation)},
      {"-y80", ", the ball 80 mm further in y", {0, kShiftMm, 0}, none_mm, Home(situation)},
      {"-z80", ", the ball 80 mm higher", {0, 0, kShiftMm}, none_mm, Home(situation)},
      {"-long", ", a tool 120 mm longer", none_mm, kOtherToolMm * machine.tool_direction, Home(situation)}};
  for (const Swung& swung : SwungAxes(situation)) {
    const std::string& name = machine.axes[swung.axis].name;
    places.push_back({absl::StrFormat("-%s%.0f", name, swung.degrees),
                      absl::StrFormat(", %s at %.0f deg", name, swung.degrees), none_mm, none_mm, swung.positions});
  }
  const std::vector<std::pair<int, int>> planes = {{0, 1}, {2, 0}, {1, 2}};
  std::vector<PlannedSession> planned;
  const double bar_mm = situation.bars_mm.back();
  for (const auto& [first, second] : planes) {
    const std::string plane = {"XYZ"[first], "XYZ"[second]};
    for (const Place& place : places) {
      const std::string name = absl::StrFormat("circle-%s-%.0f%s", plane, bar_mm, place.name);
      SessionBuilder builder(situation, name, situation.tips_mm.front() + place.longer_mm,
                             situation.balls_mm.front() + place.shift_mm, bar_mm);
      constexpr int kReadings = 180;  // per turn
      for (int k = 0; k <= 2 * kReadings; ++k) {
        const double angle = 2.0 * std::numbers::pi / kReadings * (k <= kReadings ? k : 2 * kReadings - k);
        Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();
        offset_mm[first] = bar_mm * std::cos(angle);
        offset_mm[second] = bar_mm * std::sin(angle);
        builder.AddInBed(place.positions, offset_mm);
      }
      if (!builder.is_possible()) continue;
      planned.push_back({builder.Finish(), absl::StrFormat("ball-bar circle in %s, radius %.0f mm, both senses%s",
                                                           plane, bar_mm, place.text)});
    }
  }
  return planned;
}

}  // namespace axiscal::plan
