// A sphere on the table probed at a grid of the rotary axes; the controller's cycle, or the program of
// probing_program.h, gives its centre at each pose (Yao 2022, ch. 5).
#include <cmath>

#include "core/base/units.h"
#include "core/instruments/centres/centres_model.h"
#include "core/plan/session_builder.h"
#include "core/plan/tests_internal.h"

namespace axiscal::plan {
namespace {

constexpr double kSigmaMm = 2e-3;           // a touch probe's centre from five touches
constexpr double kSecondsPerCentre = 60.0;  // five touches

struct Part {
  int axis;
  std::string name;
  Eigen::Vector3d tip_mm;
  int swung = -1;  // another rotary axis, which stands at `at` meanwhile
  double at = 0.0;
};

// A quarter turn, or as far to either side as the axis gets; 0 where that is not far.
double SwungTo(const Range& range) {
  constexpr double kQuarter = 90.0 * base::kRadPerDeg, kFar = 20.0 * base::kRadPerDeg;
  const double to =
      range.highest >= -range.lowest ? std::min(range.highest, kQuarter) : std::max(range.lowest, -kQuarter);
  return std::abs(to) < kFar ? 0.0 : to;
}

}  // namespace

std::vector<PlannedSession> SphereProbing(const Situation& situation) {
  const machine::Machine& machine = *situation.machine;
  constexpr double kOtherToolMm = 50.0, kStepRad = 30.0 * base::kRadPerDeg, kFullTurn = 359.0 * base::kRadPerDeg;
  std::vector<PlannedSession> planned;
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    if (machine.axes[axis].kind != machine::AxisKind::kRotary || !situation.Turns(axis)) continue;
    const std::string& axis_name = machine.axes[axis].name;
    std::vector<Part> parts = {
        {axis, axis_name, situation.tips_mm.front()},
        {axis, axis_name + "-long", situation.tips_mm.front() + kOtherToolMm * machine.tool_direction}};
    // Fang 2022: the head's B seen with C a quarter turn round shows what it hides at zero.
    for (int other = 0; other < machine.axis_count(); ++other) {
      if (other == axis || machine.axes[other].kind != machine::AxisKind::kRotary) continue;
      const double at = SwungTo(situation.ranges[other]);
      if (at == 0.0) continue;
      parts.push_back({axis,
                       absl::StrFormat("%s-at-%s%.4g", axis_name, machine.axes[other].name, at * base::kDegPerRad),
                       situation.tips_mm.front(), other, at});
    }
    for (const Part& part : parts) {
      const Eigen::Vector3d ball_mm = situation.balls_mm.front();
      const std::string name = absl::StrCat("sphere-", part.name);
      PlannedSession session;
      session.session.header = HeaderOf(machine, name, part.tip_mm, ball_mm, 0.0, kSigmaMm);
      for (session::HeaderEntry& entry : session.session.header) {
        if (entry.key == "instrument") entry.value = "centres";
      }
      // What reduces the touches compares their sphere with these.
      session.session.header.push_back({"sphere_radius_mm", absl::StrFormat("%.10g", situation.sphere_radius_mm)});
      session.session.header.push_back({"stylus_radius_mm", absl::StrFormat("%.10g", situation.stylus_radius_mm)});
      session.session.columns = {{"t_s", {}, {}}};
      for (const machine::Axis& a : machine.axes) {
        if (a.kind == machine::AxisKind::kRotary) session.session.columns.push_back({a.name + "_deg", {}, {}});
      }
      const Range range = situation.ranges[axis];
      int steps = std::max(1, static_cast<int>(std::lround((range.highest - range.lowest) / kStepRad)));
      const double step = (range.highest - range.lowest) / steps;
      if (range.highest - range.lowest > kFullTurn) --steps;  // a whole turn ends where it began
      bool is_possible = true;
      for (int k = 0; k <= steps; ++k) {
        std::vector<double> positions(machine.axis_count(), 0.0);
        positions[axis] = range.lowest + k * step;
        if (part.swung >= 0) positions[part.swung] = part.at;
        std::vector<double> commands = positions;
        is_possible &= centres::SolveNominalCommands(machine, part.tip_mm, ball_mm, commands.data()).ok();
        session.session.columns[0].values.push_back(Rounded(situation.start_s + k * kSecondsPerCentre));
        size_t column = 1;
        for (int i = 0; i < machine.axis_count(); ++i) {
          if (machine.axes[i].kind != machine::AxisKind::kRotary) continue;
          session.session.columns[column++].values.push_back(Rounded(positions[i] * base::kDegPerRad));
        }
      }
      if (!is_possible) continue;
      session.text = absl::StrFormat("centres of a sphere on the table at %d positions of %s, stylus %.0f mm from home",
                                     steps + 1, axis_name, part.tip_mm.dot(machine.tool_direction));
      if (part.swung >= 0)
        absl::StrAppendFormat(&session.text, ", %s at %.4g deg", machine.axes[part.swung].name,
                              part.at * base::kDegPerRad);
      planned.push_back(std::move(session));
    }
  }
  return planned;
}

}  // namespace axiscal::plan
