#include "proto/convert/job.h"

#include "proto/convert/field.h"
#include "proto/convert/time.h"

namespace axiscal::convert {
namespace {

v1::JobResult ResultToProto(const records::JobRecord& record) {
  v1::JobResult message;
  if (record.calibration) message.set_calibration_id(record.calibration->number());
  for (const ProgramId& id : record.programs) message.add_program_ids(id.number());
  message.set_report_json(record.result);
  return message;
}

std::string KindOf(const v1::JobParams& params) {
  if (params.has_identify()) return records::kIdentify;
  if (params.has_close_loop()) return records::kCloseLoop;
  if (params.has_tool_setter()) return records::kToolSetter;
  return params.has_compensate() ? records::kCompensate : "";
}

std::optional<MachineId> MachineOf(const v1::JobParams& params) {
  if (params.has_identify()) return MachineId(params.identify().machine_id());
  if (params.has_close_loop()) return MachineId(params.close_loop().machine_id());
  if (params.has_tool_setter()) return MachineId(params.tool_setter().machine_id());
  if (params.has_compensate()) return MachineId(params.compensate().machine_id());
  return std::nullopt;
}

}  // namespace

v1::JobState ToProto(records::JobState state) {
  switch (state) {
    case records::JobState::kQueued:
      return v1::JOB_STATE_QUEUED;
    case records::JobState::kRunning:
      return v1::JOB_STATE_RUNNING;
    case records::JobState::kSucceeded:
      return v1::JOB_STATE_SUCCEEDED;
    case records::JobState::kFailed:
      return v1::JOB_STATE_FAILED;
    case records::JobState::kCancelled:
      return v1::JOB_STATE_CANCELLED;
    case records::JobState::kDead:
      return v1::JOB_STATE_DEAD;
  }
  return v1::JOB_STATE_UNSPECIFIED;
}

absl::StatusOr<records::JobState> FromProto(v1::JobState state) {
  switch (state) {
    case v1::JOB_STATE_QUEUED:
      return records::JobState::kQueued;
    case v1::JOB_STATE_RUNNING:
      return records::JobState::kRunning;
    case v1::JOB_STATE_SUCCEEDED:
      return records::JobState::kSucceeded;
    case v1::JOB_STATE_FAILED:
      return records::JobState::kFailed;
    case v1::JOB_STATE_CANCELLED:
      return records::JobState::kCancelled;
    case v1::JOB_STATE_DEAD:
      return records::JobState::kDead;
    default:
      return FieldError("state", absl::StrCat(static_cast<int>(state), ", must be a state of jobs"));
  }
}

v1::Job ToProto(const records::JobRecord& record) {
  v1::Job message;
  message.set_job_id(record.id.number());
  // Params were checked when the job was created; a row that says otherwise shows no params.
  if (!message.mutable_params()->ParseFromString(record.params)) message.clear_params();
  message.set_state(ToProto(record.state));
  message.mutable_progress()->set_fraction(record.progress.fraction);
  message.mutable_progress()->set_stage(record.progress.stage);
  message.mutable_progress()->set_detail(record.progress.detail);
  message.set_attempt(record.attempt);
  message.set_max_attempts(record.max_attempts);
  message.set_cancel_requested(record.cancel_requested);
  if (record.state == records::JobState::kSucceeded) *message.mutable_result() = ResultToProto(record);
  if (record.error) {
    message.mutable_error()->set_code(static_cast<int>(record.error->code));
    message.mutable_error()->set_reason(record.error->reason);
    message.mutable_error()->set_message(record.error->message);
  }
  message.set_created_utc_us(base::ToUtcUs(record.created_at));
  SET_OPTIONAL_UTC(message, started_utc_us, record.started_at);
  SET_OPTIONAL_UTC(message, finished_utc_us, record.ended_at);
  message.set_created_by(record.created_by);
  message.set_version(record.version);
  message.set_priority(record.priority);
  SET_OPTIONAL_UTC(message, deadline_utc_us, record.deadline);
  message.set_trace(record.trace);
  return message;
}

absl::StatusOr<records::JobRecord> FromProto(const v1::Job& message) {
  RETURN_IF_ERROR(RequirePositive("job_id", message.job_id()));
  const v1::JobProgress& progress = message.progress();
  if (!(progress.fraction() >= 0 && progress.fraction() <= 1)) {
    return FieldError("progress.fraction", absl::StrCat(progress.fraction(), ", must be 0 to 1"));
  }
  records::JobRecord record;
  ASSIGN_OR_RETURN(record.state, FromProto(message.state()));
  record.id = JobId(message.job_id());
  record.kind = KindOf(message.params());
  record.machine = MachineOf(message.params());
  record.params = message.params().SerializeAsString();
  record.attempt = message.attempt();
  record.max_attempts = message.max_attempts();
  record.cancel_requested = message.cancel_requested();
  record.progress = {progress.stage(), progress.fraction(), progress.detail()};
  if (message.has_result()) {
    const v1::JobResult& result = message.result();
    record.result = result.report_json();
    if (result.has_calibration_id()) record.calibration = CalibrationId(result.calibration_id());
    for (const int64_t id : result.program_ids()) record.programs.push_back(ProgramId(id));
  }
  if (message.has_error()) {
    const v1::JobError& error = message.error();
    record.error = {static_cast<absl::StatusCode>(error.code()), error.reason(), error.message()};
  }
  record.created_by = message.created_by();
  record.created_at = base::FromUtcUs(message.created_utc_us());
  record.started_at = OPTIONAL_UTC(message, started_utc_us);
  record.ended_at = OPTIONAL_UTC(message, finished_utc_us);
  record.version = message.version();
  record.priority = message.priority();
  record.deadline = OPTIONAL_UTC(message, deadline_utc_us);
  record.trace = message.trace();
  return record;
}

}  // namespace axiscal::convert
