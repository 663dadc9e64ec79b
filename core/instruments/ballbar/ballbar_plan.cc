#include "core/instruments/ballbar/ballbar_plan.h"

#include <cmath>

#include "core/base/units.h"

namespace axiscal::ballbar {
namespace {

// Pivot position (x, y, z) at the angle p of B or q of C, the origin on C's line.
Eigen::Vector3d Command(Pattern pattern, double angle_rad, const PatternOptions& o) {
  const double s = std::sin(angle_rad), c = std::cos(angle_rad);
  const double length = o.bar_length_mm, rb = o.tool_length_mm, zc = o.ball_height_mm, rc = o.ball_radius_mm;
  switch (pattern) {
    case Pattern::kBX:
      return {length + rb * s, 0, zc + rb * c};
    case Pattern::kBY:
    case Pattern::kBAxial:
      return {rb * s, length, zc + rb * c};
    case Pattern::kBZ:
      return {rb * s, 0, length + zc + rb * c};
    case Pattern::kBRadial:
      return {(length + rb) * s, 0, zc + (length + rb) * c};
    case Pattern::kBTangential: {
      const double radius = std::hypot(rb, length), lead = std::atan2(length, rb);
      return {radius * std::sin(angle_rad + lead), 0, zc + radius * std::cos(angle_rad + lead)};
    }
    case Pattern::kCR:
      return {(rc - length) * c, (rc - length) * s, zc + rb};
    case Pattern::kCT: {
      const double radius = std::hypot(rc, length), lead = std::atan2(length, rc);
      return {radius * std::cos(angle_rad + lead), radius * std::sin(angle_rad + lead), zc + rb};
    }
    case Pattern::kCA:
    case Pattern::kCZ:
      return {rc * c, rc * s, zc + length + rb};
    case Pattern::kCX:
      return {length + rc * c, rc * s, zc + rb};
    case Pattern::kCY:
      return {rc * c, length + rc * s, zc + rb};
  }
  return Eigen::Vector3d::Constant(NAN);
}

std::string Number(double number) { return absl::StrFormat("%.10g", number); }
std::string Point(const Eigen::Vector3d& point_mm) {
  return absl::StrCat(Number(point_mm.x()), " ", Number(point_mm.y()), " ", Number(point_mm.z()));
}

absl::Status Validate(const PatternOptions& options) {
  const std::pair<const char*, double> positive[] = {{"bar_length_mm", options.bar_length_mm},
                                                     {"tool_length_mm", options.tool_length_mm},
                                                     {"ball_radius_mm", options.ball_radius_mm},
                                                     {"step_deg", options.step_deg},
                                                     {"sigma_um", options.sigma_um},
                                                     {"seconds_per_reading", options.seconds_per_reading}};
  for (const auto& [name, value] : positive) {
    if (!(value > 0.0) || !std::isfinite(value))
      return absl::InvalidArgumentError(absl::StrCat(name, " = ", value, ", must be > 0"));
  }
  return absl::OkStatus();
}

}  // namespace

const std::vector<std::pair<std::string, Pattern>>& Patterns() {
  static const auto& patterns =
      *new std::vector<std::pair<std::string, Pattern>>{{"BX", Pattern::kBX},
                                                        {"BY", Pattern::kBY},
                                                        {"BZ", Pattern::kBZ},
                                                        {"B-axial", Pattern::kBAxial},
                                                        {"B-radial", Pattern::kBRadial},
                                                        {"B-tangential", Pattern::kBTangential},
                                                        {"CR", Pattern::kCR},
                                                        {"CT", Pattern::kCT},
                                                        {"CA", Pattern::kCA},
                                                        {"CX", Pattern::kCX},
                                                        {"CY", Pattern::kCY},
                                                        {"CZ", Pattern::kCZ}};
  return patterns;
}

absl::StatusOr<session::Session> PlanPattern(const machine::Machine& machine, const std::string& name, Pattern pattern,
                                             const PatternOptions& options) {
  RETURN_IF_ERROR(Validate(options));
  for (const char* axis : {"X", "Y", "Z", "B", "C"}) {
    if (machine::FindAxis(machine, axis) < 0) {
      return absl::FailedPreconditionError(
          absl::StrCat("machine '", machine.id, "' has no axis ", axis, ", which pattern ", name, " moves"));
    }
  }
  const bool turns_b = TurnsB(pattern);
  const Eigen::Vector3d pivot_home_mm = machine.axes[machine::FindAxis(machine, "B")].point_mm;
  Eigen::Vector3d line_mm = machine.axes[machine::FindAxis(machine, "C")].point_mm;
  line_mm.z() = 0.0;
  const Eigen::Vector3d ball_mm(turns_b ? 0.0 : options.ball_radius_mm, 0.0, options.ball_height_mm);
  session::Session session;
  session.header = {{"machine", machine.id},
                    {"session", name},
                    {"instrument", "ballbar"},
                    {"sigma_um", Number(options.sigma_um)},
                    {"tool_tip_mm", Point(pivot_home_mm - options.tool_length_mm * Eigen::Vector3d::UnitZ())},
                    {"table_ball_mm", Point(line_mm + ball_mm)},
                    {"bar_length_mm", Number(options.bar_length_mm)}};
  for (const char* column : {"t_s", "X_mm", "Y_mm", "Z_mm", "B_deg", "C_deg"})
    session.columns.push_back({column, {}, {}});
  const int steps = static_cast<int>(std::lround((turns_b ? 90.0 : 360.0) / options.step_deg));
  const int readings = options.both_senses ? 2 * steps + 1 : steps + 1;
  for (int k = 0; k < readings; ++k) {
    const double angle_deg = options.step_deg * (k <= steps ? k : 2 * steps - k);
    const Eigen::Vector3d pivot_mm = line_mm + Command(pattern, angle_deg * base::kRadPerDeg, options) - pivot_home_mm;
    const double row[] = {options.start_s + k * options.seconds_per_reading,
                          pivot_mm.x(),
                          pivot_mm.y(),
                          pivot_mm.z(),
                          turns_b ? angle_deg : 0.0,
                          turns_b ? 0.0 : angle_deg};
    for (size_t i = 0; i < session.columns.size(); ++i) session.columns[i].values.push_back(row[i]);
  }
  return session;
}

}  // namespace axiscal::ballbar
