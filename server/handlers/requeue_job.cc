#include "server/handlers/requeue_job.h"

#include "proto/convert/job.h"

namespace axiscal::handlers {

absl::StatusOr<v1::RequeueJobResponse> RequeueJob(Core& core, const Call& call, const v1::RequeueJobRequest& request) {
  ASSIGN_OR_RETURN(const records::JobRecord record, core.jobs.Requeue(JobId(request.job_id()), call.By()));
  v1::RequeueJobResponse response;
  *response.mutable_job() = convert::ToProto(record);
  return response;
}

}  // namespace axiscal::handlers
