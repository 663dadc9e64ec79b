#include "core/nc/tilted_axes.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace axiscal::nc {
namespace {

constexpr double kSameDirection = 1e-9;

// Turns what stands behind it by its position about `about`, a unit vector in the table's frame at home.
struct Turn {
  int axis;
  Eigen::Vector3d about;
};

// From the table to the tool. Joints of the table turn the tool, as the table sees it, the other way.
std::vector<Turn> TurnsOf(const machine::Machine& machine) {
  std::vector<Turn> turns;
  for (auto axis = machine.work_branch.rbegin(); axis != machine.work_branch.rend(); ++axis) {
    if (machine.axes[*axis].kind == machine::AxisKind::kRotary)
      turns.push_back({*axis, -machine.axes[*axis].direction});
  }
  for (const int axis : machine.tool_branch) {
    if (machine.axes[axis].kind == machine::AxisKind::kRotary) turns.push_back({axis, machine.axes[axis].direction});
  }
  return turns;
}

Eigen::Vector3d Turned(const Turn& turn, double angle_rad, const Eigen::Vector3d& vector) {
  return Eigen::AngleAxisd(angle_rad, turn.about) * vector;
}

// The angle about the turn's axis that brings `from` to `to`, as seen along it; 0 where both stand on it.
double AngleTo(const Turn& turn, const Eigen::Vector3d& from, const Eigen::Vector3d& to, bool* is_free) {
  const Eigen::Vector3d a = from - turn.about * turn.about.dot(from), b = to - turn.about * turn.about.dot(to);
  *is_free = a.norm() < kSameDirection || b.norm() < kSameDirection;
  return *is_free ? 0.0 : std::atan2(turn.about.dot(a.cross(b)), a.dot(b));
}

}  // namespace

int MasterAxis(const machine::Machine& machine) {
  const std::vector<Turn> turns = TurnsOf(machine);
  return turns.empty() ? -1 : turns.back().axis;
}

std::vector<AxisAngles> ToolAlong(const machine::Machine& machine, const Eigen::Vector3d& direction) {
  const std::vector<Turn> turns = TurnsOf(machine);
  std::vector<AxisAngles> found;
  if (turns.empty() || turns.size() > 2) return found;
  const Turn &outer = turns.front(), &inner = turns.back();
  const Eigen::Vector3d home = machine.tool_direction;
  // outer . direction = outer . R(inner, angle) home = along + sine sin(angle) + cosine cos(angle)
  const double along = outer.about.dot(inner.about) * inner.about.dot(home);
  const double cosine = outer.about.dot(home) - along, sine = outer.about.dot(inner.about.cross(home));
  const double reach = std::hypot(cosine, sine), middle = std::atan2(sine, cosine);
  const double share = reach < kSameDirection ? 0.0 : (outer.about.dot(direction) - along) / reach;
  std::vector<double> angles = {0.0};
  if (turns.size() == 2 && std::abs(share) < 1.0 + kSameDirection) {
    const double half = std::acos(std::min(1.0, std::max(-1.0, share)));
    angles = {middle + half};
    if (half > 1e-7 && half < std::numbers::pi - 1e-7) angles.push_back(middle - half);
  }
  for (const double angle : angles) {
    AxisAngles at;
    Eigen::Vector3d turned = home;
    if (turns.size() == 2) {
      at.position_rad[static_cast<size_t>(inner.axis)] = std::remainder(angle, 2.0 * std::numbers::pi);
      turned = Turned(inner, angle, home);
    }
    bool is_free = false;
    const double first = AngleTo(outer, turned, direction, &is_free);
    at.position_rad[static_cast<size_t>(outer.axis)] = first;
    if (is_free) at.free_axis = outer.axis;
    at.outer_axis = outer.axis;
    at.lever = outer.about.cross(direction).norm();
    if ((Turned(outer, first, turned) - direction).norm() < 1e-7) found.push_back(at);
  }
  return found;
}

}  // namespace axiscal::nc
