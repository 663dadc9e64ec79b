#include "server/inputs/compared.h"

#include "core/base/error_detail.h"
#include "core/identify/identify.h"
#include "core/instruments/covered.h"
#include "core/machine/error_json.h"
#include "core/reports/calibration.h"
#include "server/inputs/calibration_use.h"

namespace axiscal::inputs {
namespace {

absl::StatusOr<compare::Side> SideOf(const records::CalibrationRecord& record, const machine::Machine& machine) {
  compare::Side side;
  side.label = absl::StrCat("calibration ", record.id.number());
  ASSIGN_OR_RETURN(side.errors, machine::ReadKnownErrors(record.content.model_json, machine));
  ASSIGN_OR_RETURN(const reports::CalibrationReport report, reports::ReadCalibrationReport(record.content.report_json));
  compare::AddReport(report, &side);
  return side;
}

// Readings go by age (retention): what is left of them counts.
absl::Status CoverSessions(storage::Database& database, const machine::Machine& machine,
                           const records::CalibrationRecord& record, const std::function<bool()>& is_cancelled,
                           instruments::Covered& covered) {
  for (const SessionId id : record.content.sessions) {
    if (is_cancelled()) return base::Error(absl::StatusCode::kCancelled, "the caller has left", {"CALLER_GONE", {}});
    const absl::StatusOr<session::Session> session = database.ReadSession(id);
    if (!session.ok()) continue;
    const auto runs = identify::BindSessions(machine, {*session});
    if (runs.ok()) instruments::Cover(*runs, covered);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Compared> SidesOf(storage::Database& database, const records::CalibrationRecord& first,
                                 const records::CalibrationRecord& second, const std::function<bool()>& is_cancelled) {
  RETURN_IF_ERROR(MachineFor(database, first).status());
  Compared compared;
  ASSIGN_OR_RETURN(compared.machine, MachineFor(database, second));
  ASSIGN_OR_RETURN(compared.first, SideOf(first, compared.machine));
  ASSIGN_OR_RETURN(compared.second, SideOf(second, compared.machine));
  instruments::Covered covered;
  RETURN_IF_ERROR(CoverSessions(database, compared.machine, second, is_cancelled, covered));
  RETURN_IF_ERROR(CoverSessions(database, compared.machine, first, is_cancelled, covered));
  if (!covered.low.empty()) {
    compared.workspace.emplace();
    compared.workspace->tip_mm = *covered.tip_mm;
    compared.workspace->box = {covered.low, covered.high};
  }
  return compared;
}

}  // namespace axiscal::inputs
