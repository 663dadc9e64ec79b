// Artefacts touched hit by hit: every touch is a reading (instrument `touch`). The artefact stands at the situation's
// table ball: a sphere's centre, a plate's middle, the middle between columns or blocks at their feet.
//   plate: 200 x 200 mm          columns: Ibaraki et al., three of 50 x 50 x 120 mm, 300 mm apart
//   blocks: Liu et al., four cubes of 10 mm at (+-30, 0) and (0, +-30), whose outer faces are touched
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/base/units.h"
#include "core/plan/tests_internal.h"
#include "core/plan/touch_builder.h"

namespace axiscal::plan {
namespace {

using Pose = std::vector<double>;  // per axis, rad; linear ones 0

std::vector<int> TurningAxes(const Situation& situation) {
  std::vector<int> axes;
  for (int axis = 0; axis < situation.machine->axis_count(); ++axis) {
    const bool is_rotary = situation.machine->axes[axis].kind == machine::AxisKind::kRotary;
    if (is_rotary && situation.Turns(axis)) axes.push_back(axis);
  }
  return axes;
}

// Positions of an axis over its range, about `step_rad` apart; of a whole turn without its end.
std::vector<double> PositionsOf(const Situation& situation, int axis, double step_rad) {
  constexpr double kFullTurn = 359.0 * base::kRadPerDeg;
  const Range& range = situation.ranges[axis];
  const double width = range.highest - range.lowest;
  const int steps = std::max(1, static_cast<int>(std::lround(width / step_rad)));
  std::vector<double> positions;
  for (int k = 0; k < steps + (width > kFullTurn ? 0 : 1); ++k) positions.push_back(range.lowest + width * k / steps);
  return positions;
}

Pose Home(const Situation& situation) { return Pose(situation.machine->axis_count(), 0.0); }

// The machine axis that points from the table to the spindle at home, or 0 where none does: blocks stand along it.
Eigen::Vector3d UpAtHome(const machine::Machine& machine) {
  int along = 0;
  machine.tool_direction.cwiseAbs().maxCoeff(&along);
  if (std::abs(machine.tool_direction[along]) < 0.999) return Eigen::Vector3d::Zero();
  return (machine.tool_direction[along] > 0.0 ? -1.0 : 1.0) * Eigen::Vector3d::Unit(along);
}

// up, and two machine axes across it.
struct Frame {
  Eigen::Vector3d up, u, v;
};
Frame FrameOf(const machine::Machine& machine) {
  const Eigen::Vector3d up = UpAtHome(machine);
  int along = 0;
  up.cwiseAbs().maxCoeff(&along);
  return {up, Eigen::Vector3d::Unit((along + 1) % 3), Eigen::Vector3d::Unit((along + 2) % 3)};
}

void AddIfSeen(TouchBuilder& builder, const std::string& text, std::vector<PlannedSession>* planned) {
  constexpr int kFewest = 6;  // the set-up alone has as many unknowns
  if (builder.touch_count() <= kFewest) return;
  planned->push_back(builder.Finish(absl::StrCat(builder.touch_count(), " touches: ", text)));
}

// The pole and two rings of four. Each position has its rings turned, so that the probe is touched from all around: its
// lobes show.
void TouchNine(const Pose& pose, size_t number, TouchBuilder* builder) {
  constexpr double kTurnedDeg = 15.0;
  const Eigen::Vector3d up = builder->Up(pose), across = up.unitOrthogonal();
  builder->TouchSphere(pose, "ball", up);
  for (const double from_pole_deg : {45.0, 80.0}) {
    const double angle = from_pole_deg * base::kRadPerDeg;
    const double first_deg = kTurnedDeg * static_cast<double>(number) + (from_pole_deg > 45.0 ? 45.0 : 0.0);
    for (int side = 0; side < 4; ++side) {
      const Eigen::Vector3d out = Eigen::AngleAxisd((first_deg + 90.0 * side) * base::kRadPerDeg, up) * across;
      builder->TouchSphere(pose, "ball", std::cos(angle) * up + std::sin(angle) * out);
    }
  }
}

Eigen::Vector3d Halves(const Frame& frame, double across_mm, double along_mm) {
  return (across_mm * (frame.u + frame.v) + along_mm * frame.up).cwiseAbs();
}

}  // namespace

std::vector<PlannedSession> TouchSpheres(const Situation& situation) {
  constexpr double kOtherToolMm = 50.0, kStepRad = 30.0 * base::kRadPerDeg;
  std::vector<PlannedSession> planned;
  for (const int axis : TurningAxes(situation)) {
    for (const double longer_mm : {0.0, kOtherToolMm}) {
      const Eigen::Vector3d tip_mm = situation.tips_mm.front() + longer_mm * situation.machine->tool_direction;
      const std::string name = situation.machine->axes[axis].name;
      TouchBuilder builder(situation, "touch-sphere-" + name + (longer_mm > 0.0 ? "-long" : ""), tip_mm);
      builder.SetTable(UpAtHome(*situation.machine));
      builder.AddSphere("ball", situation.balls_mm.front(), situation.sphere_radius_mm);
      const std::vector<double> positions = PositionsOf(situation, axis, kStepRad);
      for (size_t k = 0; k < positions.size(); ++k) {
        Pose pose = Home(situation);
        pose[axis] = positions[k];
        TouchNine(pose, k, &builder);
      }
      AddIfSeen(builder,
                absl::StrFormat("a sphere of radius %g mm at %d positions of %s, stylus %.0f mm from home",
                                situation.sphere_radius_mm, builder.pose_count(), name,
                                tip_mm.dot(situation.machine->tool_direction)),
                &planned);
    }
  }
  return planned;
}

std::vector<PlannedSession> TouchPlates(const Situation& situation) {
  constexpr double kHalfMm = 100.0, kThickMm = 10.0, kOutMm = 80.0, kStepRad = 30.0 * base::kRadPerDeg;
  const Frame frame = FrameOf(*situation.machine);
  std::vector<PlannedSession> planned;
  if (frame.up.isZero()) return planned;
  const Eigen::Vector3d middle_mm = situation.balls_mm.front();
  for (const int axis : TurningAxes(situation)) {
    const std::string name = situation.machine->axes[axis].name;
    TouchBuilder builder(situation, "touch-plate-" + name, situation.tips_mm.front());
    builder.SetTable(frame.up);
    builder.AddBox("plate", middle_mm - kThickMm * frame.up, Halves(frame, kHalfMm, kThickMm));
    for (const double position : PositionsOf(situation, axis, kStepRad)) {
      Pose pose = Home(situation);
      pose[axis] = position;
      for (int i = -1; i <= 1; ++i) {
        for (int j = -1; j <= 1; ++j)
          builder.TouchFace(pose, "plate", frame.up, middle_mm + kOutMm * (i * frame.u + j * frame.v));
      }
    }
    AddIfSeen(builder, "a plate of 200 x 200 mm, nine places at each position of " + name, &planned);
  }
  return planned;
}

std::vector<PlannedSession> TouchColumns(const Situation& situation) {
  constexpr double kHalfMm = 25.0, kHeightMm = 120.0, kLowMm = 40.0, kHighMm = 100.0, kApartMm = 300.0;
  const Frame frame = FrameOf(*situation.machine);
  const std::vector<int> axes = TurningAxes(situation);
  std::vector<PlannedSession> planned;
  if (frame.up.isZero() || axes.empty()) return planned;
  std::vector<Pose> poses = {Home(situation)};
  for (const int axis : axes) {
    // Ibaraki's grid: an axis within half a turn by 30 degrees, one that turns round by 60.
    const bool is_round = situation.ranges[axis].highest - situation.ranges[axis].lowest > std::numbers::pi + 1e-6;
    std::vector<Pose> further;
    for (const Pose& pose : poses) {
      for (const double position : PositionsOf(situation, axis, (is_round ? 60.0 : 30.0) * base::kRadPerDeg)) {
        further.push_back(pose);
        further.back()[axis] = position;
      }
    }
    poses = std::move(further);
  }
  TouchBuilder builder(situation, "touch-columns", situation.tips_mm.front());
  builder.SetTable(frame.up);
  std::vector<Eigen::Vector3d> feet_mm;
  for (int column = 0; column < 3; ++column) {
    const double at = column * 2.0 * std::numbers::pi / 3.0, away_mm = kApartMm / std::sqrt(3.0);
    feet_mm.push_back(situation.balls_mm.front() + away_mm * (std::cos(at) * frame.u + std::sin(at) * frame.v));
    builder.AddBox(absl::StrCat("column", column + 1), feet_mm.back() + 0.5 * kHeightMm * frame.up,
                   Halves(frame, kHalfMm, 0.5 * kHeightMm));
  }
  for (const Pose& pose : poses) {
    for (int column = 0; column < 3; ++column) {
      const std::string name = absl::StrCat("column", column + 1);
      builder.TouchFace(pose, name, frame.up, feet_mm[column] + kHeightMm * frame.up);
      for (const Eigen::Vector3d& n : {frame.u, frame.v, Eigen::Vector3d(-frame.u), Eigen::Vector3d(-frame.v)}) {
        for (const double height_mm : {kLowMm, kHighMm})
          builder.TouchFace(pose, name, n, feet_mm[column] + kHalfMm * n + height_mm * frame.up);
      }
    }
  }
  AddIfSeen(builder,
            absl::StrCat("three square columns of 50 x 50 x 120 mm, 300 mm apart, at ", builder.pose_count(),
                         " poses of the rotary axes"),
            &planned);
  return planned;
}

std::vector<PlannedSession> TouchBlockPairs(const Situation& situation) {
  constexpr double kHalfMm = 5.0, kAwayMm = 30.0, kStepRad = 30.0 * base::kRadPerDeg;
  const Frame frame = FrameOf(*situation.machine);
  const std::vector<int> axes = TurningAxes(situation);
  std::vector<PlannedSession> planned;
  if (frame.up.isZero() || axes.empty()) return planned;
  TouchBuilder builder(situation, "touch-blocks", situation.tips_mm.front());
  builder.SetTable(frame.up);
  const std::vector<Eigen::Vector3d> sides = {frame.u, -frame.u, frame.v, -frame.v};
  const auto name_of = [](size_t side) { return absl::StrCat("block", side + 1); };
  std::vector<Eigen::Vector3d> middles_mm;
  for (size_t side = 0; side < sides.size(); ++side) {
    middles_mm.push_back(situation.balls_mm.front() + kAwayMm * sides[side] + kHalfMm * frame.up);
    builder.AddBox(name_of(side), middles_mm.back(), Halves(frame, kHalfMm, kHalfMm));
  }
  std::vector<Pose> poses = {Home(situation)};
  for (const int axis : axes) {
    for (const double position : PositionsOf(situation, axis, kStepRad)) {
      if (std::abs(position) < 1e-6) continue;  // home is there
      poses.push_back(Home(situation));
      poses.back()[axis] = position;
    }
  }
  for (const Pose& pose : poses) {
    for (size_t side = 0; side < sides.size(); ++side) {
      builder.TouchFace(pose, name_of(side), sides[side], middles_mm[side] + kHalfMm * sides[side]);
      builder.TouchFace(pose, name_of(side), frame.up, middles_mm[side] + kHalfMm * frame.up);
    }
  }
  AddIfSeen(builder, absl::StrCat("four cubes of 10 mm in pairs 60 mm apart, at ", builder.pose_count(), " poses"),
            &planned);
  return planned;
}

}  // namespace axiscal::plan
