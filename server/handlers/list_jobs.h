// Jobs.ListJobs: a page, newest first.
#ifndef AXISCAL_SERVER_HANDLERS_LIST_JOBS_H_
#define AXISCAL_SERVER_HANDLERS_LIST_JOBS_H_

#include "axiscal/v1/jobs_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ListJobsResponse> ListJobs(Core& core, const Call& call, const v1::ListJobsRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_LIST_JOBS_H_
