#include "server/handlers/create_job.h"

#include "proto/convert/field.h"
#include "proto/convert/job.h"
#include "server/inputs/job_inputs.h"

namespace axiscal::handlers {
namespace {

constexpr int kMostPriority = 10;

}  // namespace

absl::StatusOr<v1::CreateJobResponse> CreateJob(Core& core, const Call& call, const v1::CreateJobRequest& request) {
  RETURN_IF_ERROR(RequireAccepting(core));
  RETURN_IF_ERROR(RequireRequestId(request.request_id()));
  absl::StatusOr<records::JobParams> params = convert::FromProto(request.params());
  if (!params.ok()) return convert::InField("params", params.status());
  RETURN_IF_ERROR(inputs::CheckInputs(core.database, *params));
  if (request.priority() < -kMostPriority || request.priority() > kMostPriority) {
    return convert::FieldError("priority",
                               absl::StrCat(request.priority(), ", must be ", -kMostPriority, " to ", kMostPriority));
  }
  storage::NewJob job;
  job.priority = request.priority();
  if (request.has_deadline_utc_us()) {
    RETURN_IF_ERROR(convert::RequirePositive("deadline_utc_us", request.deadline_utc_us()));
    job.deadline = base::FromUtcUs(request.deadline_utc_us());
  }
  job.kind = records::KindOf(*params);
  job.machine = records::MachineOf(*params);
  if (const auto* compensate = std::get_if<records::CompensateParams>(&*params)) job.program = compensate->program;
  job.params = convert::Serialize(*params);
  job.caller = call.By(request.request_id());
  job.trace = call.trace;
  ASSIGN_OR_RETURN(const records::JobRecord record, core.jobs.Create(job));
  v1::CreateJobResponse response;
  *response.mutable_job() = convert::ToProto(record);
  return response;
}

}  // namespace axiscal::handlers
