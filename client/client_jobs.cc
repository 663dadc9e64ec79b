// Jobs, calibrations and tables of the client.
#include "client/client_impl.h"
#include "proto/convert/time.h"

namespace axiscal::client {
namespace {

// How much longer than the wait that was asked for the call may take.
constexpr std::chrono::milliseconds kWaitMargin = std::chrono::seconds(5);

}  // namespace

absl::StatusOr<JobRecord> Client::CreateJob(const records::JobParams& params, const std::string& request_id,
                                            const JobUrgency& urgency) {
  v1::CreateJobRequest request;
  request.set_request_id(request_id.empty() ? NewRequestId() : request_id);
  *request.mutable_params() = convert::ToProto(params);
  request.set_priority(urgency.priority);
  SET_OPTIONAL_UTC(request, deadline_utc_us, urgency.deadline);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::CreateJobResponse>(*impl_->jobs, &v1::Jobs::Stub::CreateJob, request));
  return convert::FromProto(response.job());
}

absl::StatusOr<JobRecord> Client::GetJob(JobId id) {
  v1::GetJobRequest request;
  request.set_job_id(id.number());
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::GetJobResponse>(*impl_->jobs, &v1::Jobs::Stub::GetJob, request));
  return convert::FromProto(response.job());
}

absl::StatusOr<JobRecord> Client::CancelJob(JobId id) {
  v1::CancelJobRequest request;
  request.set_job_id(id.number());
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::CancelJobResponse>(*impl_->jobs, &v1::Jobs::Stub::CancelJob, request));
  return convert::FromProto(response.job());
}

absl::StatusOr<JobRecord> Client::RequeueJob(JobId id) {
  v1::RequeueJobRequest request;
  request.set_job_id(id.number());
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::RequeueJobResponse>(*impl_->jobs, &v1::Jobs::Stub::RequeueJob, request));
  return convert::FromProto(response.job());
}

absl::StatusOr<Page<JobRecord>> Client::ListJobs(const JobFilter& filter, const PageRequest& page) {
  auto request = PageOf<v1::ListJobsRequest>(page);
  if (filter.machine) request.set_machine_id(filter.machine->text());
  if (filter.state) request.set_state(convert::ToProto(*filter.state));
  SET_OPTIONAL_UTC(request, from_utc_us, filter.created.from);
  SET_OPTIONAL_UTC(request, to_utc_us, filter.created.to);
  request.set_kind(filter.kind);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ListJobsResponse>(*impl_->jobs, &v1::Jobs::Stub::ListJobs, request));
  return ReadPage<JobRecord>(response.jobs(), response.next_page_token());
}

absl::StatusOr<records::MadeTable> Client::MakeTable(const records::TableParams& params) {
  const v1::MakeTableRequest request = convert::ToProto(params);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::MakeTableResponse>(*impl_->tables, &v1::Tables::Stub::MakeTable, request));
  return convert::FromProto(response);
}

absl::StatusOr<std::vector<records::TableFormat>> Client::ListTableFormats() {
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ListTableFormatsResponse>(*impl_->tables, &v1::Tables::Stub::ListTableFormats,
                                                             v1::ListTableFormatsRequest()));
  std::vector<records::TableFormat> formats;
  for (const v1::TableFormat& message : response.formats()) {
    ASSIGN_OR_RETURN(records::TableFormat format, convert::FromProto(message));
    formats.push_back(std::move(format));
  }
  return formats;
}

absl::StatusOr<JobRecord> Client::WaitJob(JobId id, std::chrono::milliseconds timeout) {
  v1::WaitJobRequest request;
  request.set_job_id(id.number());
  // 0 would wait for ever.
  request.set_timeout_ms(std::max<int64_t>(1, timeout.count()));
  v1::WaitJobResponse response;
  RETURN_IF_ERROR(impl_->connection.Call(
      [&](grpc::ClientContext* context) { return impl_->jobs->WaitJob(context, request, &response); },
      timeout + std::max(kWaitMargin, impl_->connection.options().call_deadline)));
  return convert::FromProto(response.job());
}

