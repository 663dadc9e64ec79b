#include "proto/convert/calibration.h"

#include <cmath>

#include "core/reports/calibration.h"
#include "proto/convert/field.h"
#include "proto/convert/time.h"

namespace axiscal::convert {
namespace {

v1::Provenance ProvenanceToProto(const records::CalibrationRecord& record) {
  v1::Provenance message;
  if (record.job) message.set_job_id(record.job->number());
  for (const SessionId& id : record.content.sessions) message.add_session_ids(id.number());
  message.set_machine_revision(record.content.machine_revision);
  message.set_options_json(record.content.options_json);
  message.set_engine_version(record.content.engine_version);
  message.set_created_by(record.content.created_by);
  message.set_measured_utc_us(base::ToUtcUs(record.content.measured_at));
  return message;
}

void ProvenanceFromProto(const v1::Provenance& message, records::CalibrationRecord* record) {
  if (message.job_id() != 0) record->job = JobId(message.job_id());
  for (const int64_t id : message.session_ids()) record->content.sessions.push_back(SessionId(id));
  record->content.machine_revision = message.machine_revision();
  record->content.options_json = message.options_json();
  record->content.engine_version = message.engine_version();
  record->content.created_by = message.created_by();
  record->content.measured_at = base::FromUtcUs(message.measured_utc_us());
}

v1::FitStatistics StatisticsToProto(const records::NewCalibration& content) {
  v1::FitStatistics message;
  message.set_rank(content.rank);
  if (content.condition) message.set_condition(*content.condition);
  if (content.chi2_per_dof) message.set_chi2_per_dof(*content.chi2_per_dof);
  if (content.rms_before_um) message.set_rms_before_um(*content.rms_before_um);
  if (content.rms_after_um) message.set_rms_after_um(*content.rms_after_um);
  return message;
}

void StatisticsFromProto(const v1::FitStatistics& message, records::NewCalibration* content) {
  content->rank = message.rank();
  if (message.has_condition()) content->condition = message.condition();
  if (message.has_chi2_per_dof()) content->chi2_per_dof = message.chi2_per_dof();
  if (message.has_rms_before_um()) content->rms_before_um = message.rms_before_um();
  if (message.has_rms_after_um()) content->rms_after_um = message.rms_after_um();
}

// What the report says beyond the single errors, or why that is not known; nothing where there is no report.
void AddReported(const std::string& report_json, v1::Calibration* message) {
  const absl::StatusOr<reports::CalibrationReport> report = reports::ReadCalibrationReport(report_json);
  if (!report.ok()) {
    if (!report_json.empty()) message->set_report_problem(std::string(report.status().message()));
    return;
  }
  for (const reports::Combination& combination : reports::FittedOf(*report).determined) {
    v1::Combination* const out = message->add_combinations();
    out->set_name(combination.name);
    if (std::isfinite(combination.value)) out->set_value(combination.value);
    if (std::isfinite(combination.sigma)) out->set_sigma(combination.sigma);
    out->set_unit(combination.unit);
  }
  for (const std::string& name : reports::FittedOf(*report).not_separable) message->add_not_separable(name);
}

}  // namespace

v1::Calibration ToProto(const records::CalibrationRecord& record) {
  v1::Calibration message;
  message.set_calibration_id(record.id.number());
  message.set_machine_id(record.content.machine.text());
  message.set_version(record.version);
  message.set_state(ToProto(record.state));
  message.set_etag(record.etag);
  message.set_created_utc_us(base::ToUtcUs(record.created_at));
  SET_OPTIONAL_UTC(message, approved_utc_us, record.approved_at);
  message.set_approved_by(record.approved_by);
  SET_OPTIONAL_UTC(message, retired_utc_us, record.retired_at);
  for (const SessionId& id : record.rejected_sessions) message.add_rejected_session_ids(id.number());
  *message.mutable_statistics() = StatisticsToProto(record.content);
  for (const records::Estimate& estimate : record.content.estimates) *message.add_estimates() = ToProto(estimate);
  AddReported(record.content.report_json, &message);
  *message.mutable_provenance() = ProvenanceToProto(record);
  message.set_model_json(record.content.model_json);
  message.set_report_json(record.content.report_json);
  for (const records::Decision& decision : record.decisions) {
    v1::CalibrationDecision& told = *message.add_decisions();
    told.set_at_utc_us(base::ToUtcUs(decision.at));
    told.set_principal(decision.by);
    told.set_state(ToProto(decision.became));
    told.set_reason(decision.reason);
  }
  return message;
}

absl::StatusOr<records::CalibrationRecord> FromProto(const v1::Calibration& message) {
  RETURN_IF_ERROR(RequirePositive("calibration_id", message.calibration_id()));
  RETURN_IF_ERROR(RequireText("machine_id", message.machine_id(), 1, 255));
  RETURN_IF_ERROR(RequirePositive("version", message.version()));
  RETURN_IF_ERROR(RequirePositive("etag", message.etag()));
  records::CalibrationRecord record;
  record.id = CalibrationId(message.calibration_id());
  record.version = message.version();
  ASSIGN_OR_RETURN(record.state, FromProto(message.state()));
  record.etag = message.etag();
  record.created_at = base::FromUtcUs(message.created_utc_us());
  record.approved_at = OPTIONAL_UTC(message, approved_utc_us);
  record.approved_by = message.approved_by();
  record.retired_at = OPTIONAL_UTC(message, retired_utc_us);
  for (const int64_t id : message.rejected_session_ids()) record.rejected_sessions.push_back(SessionId(id));
  for (const v1::CalibrationDecision& told : message.decisions()) {
    ASSIGN_OR_RETURN(const records::CalibrationState became, FromProto(told.state()));
    record.decisions.push_back({base::FromUtcUs(told.at_utc_us()), told.principal(), became, told.reason()});
  }
  record.content.machine = MachineId(message.machine_id());
  for (int i = 0; i < message.estimates_size(); ++i) {
    absl::StatusOr<records::Estimate> estimate = FromProto(message.estimates(i));
    if (!estimate.ok()) return InField(absl::StrCat("estimates[", i, "]"), estimate.status());
    record.content.estimates.push_back(*std::move(estimate));
  }
  StatisticsFromProto(message.statistics(), &record.content);
  ProvenanceFromProto(message.provenance(), &record);
  record.content.model_json = message.model_json();
  record.content.report_json = message.report_json();
  return record;
}

}  // namespace axiscal::convert
