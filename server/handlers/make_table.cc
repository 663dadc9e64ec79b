#include "server/handlers/make_table.h"

#include <algorithm>
#include <cmath>

#include "core/base/error_detail.h"
#include "core/base/units.h"
#include "core/machine/error_json.h"
#include "proto/convert/table.h"
#include "server/inputs/calibration_use.h"
#include "server/inputs/job_inputs.h"

namespace axiscal::handlers {
namespace {

// Below what clients take as one message.
constexpr size_t kMaxAnswerBytes = 3'500'000;

// Axes without a range get the range that the calibration's sessions covered: beyond it nothing is known.
absl::Status AddMeasuredRanges(storage::Database& database, const records::CalibrationRecord& calibration,
                               const machine::Machine& machine, const Call& call, tables::TableRequest* request) {
  std::vector<tables::AxisRange> wanted;
  for (const machine::Axis& axis : machine.axes) {
    const bool is_named = std::any_of(request->ranges.begin(), request->ranges.end(),
                                      [&](const tables::AxisRange& range) { return range.axis == axis.name; });
    if (!is_named && !(axis.min_position && axis.max_position))
      wanted.push_back({axis.name, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()});
  }
  if (wanted.empty()) return absl::OkStatus();
  for (const SessionId& id : calibration.content.sessions) {
    if (call.is_cancelled()) return absl::CancelledError("stopped");
    ASSIGN_OR_RETURN(const session::Session session, database.ReadSession(id));
    for (tables::AxisRange& range : wanted) {
      const bool is_rotary = machine.axes[machine::FindAxis(machine, range.axis)].kind == machine::AxisKind::kRotary;
      const session::Column* column = session::FindColumn(session, range.axis + (is_rotary ? "_deg" : "_mm"));
      if (column == nullptr) continue;
      for (const double value : column->values) {
        const double position = is_rotary ? value * base::kRadPerDeg : value;
        range.min = std::min(range.min, position);
        range.max = std::max(range.max, position);
      }
    }
  }
  constexpr double kMoved = 0.01;  // mm or rad: an axis that stood still has no range
  std::string names;
  for (const tables::AxisRange& range : wanted) {
    if (!(range.max - range.min > kMoved)) continue;
    request->ranges.push_back(range);
    absl::StrAppend(&names, names.empty() ? "" : ", ", range.axis);
  }
  if (!names.empty())
    request->notes.push_back("ranges that nobody stated are what the calibration's sessions covered: " + names);
  return absl::OkStatus();
}

// The engine's refusals with a reason.
absl::Status WithReason(const absl::Status& status) {
  if (absl::IsInvalidArgument(status))
    return base::Error(status.code(), std::string(status.message()), {"TABLE_INVALID", {}});
  if (absl::IsFailedPrecondition(status))
    return base::Error(status.code(), std::string(status.message()), {"TABLE_NOT_POSSIBLE", {}});
  return status;
}

}  // namespace

absl::StatusOr<v1::MakeTableResponse> MakeTable(Core& core, const Call& call, const v1::MakeTableRequest& message) {
  RETURN_IF_ERROR(RequireAccepting(core));
  ASSIGN_OR_RETURN(records::TableParams params, convert::FromProto(message));
  ASSIGN_OR_RETURN(const records::MachineRecord record, core.database.GetMachine(params.machine));
  if (record.deleted_at)
    return base::Error(absl::StatusCode::kFailedPrecondition, "machine " + record.id.text() + " is deleted",
                       {"MACHINE_DELETED", {}});
  ASSIGN_OR_RETURN(const records::CalibrationRecord calibration,
                   inputs::CalibrationFor(core.database, params.machine, params.calibration, "calibration_id"));
  ASSIGN_OR_RETURN(const machine::Machine machine, inputs::MachineFor(core.database, calibration));
  ASSIGN_OR_RETURN(const machine::ErrorModel errors, machine::ReadErrors(calibration.content.model_json, machine));
  params.request.calibration = absl::StrCat(params.machine.text(), " v", calibration.version);
  params.request.notes = nc::TextsOf(inputs::NotesOnInseparableErrors(calibration));
  RETURN_IF_ERROR(AddMeasuredRanges(core.database, calibration, machine, call, &params.request));
  const absl::StatusOr<tables::MadeTable> made = tables::MakeTable(machine, errors, params.request);
  if (!made.ok()) return WithReason(made.status());
  if (made->text.size() + made->report_json.size() > kMaxAnswerBytes) {
    return WithReason(absl::FailedPreconditionError(
        absl::StrCat("the table has ", made->text.size(), " bytes, at most ", kMaxAnswerBytes,
                     " can be handed out: allow a larger tolerance or fewer points")));
  }
  RETURN_IF_ERROR(core.database.NoteHandedTable(calibration.id, params.request.format, call.By()));
  return convert::ToProto(records::MadeTable{*made, calibration.id});
}

}  // namespace axiscal::handlers
