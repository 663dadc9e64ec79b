#include "server/handlers/get_job.h"

#include "core/base/error_detail.h"
#include "proto/convert/job.h"
#include "proto/convert/report.h"

namespace axiscal::handlers {

absl::StatusOr<v1::GetJobResponse> GetJob(Core& core, const Call& call, const v1::GetJobRequest& request) {
  ASSIGN_OR_RETURN(const records::JobRecord record, core.jobs.Get(JobId(request.job_id())));
  v1::GetJobResponse response;
  *response.mutable_job() = convert::ToProto(record);
  return response;
}

absl::StatusOr<v1::GetReportResponse> GetReport(Core& core, const Call&, const v1::GetReportRequest& request) {
  ASSIGN_OR_RETURN(const records::JobRecord record, core.jobs.Get(JobId(request.job_id())));
  if (record.state != records::JobState::kSucceeded) {
    return base::Error(absl::StatusCode::kFailedPrecondition,
                       absl::StrCat("job ", record.id.number(), " has no report: it has not succeeded"),
                       {"JOB_NOT_ENDED", {}});
  }
  v1::GetReportResponse response;
  ASSIGN_OR_RETURN(*response.mutable_report(), convert::ReportFromJson(record.kind, record.result));
  return response;
}

}  // namespace axiscal::handlers
