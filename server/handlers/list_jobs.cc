#include "server/handlers/list_jobs.h"

#include "proto/convert/job.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ListJobsResponse> ListJobs(Core& core, const Call& call, const v1::ListJobsRequest& request) {
  storage::JobFilter filter;
  if (!request.machine_id().empty()) filter.machine = MachineId(request.machine_id());
  if (request.state() != v1::JOB_STATE_UNSPECIFIED) {
    ASSIGN_OR_RETURN(filter.state, convert::FromProto(request.state()));
  }
  ASSIGN_OR_RETURN(const records::PageRequest page, PageFrom(request.page_size(), request.page_token()));
  ASSIGN_OR_RETURN(const records::Page<records::JobRecord> rows, core.database.ListJobs(filter, page, call.visible));
  v1::ListJobsResponse response;
  for (const records::JobRecord& row : rows.rows) *response.add_jobs() = convert::ToProto(row);
  response.set_next_page_token(rows.next_token);
  return response;
}

}  // namespace axiscal::handlers
