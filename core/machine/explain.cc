#include "core/machine/explain.h"

#include <cmath>

#include "core/machine/chain.h"

namespace axiscal::machine {
namespace {

constexpr double kSmallCommand = 1e-4;  // mm or rad: the first order is all that counts
constexpr double kToolLengthMm = 100.0;

ChainPose<double> PoseAt(const Machine& machine, int axis, double position) {
  std::vector<double> positions(machine.axes.size(), 0.0);
  positions[axis] = position;
  return EvaluateChain<double>(machine, positions.data(), JointErrors<double>());
}

// A tool point for the purpose of showing where it goes: along the tool from the last pivot of the tool branch.
Eigen::Vector3d ShownTip(const Machine& machine) {
  Eigen::Vector3d pivot_mm = Eigen::Vector3d::Zero();
  for (const int axis : machine.tool_branch) {
    if (machine.axes[axis].kind == AxisKind::kRotary) pivot_mm = machine.axes[axis].point_mm;
  }
  return pivot_mm + kToolLengthMm * machine.tool_direction;
}

Eigen::Vector3d Unit(const Eigen::Vector3d& v) {
  return v.norm() < 1e-9 ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : Eigen::Vector3d(v / v.norm());
}

// Axis of the small turn of the tool against the table, right-handed.
Eigen::Vector3d TurnOf(const ChainPose<double>& pose) {
  const Eigen::Matrix3d turn = pose.bed_from_table.rotation.transpose() * pose.bed_from_tool.rotation;
  return Unit({turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0), turn(1, 0) - turn(0, 1)});
}

// The letter's number (X, A: 0) for axes that ISO 841 names, else -1.
int IsoNumber(const Axis& axis) {
  const std::string letters = axis.kind == AxisKind::kLinear ? "XYZ" : "ABC";
  const size_t found = letters.find(axis.name);
  return axis.name.size() == 1 && found != std::string::npos ? static_cast<int>(found) : -1;
}

// The direction's largest component: 0 1 2 for X Y Z.
int MainAxis(const Eigen::Vector3d& direction) {
  int main = 0;
  direction.cwiseAbs().maxCoeff(&main);
  return main;
}

std::string DirectionText(const Eigen::Vector3d& direction) {
  const int main = MainAxis(direction);
  if (std::abs(std::abs(direction[main]) - 1.0) < 1e-6) {
    return std::string(direction[main] > 0 ? "+" : "-") + "XYZ"[main];
  }
  // Adding 0 makes a -0 a 0.
  const auto rounded = [](double number) { return std::round(number * 1e3) / 1e3 + 0.0; };
  return absl::StrFormat("(%g, %g, %g)", rounded(direction.x()), rounded(direction.y()), rounded(direction.z()));
}

std::string SenseText(bool counter_clockwise) { return counter_clockwise ? "counter-clockwise" : "clockwise"; }

std::string Branch(const Machine& machine, const std::vector<int>& axes) {
  std::string text = "bed";
  for (const int axis : axes) absl::StrAppend(&text, " - ", machine.axes[axis].name);
  return text;
}

// What the axis itself does, in brackets at the line's end: on the work branch the opposite of the tool's motion.
std::string CarriedText(const AxisMotion& motion) {
  const std::string carried = motion.carries_workpiece ? "workpiece" : "tool";
  if (motion.kind == AxisKind::kLinear) {
    return motion.carries_workpiece ? "carries the workpiece, to " + DirectionText(-motion.tool_motion)
                                    : "carries the tool";
  }
  if (!motion.carries_workpiece) return "carries the tool";
  const bool right_handed = motion.tool_motion[MainAxis(motion.tool_motion)] < 0;
  return absl::StrCat("carries the ", carried, ", ", SenseText(right_handed));
}

std::string IsoText(const AxisMotion& motion) {
  if (motion.follows_iso_841) return "";
  const size_t letter = std::string(motion.kind == AxisKind::kLinear ? "XYZ" : "ABC").find(motion.axis);
  const std::string main(1, "XYZ"[letter]);
  return motion.kind == AxisKind::kLinear
             ? absl::StrCat("   ! ISO 841 expects the tool to go to +", main)
             : absl::StrCat("   ! ISO 841 expects counter-clockwise, looking from +", main, " to -", main);
}

}  // namespace

std::vector<AxisMotion> ExplainMotions(const Machine& machine) {
  const Eigen::Vector3d tip_mm = ShownTip(machine);
  std::vector<AxisMotion> motions;
  for (int i = 0; i < machine.axis_count(); ++i) {
    const Axis& axis = machine.axes[i];
    const ChainPose<double> pose = PoseAt(machine, i, kSmallCommand);
    const Eigen::Vector3d tip_moves = Unit(TipInTable(pose, tip_mm) - tip_mm);
    AxisMotion motion;
    motion.axis = axis.name;
    motion.kind = axis.kind;
    for (const int carried : machine.work_branch) motion.carries_workpiece |= carried == i;
    const bool linear = axis.kind == AxisKind::kLinear;
    motion.tool_motion = linear ? tip_moves : TurnOf(pose);
    if (!linear && !motion.carries_workpiece) motion.tip_motion = tip_moves;
    const int iso = IsoNumber(axis);
    motion.follows_iso_841 = iso < 0 || motion.tool_motion[iso] > 0.5;
    motions.push_back(std::move(motion));
  }
  return motions;
}

std::string ToText(const AxisMotion& motion) {
  if (motion.kind == AxisKind::kLinear) {
    return absl::StrCat(motion.axis, "+ moves the tool to ", DirectionText(motion.tool_motion));
  }
  // Seen from the positive side of the axis: a right-handed turn is counter-clockwise.
  const bool positive = motion.tool_motion[MainAxis(motion.tool_motion)] > 0;
  const Eigen::Vector3d from = positive ? motion.tool_motion : Eigen::Vector3d(-motion.tool_motion);
  std::string text = absl::StrCat(motion.axis, "+ turns the tool ", SenseText(positive), ", looking from ",
                                  DirectionText(from), " to ", DirectionText(-from));
  if (!motion.tip_motion.isZero()) absl::StrAppend(&text, "; its tip swings to ", DirectionText(motion.tip_motion));
  return text;
}

std::string Explain(const Machine& machine) {
  std::string text =
      absl::StrCat("machine ", machine.id, machine.structure.empty() ? "" : " (" + machine.structure + ")",
                   ": what a positive command does, seen from the workpiece, all axes at zero\n",
                   "  tool:      ", Branch(machine, machine.tool_branch), " - spindle, tool along ",
                   DirectionText(machine.tool_direction), "\n", "  workpiece: ", Branch(machine, machine.work_branch),
                   " - table\n\n");
  for (const AxisMotion& motion : ExplainMotions(machine)) {
    absl::StrAppend(&text, "  ", ToText(motion), "   [", CarriedText(motion), "]", IsoText(motion), "\n");
  }
  return text;
}

}  // namespace axiscal::machine
