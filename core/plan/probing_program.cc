#include "core/plan/probing_program.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/instruments/centres/centres_model.h"
#include "core/machine/chain.h"
#include "core/session/text.h"

namespace axiscal::plan {
namespace {

absl::StatusOr<Eigen::Vector3d> PointOf(const session::Session& session, const std::string& key) {
  std::vector<double> numbers;
  if (!session::ParseNumbers(session::FindHeader(session, key).value_or(""), &numbers) || numbers.size() != 3)
    return absl::InvalidArgumentError(key + ": expected three numbers in mm");
  return Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
}

absl::Status Validate(const ProbingOptions& options) {
  const std::pair<const char*, double> positive[] = {{"sphere_radius_mm", options.sphere_radius_mm},
                                                     {"stylus_radius_mm", options.stylus_radius_mm},
                                                     {"clearance_mm", options.clearance_mm},
                                                     {"overtravel_mm", options.overtravel_mm},
                                                     {"retract_mm", options.retract_mm},
                                                     {"feed_mm_min", options.feed_mm_min}};
  for (const auto& [name, value] : positive) {
    if (value > 0.0 && value <= 5000.0) continue;
    return absl::InvalidArgumentError(absl::StrFormat("%s = %g, expected above 0 to 5000", name, value));
  }
  return absl::OkStatus();
}

// The rotary axes of a row, rad; linear ones 0.
absl::StatusOr<std::vector<double>> RotaryPositions(const machine::Machine& machine, const session::Session& session,
                                                    size_t row) {
  std::vector<double> rotary(machine.axis_count(), 0.0);
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (machine.axes[i].kind != machine::AxisKind::kRotary) continue;
    const session::Column* const column = session::FindColumn(session, machine.axes[i].name + "_deg");
    if (column == nullptr)
      return absl::InvalidArgumentError("the session has no column " + machine.axes[i].name + "_deg");
    rotary[i] = column->values[row] * base::kRadPerDeg;
  }
  return rotary;
}

// One line of a touch session, on the table at home.
struct PlannedTouch {
  std::vector<double> rotary;
  Eigen::Vector3d stylus_mm, approach, up;  // at contact; unit vectors: of the touch, towards the spindle
};

absl::StatusOr<std::vector<PlannedTouch>> PlannedTouches(const machine::Machine& machine,
                                                         const session::Session& session,
                                                         const Eigen::Vector3d& tip_mm) {
  const session::Column* n[3];
  const char* const names[3] = {"nx", "ny", "nz"};
  for (int i = 0; i < 3; ++i) {
    n[i] = session::FindColumn(session, names[i]);
    if (n[i] == nullptr) return absl::InvalidArgumentError(absl::StrCat("the session has no column ", names[i]));
  }
  std::vector<PlannedTouch> touches;
  for (size_t row = 0; row < session.reading_count(); ++row) {
    PlannedTouch touch;
    ASSIGN_OR_RETURN(touch.rotary, RotaryPositions(machine, session, row));
    std::vector<double> positions = touch.rotary;
    for (const int axis : centres::LinearAxes(machine)) {
      const session::Column* const column = session::FindColumn(session, machine.axes[axis].name + "_mm");
      if (column == nullptr)
        return absl::InvalidArgumentError("the session has no column " + machine.axes[axis].name + "_mm");
      positions[axis] = column->values[row];
    }
    const auto pose = machine::EvaluateChain<double>(machine, positions.data(), {});
    const Eigen::Matrix3d table_from_bed = pose.bed_from_table.rotation.transpose();
    touch.stylus_mm = pose.bed_from_table.Inverse() * (pose.bed_from_tool * tip_mm);
    touch.approach = table_from_bed * Eigen::Vector3d(n[0]->values[row], n[1]->values[row], n[2]->values[row]);
    touch.up = -(table_from_bed * (pose.bed_from_tool.rotation * machine.tool_direction));
    touches.push_back(std::move(touch));
  }
  return touches;
}

}  // namespace

