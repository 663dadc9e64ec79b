// X (or Y) and C move together so that the bar keeps its length over one turn of C (Jiang, Yao, Liu 2019, with 24 and
// 26 put right): the table ball stands at radius R from C, the spindle ball moves along X at the same height,
//   spindle ball at |(R_e cos u + R, R_e sin u)| from C, C at atan2(R_e sin u, R_e cos u + R)
// Equal steps of u are equal steps of the spindle ball's circle about the table ball, so that the path speed is
// constant.
#include <cmath>
#include <numbers>

#include "core/base/units.h"
#include "core/plan/session_builder.h"
#include "core/plan/tests_internal.h"

namespace axiscal::plan {
namespace {

using machine::Machine;

// A rotary axis of the table that turns about z, or -1.
int TableAxis(const Machine& machine) {
  for (const int axis : machine.work_branch) {
    const machine::Axis& a = machine.axes[axis];
    if (a.kind == machine::AxisKind::kRotary && std::abs(std::abs(a.direction.z()) - 1.0) < 1e-6) return axis;
  }
  return -1;
}

}  // namespace

std::vector<PlannedSession> BallbarLinked(const Situation& situation) {
  const Machine& machine = *situation.machine;
  const int table = TableAxis(machine);
  constexpr double kTurn = 2.0 * std::numbers::pi;
  if (table < 0 || situation.ranges[table].highest - situation.ranges[table].lowest < kTurn - 1e-6) return {};
  constexpr double kRadiusShare = 2.0 / 3.0;  // of the bar: 100 mm of 150, as published
  constexpr double kHigherMm = 150.0;         // the second height tells the offsets of C from its tilts
  constexpr double kUsualHeightMm = 100.0;
  constexpr int kReadings = 360;
  const double bar_mm = situation.bars_mm.back(), radius_mm = kRadiusShare * bar_mm;
  const Eigen::Vector3d center_mm = machine.axes[table].point_mm;
  const double given_mm = situation.balls_mm.front().z();
  const double height_mm = given_mm > center_mm.z() + 1.0 ? given_mm : center_mm.z() + kUsualHeightMm;
  std::vector<PlannedSession> planned;
  for (int direction = 0; direction < 2; ++direction) {
    for (const double higher_mm : {0.0, kHigherMm}) {
      const Eigen::Vector3d along = Eigen::Vector3d::Unit(direction);
      Eigen::Vector3d ball_mm = center_mm + radius_mm * along;
      ball_mm.z() = height_mm + higher_mm;
      const char letter = "XY"[direction];
      const std::string name = absl::StrFormat("%c%s-linked-%.0f", letter, machine.axes[table].name, ball_mm.z());
      SessionBuilder builder(situation, name, situation.tips_mm.front(), ball_mm, bar_mm);
      for (int k = 0; k <= 2 * kReadings; ++k) {
        const double u = kTurn / kReadings * (k <= kReadings ? k : 2 * kReadings - k);
        // atan2 jumps at half a turn, where the axis goes on.
        double turned = std::atan2(bar_mm * std::sin(u), bar_mm * std::cos(u) + radius_mm);
        if (turned < -1e-12) turned += kTurn;
        if (u > kTurn - 1e-9) turned = kTurn;
        const double out_mm = std::hypot(bar_mm * std::sin(u), bar_mm * std::cos(u) + radius_mm);
        std::vector<double> positions(machine.axis_count(), 0.0);
        positions[table] = situation.ranges[table].lowest + turned;
        const double start = situation.ranges[table].lowest;
        // The ball's place in the bed as the table turns, from the direction it has at the start of the range.
        const double angle = (start + turned) * machine.axes[table].direction.z();
        const double c = std::cos(angle), s = std::sin(angle);
        const Eigen::Vector3d arm_mm = radius_mm * along;
        const Eigen::Vector3d ball_now_mm(c * arm_mm.x() - s * arm_mm.y(), s * arm_mm.x() + c * arm_mm.y(), 0.0);
        const double c0 = std::cos(start * machine.axes[table].direction.z());
        const double s0 = std::sin(start * machine.axes[table].direction.z());
        const Eigen::Vector3d line(c0 * along.x() - s0 * along.y(), s0 * along.x() + c0 * along.y(), 0.0);
        builder.AddInBed(positions, out_mm * line - ball_now_mm);
      }
      if (!builder.is_possible()) continue;
      planned.push_back(
          {builder.Finish(),
           absl::StrFormat("%c and %s together keep a bar of %.0f mm, one turn there and back, ball %.0f mm "
                           "from %s at height %.0f mm",
                           letter, machine.axes[table].name, bar_mm, radius_mm, machine.axes[table].name,
                           ball_mm.z())});
    }
  }
  return planned;
}

}  // namespace axiscal::plan
