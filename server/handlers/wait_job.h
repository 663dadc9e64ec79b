// Jobs.WaitJob: the job when it has ended or the time is over.
#ifndef AXISCAL_SERVER_HANDLERS_WAIT_JOB_H_
#define AXISCAL_SERVER_HANDLERS_WAIT_JOB_H_

#include "axiscal/v1/jobs_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::WaitJobResponse> WaitJob(Core& core, const Call& call, const v1::WaitJobRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_WAIT_JOB_H_
