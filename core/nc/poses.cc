#include "core/nc/poses.h"

#include "core/base/units.h"

namespace axiscal::nc {

compensate::AxisValues AxisValuesOf(const machine::Machine& machine, const Positions& positions) {
  compensate::AxisValues values{};
  for (int i = 0; i < machine.axis_count(); ++i) {
    const bool is_rotary = machine.axes[i].kind == machine::AxisKind::kRotary;
    values[i] = static_cast<double>(positions.ticks[i]) / kTicksPerUnit * (is_rotary ? base::kRadPerDeg : 1.0);
  }
  return values;
}

absl::StatusOr<std::vector<ProgramPose>> ReadPoses(const ByteReader& reader, const machine::Machine& machine,
                                                   const RewriteOptions& options, size_t most) {
  RETURN_IF_ERROR(machine::Validate(machine));
  RETURN_IF_ERROR(Validate(options));
  ASSIGN_OR_RETURN(Interpreter interpreter, Interpreter::Create(machine, options));
  MoveReader moves(reader, std::move(interpreter));
  std::vector<ProgramPose> poses;
  for (Event event;;) {
    ASSIGN_OR_RETURN(const bool has_event, moves.Next(&event));
    if (!has_event) break;
    if (event.step.kind == StepKind::kNone) continue;
    const std::string line = absl::StrCat("line ", event.line, ": ");
    if (event.step.kind != StepKind::kMove || event.step.is_arc || event.step.is_tool_point) {
      return absl::InvalidArgumentError(absl::StrCat(line, "expected linear moves in axis positions only",
                                                     event.step.reason.empty() ? "" : " (" + event.step.reason + ")"));
    }
    for (int i = 0; i < machine.axis_count(); ++i) {
      if (event.step.end.is_known(i)) continue;
      return absl::InvalidArgumentError(absl::StrCat(line, "the position of ", machine.axes[i].name,
                                                     " is not known yet, expected it in the first move"));
    }
    if (poses.size() == most)
      return absl::InvalidArgumentError(absl::StrCat(line, "expected at most ", most, " moves"));
    ProgramPose& pose = poses.emplace_back();
    pose.line = event.line;
    pose.pose.position = AxisValuesOf(machine, event.step.end);
    for (int i = 0; i < machine.axis_count(); ++i) pose.pose.sense[i] = event.step.end.sense[i];
  }
  if (poses.empty()) return absl::InvalidArgumentError("the program moves nothing, expected linear moves");
  return poses;
}

}  // namespace axiscal::nc
