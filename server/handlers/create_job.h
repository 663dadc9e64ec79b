// Jobs.CreateJob: queues work whose inputs are there.
#ifndef AXISCAL_SERVER_HANDLERS_CREATE_JOB_H_
#define AXISCAL_SERVER_HANDLERS_CREATE_JOB_H_

#include "axiscal/v1/jobs_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::CreateJobResponse> CreateJob(Core& core, const Call& call, const v1::CreateJobRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_CREATE_JOB_H_