absl::StatusOr<JobRecord> Client::WatchJob(JobId id, const std::function<bool(const JobRecord&)>& on_change) {
  const Connection& connection = impl_->connection;
  v1::WatchJobRequest request;
  request.set_job_id(id.number());
  Backoff backoff(connection.options());
  base::SteadyTime give_up = base::SystemClock().SteadyNow() + connection.options().give_up_after;
  while (true) {
    const auto context = connection.NewStreamContext();
    const auto reader = impl_->jobs->WatchJob(context.get(), request);
    v1::WatchJobResponse message;
    absl::StatusOr<JobRecord> job = absl::UnavailableError("the watch ended without a job");
    bool goes_on = true;
    while (goes_on && reader->Read(&message)) {
      job = convert::FromProto(message.job());
      goes_on = job.ok() && (!on_change || on_change(*job));
      give_up = base::SystemClock().SteadyNow() + connection.options().give_up_after;
    }
    if (!goes_on) context->TryCancel();
    const absl::Status status = connection.FromGrpc(reader->Finish());
    if (!goes_on || (job.ok() && records::IsTerminal(job->state))) return job;
    if (!status.ok() && !IsBroken(status)) return status;
    if (!backoff.Wait(give_up)) return status.ok() ? job.status() : status;
  }
}

absl::StatusOr<Page<CalibrationRecord>> Client::ListCalibrations(const CalibrationFilter& filter,
                                                                 const PageRequest& page) {
  auto request = PageOf<v1::ListCalibrationsRequest>(page);
  if (filter.machine) request.set_machine_id(filter.machine->text());
  if (filter.state) request.set_state(convert::ToProto(*filter.state));
  SET_OPTIONAL_UTC(request, from_utc_us, filter.measured.from);
  SET_OPTIONAL_UTC(request, to_utc_us, filter.measured.to);
  if (filter.session) request.set_session_id(filter.session->number());
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::ListCalibrationsResponse>(
                                            *impl_->calibrations, &v1::Calibrations::Stub::ListCalibrations, request));
  return ReadPage<CalibrationRecord>(response.calibrations(), response.next_page_token());
}

absl::StatusOr<CalibrationRecord> Client::GetCalibration(CalibrationId id) {
  v1::GetCalibrationRequest request;
  request.set_calibration_id(id.number());
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::GetCalibrationResponse>(
                                            *impl_->calibrations, &v1::Calibrations::Stub::GetCalibration, request));
  return convert::FromProto(response.calibration());
}

absl::StatusOr<CalibrationRecord> Client::GetApprovedCalibration(const MachineId& machine) {
  v1::GetCalibrationRequest request;
  request.set_approved_of_machine_id(machine.text());
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::GetCalibrationResponse>(
                                            *impl_->calibrations, &v1::Calibrations::Stub::GetCalibration, request));
  return convert::FromProto(response.calibration());
}

absl::StatusOr<CalibrationRecord> Client::ApproveCalibration(CalibrationId id, int64_t etag,
                                                             const std::string& reason) {
  v1::ApproveCalibrationRequest request;
  request.set_calibration_id(id.number());
  request.set_etag(etag);
  request.set_reason(reason);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ApproveCalibrationResponse>(*impl_->calibrations,
                                                               &v1::Calibrations::Stub::ApproveCalibration, request));
  return convert::FromProto(response.calibration());
}

absl::StatusOr<CalibrationRecord> Client::RetireCalibration(CalibrationId id, int64_t etag, const std::string& reason) {
  v1::RetireCalibrationRequest request;
  request.set_calibration_id(id.number());
  request.set_etag(etag);
  request.set_reason(reason);
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::RetireCalibrationResponse>(
                                            *impl_->calibrations, &v1::Calibrations::Stub::RetireCalibration, request));
  return convert::FromProto(response.calibration());
}

}  // namespace axiscal::client
