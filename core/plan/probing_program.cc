#include "core/plan/probing_program.h"

#include <Eigen/Geometry>
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
                                                     {"retract_mm", options.retract_mm},
                                                     {"feed_mm_min", options.feed_mm_min}};
  for (const auto& [name, value] : positive) {
    if (value > 0.0 && value <= 5000.0) continue;
    return absl::InvalidArgumentError(absl::StrFormat("%s = %g, expected above 0 to 5000", name, value));
  }
  return absl::OkStatus();
}

class Writer {
 public:
  Writer(const machine::Machine& machine, const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& ball_mm)
      : machine_(machine), tip_mm_(tip_mm), ball_mm_(ball_mm) {
    std::string prints;
    int number = 5001;
    for (const machine::Axis& axis : machine.axes) {
      // Variables count the linear axes first.
      if (axis.kind == machine::AxisKind::kLinear)
        absl::StrAppend(&prints, prints.empty() ? "" : "*", axis.name, "#", number++, "[4 4]");
    }
    for (const machine::Axis& axis : machine.axes) {
      if (axis.kind == machine::AxisKind::kRotary) absl::StrAppend(&prints, "*", axis.name, "#", number++, "[4 4]");
    }
    print_ = "DPRNT[" + prints + "]\n";
  }

  // A block to where the stylus centre stands `offset_mm` (bed) from the sphere's centre.
  absl::Status Block(const std::string& code, const std::vector<double>& rotary, const Eigen::Vector3d& offset_mm,
                     const std::string& feed) {
    const auto pose = machine::EvaluateChain<double>(machine_, rotary.data(), {});
    std::vector<double> commands = rotary;
    const Eigen::Vector3d target_mm = ball_mm_ + pose.bed_from_table.rotation.transpose() * offset_mm;
    RETURN_IF_ERROR(centres::SolveNominalCommands(machine_, tip_mm_, target_mm, commands.data()));
    text_ += code;
    for (int i = 0; i < machine_.axis_count(); ++i) {
      const machine::Axis& axis = machine_.axes[i];
      const bool is_rotary = axis.kind == machine::AxisKind::kRotary;
      constexpr double kTolerance = 1e-6;
      if ((axis.min_position && commands[i] < *axis.min_position - kTolerance) ||
          (axis.max_position && commands[i] > *axis.max_position + kTolerance)) {
        return absl::FailedPreconditionError("a touch lies beyond the travel of " + axis.name);
      }
      const double rounded = std::round(commands[i] * (is_rotary ? base::kDegPerRad : 1.0) * 1e4) / 1e4 + 0.0;
      text_ += absl::StrFormat(" %s%.4f", axis.name, rounded);
    }
    text_ += feed + "\n";
    return absl::OkStatus();
  }
  void Print() { text_ += print_; }
  std::string Take() { return std::move(text_); }

 private:
  const machine::Machine& machine_;
  const Eigen::Vector3d tip_mm_, ball_mm_;
  std::string print_, text_;
};

}  // namespace

absl::StatusOr<std::string> ProbingBlocks(const machine::Machine& machine, const session::Session& session,
                                          const ProbingOptions& options) {
  RETURN_IF_ERROR(Validate(options));
  ASSIGN_OR_RETURN(const Eigen::Vector3d tip_mm, PointOf(session, "tool_tip_mm"));
  ASSIGN_OR_RETURN(const Eigen::Vector3d ball_mm, PointOf(session, "table_ball_mm"));
  // The way between two places 60 degrees apart passes the sphere at 0.87 of the distance.
  const double contact_mm = options.sphere_radius_mm + options.stylus_radius_mm;
  const double start_mm = contact_mm / std::cos(30.0 * base::kRadPerDeg) + options.clearance_mm;
  Writer writer(machine, tip_mm, ball_mm);
  const std::string feed = absl::StrFormat(" F%.4f", options.feed_mm_min);
  for (size_t row = 0; row < session.reading_count(); ++row) {
    std::vector<double> rotary(machine.axis_count(), 0.0);
    for (int i = 0; i < machine.axis_count(); ++i) {
      if (machine.axes[i].kind != machine::AxisKind::kRotary) continue;
      const session::Column* const column = session::FindColumn(session, machine.axes[i].name + "_deg");
      if (column == nullptr)
        return absl::InvalidArgumentError("the session has no column " + machine.axes[i].name + "_deg");
      rotary[i] = column->values[row] * base::kRadPerDeg;
    }
    const auto pose = machine::EvaluateChain<double>(machine, rotary.data(), {});
    const Eigen::Vector3d towards_spindle = -(pose.bed_from_tool.rotation * machine.tool_direction);
    const Eigen::Vector3d across = towards_spindle.unitOrthogonal();
    const Eigen::Vector3d far_mm = (start_mm + options.retract_mm) * towards_spindle;
    const Eigen::Vector3d pole_mm = start_mm * towards_spindle;
    RETURN_IF_ERROR(writer.Block("G00", rotary, far_mm, ""));
    RETURN_IF_ERROR(writer.Block("G00", rotary, pole_mm, ""));
    for (int touch = 0; touch < 5; ++touch) {
      Eigen::Vector3d from_mm = pole_mm;
      if (touch > 0) {
        const Eigen::Vector3d side = Eigen::AngleAxisd(90.0 * touch * base::kRadPerDeg, towards_spindle) * across;
        from_mm = start_mm * (0.5 * towards_spindle + std::sqrt(0.75) * side);
        RETURN_IF_ERROR(writer.Block("G00", rotary, from_mm, ""));
      }
      RETURN_IF_ERROR(writer.Block("G31", rotary, Eigen::Vector3d::Zero(), feed));
      writer.Print();
      RETURN_IF_ERROR(writer.Block("G00", rotary, from_mm, ""));
      if (touch > 0) RETURN_IF_ERROR(writer.Block("G00", rotary, pole_mm, ""));
    }
    RETURN_IF_ERROR(writer.Block("G00", rotary, far_mm, ""));
  }
  return writer.Take();
}

}  // namespace axiscal::plan
