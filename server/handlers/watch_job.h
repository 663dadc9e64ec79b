// Jobs.WatchJob: the job now and after every change, until it has ended.
#ifndef AXISCAL_SERVER_HANDLERS_WATCH_JOB_H_
#define AXISCAL_SERVER_HANDLERS_WATCH_JOB_H_

#include "axiscal/v1/jobs_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

// `send` returns false when the caller has left. UNAVAILABLE DRAINING when the server stops first.
absl::Status WatchJob(Core& core, const Call& call, const v1::WatchJobRequest& request,
                      const std::function<bool(const v1::WatchJobResponse&)>& send);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_WATCH_JOB_H_
