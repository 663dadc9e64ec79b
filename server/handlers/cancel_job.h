// Jobs.CancelJob: asks a job to stop.
#ifndef AXISCAL_SERVER_HANDLERS_CANCEL_JOB_H_
#define AXISCAL_SERVER_HANDLERS_CANCEL_JOB_H_

#include "axiscal/v1/jobs_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::CancelJobResponse> CancelJob(Core& core, const Call& call, const v1::CancelJobRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_CANCEL_JOB_H_