absl::StatusOr<std::string> ProbingBlocks(const machine::Machine& machine, const session::Session& session,
                                          const ProbingOptions& options, const ProbeDialect& dialect) {
  RETURN_IF_ERROR(Validate(options));
  ASSIGN_OR_RETURN(const Eigen::Vector3d tip_mm, PointOf(session, "tool_tip_mm"));
  ASSIGN_OR_RETURN(const Eigen::Vector3d ball_mm, PointOf(session, "table_ball_mm"));
  // The way between two places 60 degrees apart passes the sphere at 0.87 of the distance.
  const double contact_mm = options.sphere_radius_mm + options.stylus_radius_mm;
  const double start_mm = contact_mm / std::cos(30.0 * base::kRadPerDeg) + options.clearance_mm;
  ProbeWriter writer(machine, tip_mm, dialect, options.feed_mm_min);
  for (size_t row = 0; row < session.reading_count(); ++row) {
    ASSIGN_OR_RETURN(const std::vector<double> rotary, RotaryPositions(machine, session, row));
    const auto pose = machine::EvaluateChain<double>(machine, rotary.data(), {});
    const Eigen::Vector3d towards_spindle = -(pose.bed_from_tool.rotation * machine.tool_direction);
    const Eigen::Vector3d across = towards_spindle.unitOrthogonal();
    // A place `offset_mm` (bed) from the sphere's centre, on the table at home.
    const auto place = [&](const Eigen::Vector3d& offset_mm) -> Eigen::Vector3d {
      return ball_mm + pose.bed_from_table.rotation.transpose() * offset_mm;
    };
    const Eigen::Vector3d far_mm = place((start_mm + options.retract_mm) * towards_spindle);
    const Eigen::Vector3d pole_mm = place(start_mm * towards_spindle);
    RETURN_IF_ERROR(writer.Move(rotary, far_mm));
    RETURN_IF_ERROR(writer.Move(rotary, pole_mm));
    for (int touch = 0; touch < kTouchesPerCentre; ++touch) {
      Eigen::Vector3d from_mm = pole_mm;
      if (touch > 0) {
        const Eigen::Vector3d side = Eigen::AngleAxisd(90.0 * touch * base::kRadPerDeg, towards_spindle) * across;
        from_mm = place(start_mm * (0.5 * towards_spindle + std::sqrt(0.75) * side));
        RETURN_IF_ERROR(writer.Move(rotary, from_mm));
      }
      RETURN_IF_ERROR(writer.Touch(rotary, ball_mm));
      RETURN_IF_ERROR(writer.Move(rotary, from_mm));
      if (touch > 0) RETURN_IF_ERROR(writer.Move(rotary, pole_mm));
    }
    RETURN_IF_ERROR(writer.Move(rotary, far_mm));
  }
  return writer.Take();
}

absl::StatusOr<std::string> TouchBlocks(const machine::Machine& machine, const session::Session& session,
                                        const ProbingOptions& options, const ProbeDialect& dialect) {
  RETURN_IF_ERROR(Validate(options));
  ASSIGN_OR_RETURN(const Eigen::Vector3d tip_mm, PointOf(session, "tool_tip_mm"));
  ASSIGN_OR_RETURN(const std::vector<PlannedTouch> touches, PlannedTouches(machine, session, tip_mm));
  // A ball about all places, which contains the artefact however the table turns; `centre` turns with it.
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  for (const PlannedTouch& touch : touches) centre_mm += touch.stylus_mm / static_cast<double>(touches.size());
  double reach_mm = 0.0;
  for (const PlannedTouch& touch : touches) reach_mm = std::max(reach_mm, (touch.stylus_mm - centre_mm).norm());
  const double over_mm = reach_mm + options.clearance_mm + options.retract_mm;
  ProbeWriter writer(machine, tip_mm, dialect, options.feed_mm_min);
  for (size_t k = 0; k < touches.size(); ++k) {
    const PlannedTouch& touch = touches[k];
    const Eigen::Vector3d start_mm = touch.stylus_mm - options.clearance_mm * touch.approach;
    // Up along the tool, out of the ball: the way down to where the touch begins is the way back up.
    const auto above = [&](const Eigen::Vector3d& place_mm) -> Eigen::Vector3d {
      return place_mm + (over_mm - (place_mm - centre_mm).dot(touch.up)) * touch.up;
    };
    const bool is_turned = k == 0 || touches[k - 1].rotary != touch.rotary;
    if (is_turned) RETURN_IF_ERROR(writer.Move(touch.rotary, above(centre_mm)));
    RETURN_IF_ERROR(writer.Move(touch.rotary, above(start_mm)));
    RETURN_IF_ERROR(writer.Move(touch.rotary, start_mm));
    RETURN_IF_ERROR(writer.Touch(touch.rotary, touch.stylus_mm + options.overtravel_mm * touch.approach));
    RETURN_IF_ERROR(writer.Move(touch.rotary, start_mm));
    RETURN_IF_ERROR(writer.Move(touch.rotary, above(start_mm)));
    const bool will_turn = k + 1 == touches.size() || touches[k + 1].rotary != touch.rotary;
    if (will_turn) RETURN_IF_ERROR(writer.Move(touch.rotary, above(centre_mm)));
  }
  return writer.Take();
}

}  // namespace axiscal::plan
