// Jobs.GetJob: as it stands, with the progress of this moment.
#ifndef AXISCAL_SERVER_HANDLERS_GET_JOB_H_
#define AXISCAL_SERVER_HANDLERS_GET_JOB_H_

#include "axiscal/v1/jobs_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::GetJobResponse> GetJob(Core& core, const Call& call, const v1::GetJobRequest& request);

// Jobs.GetReport: of a job that has succeeded.
absl::StatusOr<v1::GetReportResponse> GetReport(Core& core, const Call& call, const v1::GetReportRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_GET_JOB_H_
