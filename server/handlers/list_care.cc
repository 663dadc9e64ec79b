#include "server/handlers/list_care.h"

namespace axiscal::handlers {
namespace {

v1::Care CareOf(const storage::CareRow& row) {
  if (row.new_events > 0 || !row.findings.empty()) return v1::CARE_NOW;
  if (row.waiting > 0) return v1::CARE_DECIDE;
  return row.in_use ? v1::CARE_GOOD : v1::CARE_UNKNOWN;
}

// A machine that was removed since the list was read is in none.
absl::Status AddGroups(Core& core, v1::MachineCare& message) {
  const absl::StatusOr<storage::Belonging> belongs =
      core.database.WhereBelongs({storage::ResourceKind::kMachine, message.machine_id()}, "");
  if (absl::IsNotFound(belongs.status())) return absl::OkStatus();
  RETURN_IF_ERROR(belongs.status());
  for (const records::MachineAccess& machine : belongs->machines)
    message.mutable_groups()->Add(machine.groups.begin(), machine.groups.end());
  return absl::OkStatus();
}

v1::MachineCare CareMessage(const storage::CareRow& row) {
  v1::MachineCare message;
  message.set_machine_id(row.machine.text());
  message.set_care(CareOf(row));
  for (const storage::StandingFinding& finding : row.findings) {
    v1::StandingFinding& added = *message.add_findings();
    added.set_kind(static_cast<v1::DriftFindingKind>(finding.kind));
    added.set_text(finding.text);
    added.set_at_utc_us(base::ToUtcUs(finding.at));
  }
  message.set_new_events(row.new_events);
  message.set_newest_event(row.newest_event);
  message.set_waiting(row.waiting);
  message.set_is_followed(row.is_followed);
  if (!row.in_use) return message;
  v1::CalibrationInUse& in_use = *message.mutable_in_use();
  in_use.set_calibration_id(row.in_use->id.number());
  in_use.set_version(row.in_use->version);
  in_use.set_measured_utc_us(base::ToUtcUs(row.in_use->measured_at));
  if (row.in_use->rms_before_um) in_use.set_rms_before_um(*row.in_use->rms_before_um);
  if (row.in_use->rms_after_um) in_use.set_rms_after_um(*row.in_use->rms_after_um);
  return message;
}

}  // namespace

absl::StatusOr<v1::ListCareResponse> ListCare(Core& core, const Call& call, const v1::ListCareRequest& request) {
  ASSIGN_OR_RETURN(const records::PageRequest page, PageFrom(request.page_size(), request.page_token()));
  ASSIGN_OR_RETURN(const records::Page<storage::CareRow> rows, core.database.ListCare(page, call.visible));
  v1::ListCareResponse response;
  for (const storage::CareRow& row : rows.rows) {
    v1::MachineCare& message = *response.add_machines() = CareMessage(row);
    RETURN_IF_ERROR(AddGroups(core, message));
  }
  response.set_next_page_token(rows.next_token);
  return response;
}

}  // namespace axiscal::handlers
