#include <cmath>

#include "core/base/units.h"
#include "core/plan/session_builder.h"
#include "core/plan/tests_internal.h"

namespace axiscal::plan {
namespace {

using base::kRadPerDeg;
using machine::Machine;

std::vector<int> TurningAxes(const Situation& situation, const std::vector<int>& branch) {
  std::vector<int> axes;
  for (const int axis : branch) {
    if (situation.machine->axes[axis].kind == machine::AxisKind::kRotary && situation.Turns(axis)) axes.push_back(axis);
  }
  return axes;
}

// Positions of the turning axes on a grid of about `step_deg`, the last one fastest and to and fro, so that no axis
// jumps; then all of it backwards.
std::vector<std::vector<double>> Grid(const Situation& situation, const std::vector<int>& axes, double step_deg) {
  std::vector<std::vector<double>> poses = {std::vector<double>(situation.machine->axis_count(), 0.0)};
  for (const int axis : axes) {
    const Range range = situation.ranges[axis];
    const int steps =
        std::max(1, static_cast<int>(std::lround((range.highest - range.lowest) / (step_deg * kRadPerDeg))));
    std::vector<std::vector<double>> finer;
    for (size_t i = 0; i < poses.size(); ++i) {
      for (int k = 0; k <= steps; ++k) {
        std::vector<double> pose = poses[i];
        pose[axis] = range.lowest + (range.highest - range.lowest) * (i % 2 == 0 ? k : steps - k) / steps;
        finer.push_back(pose);
      }
    }
    poses = std::move(finer);
  }
  const size_t count = poses.size();
  for (size_t i = count - 1; i-- > 0;) poses.push_back(poses[i]);
  return poses;
}

struct Mounting {
  std::string name, text;
  Eigen::Vector3d tip_mm, ball_mm;
};

// The tool and ball in use, another tool, and the ball at other places of the table.
std::vector<Mounting> Mountings(const Situation& situation) {
  constexpr double kOtherToolMm = 120.0, kOutMm = 100.0, kUpMm = 60.0;
  const Eigen::Vector3d tip_mm = situation.tips_mm.front(), ball_mm = situation.balls_mm.back();
  const Eigen::Vector3d out_mm = ball_mm + Eigen::Vector3d(0.0, ball_mm.y() > 0.0 ? -kOutMm : kOutMm, kUpMm);
  return {{"", "the tool and the place of the ball in use", tip_mm, ball_mm},
          {"-long", "a tool 120 mm longer than the longest so far",
           situation.tips_mm.back() + kOtherToolMm * situation.machine->tool_direction, ball_mm},
          {"-out", "the ball 100 mm further across and 60 mm higher", tip_mm, out_mm}};
}

}  // namespace

std::vector<PlannedSession> RtestGrids(const Situation& situation) {
  const Machine& machine = *situation.machine;
  const std::vector<int> head = TurningAxes(situation, machine.tool_branch);
  const std::vector<int> table = TurningAxes(situation, machine.work_branch);
  std::vector<int> both = head;
  both.insert(both.end(), table.begin(), table.end());
  struct Part {
    std::string name;
    std::vector<int> axes;
  };
  std::vector<Part> parts;
  if (!head.empty()) parts.push_back({"head", head});
  if (!table.empty()) parts.push_back({"table", table});
  if (!head.empty() && !table.empty()) parts.push_back({"both", both});
  std::vector<PlannedSession> planned;
  for (const Part& part : parts) {
    const double step_deg = part.axes.size() == 1 ? 10.0 : 30.0;
    for (const Mounting& mounting : Mountings(situation)) {
      SessionBuilder builder(situation, absl::StrCat("nest-", part.name, mounting.name), mounting.tip_mm,
                             mounting.ball_mm);
      for (const std::vector<double>& pose : Grid(situation, part.axes, step_deg))
        builder.Add(pose, Eigen::Vector3d::Zero());
      if (!builder.is_possible()) continue;
      std::string names;
      for (const int axis : part.axes) absl::StrAppend(&names, names.empty() ? "" : ", ", machine.axes[axis].name);
      planned.push_back({builder.Finish(), absl::StrFormat("R-test over a grid of %s (%.0f deg) there and back, %s",
                                                           names, step_deg, mounting.text)});
    }
  }
  return planned;
}

// Every axis in turn leaves the pose by a little and comes back, to one side and to the other; the sensors' range bears
// it.
std::vector<PlannedSession> RtestApproaches(const Situation& situation) {
  const Machine& machine = *situation.machine;
  constexpr double kAwayMm = 0.5, kAwayRad = 2.0 * kRadPerDeg;
  std::vector<int> rotary = TurningAxes(situation, machine.tool_branch);
  for (const int axis : TurningAxes(situation, machine.work_branch)) rotary.push_back(axis);
  std::vector<std::vector<double>> poses = {std::vector<double>(machine.axis_count(), 0.0)};
  for (const int axis : rotary) {
    for (const double share : {0.25, 0.5, 0.75}) {
      poses.push_back(poses.front());
      poses.back()[axis] =
          situation.ranges[axis].lowest + share * (situation.ranges[axis].highest - situation.ranges[axis].lowest);
    }
  }
  SessionBuilder builder(situation, "nest-approach", situation.tips_mm.front(), situation.balls_mm.back());
  for (const std::vector<double>& pose : poses) {
    builder.Add(pose, Eigen::Vector3d::Zero());
    for (int direction = 0; direction < 3; ++direction) {
      for (const double side : {-1.0, 1.0, -1.0, 1.0}) {
        builder.AddInBed(pose, side * kAwayMm * Eigen::Vector3d::Unit(direction));
        builder.AddInBed(pose, Eigen::Vector3d::Zero());
      }
    }
    for (const int axis : rotary) {
      for (const double side : {-1.0, 1.0, -1.0, 1.0}) {
        std::vector<double> away = pose;
        away[axis] += side * kAwayRad;
        builder.Add(away, Eigen::Vector3d::Zero());
        builder.Add(pose, Eigen::Vector3d::Zero());
      }
    }
  }
  if (!builder.is_possible()) return {};
  return {
      {builder.Finish(),
       absl::StrFormat("R-test at %u poses, each approached by one axis at a time from both senses", poses.size())}};
}

}  // namespace axiscal::plan
