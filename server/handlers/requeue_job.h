// Jobs.RequeueJob: runs an ended job again.
#ifndef AXISCAL_SERVER_HANDLERS_REQUEUE_JOB_H_
#define AXISCAL_SERVER_HANDLERS_REQUEUE_JOB_H_

#include "axiscal/v1/jobs_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::RequeueJobResponse> RequeueJob(Core& core, const Call& call, const v1::RequeueJobRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_REQUEUE_JOB_H_
