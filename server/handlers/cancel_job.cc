#include "server/handlers/cancel_job.h"

#include "proto/convert/job.h"

namespace axiscal::handlers {

absl::StatusOr<v1::CancelJobResponse> CancelJob(Core& core, const Call& call, const v1::CancelJobRequest& request) {
  ASSIGN_OR_RETURN(const records::JobRecord record, core.jobs.Cancel(JobId(request.job_id()), call.By()));
  v1::CancelJobResponse response;
  *response.mutable_job() = convert::ToProto(record);
  return response;
}

}  // namespace axiscal::handlers
