#include "server/handlers/get_job.h"

#include "proto/convert/job.h"

namespace axiscal::handlers {

absl::StatusOr<v1::GetJobResponse> GetJob(Core& core, const Call& call, const v1::GetJobRequest& request) {
  ASSIGN_OR_RETURN(const records::JobRecord record, core.jobs.Get(JobId(request.job_id())));
  v1::GetJobResponse response;
  *response.mutable_job() = convert::ToProto(record);
  return response;
}

}  // namespace axiscal::handlers
