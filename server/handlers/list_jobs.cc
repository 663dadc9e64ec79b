#include "server/handlers/list_jobs.h"

#include <algorithm>

#include "absl/strings/str_join.h"
#include "core/records/job_params.h"
#include "proto/convert/field.h"
#include "proto/convert/job.h"
#include "proto/convert/time.h"

namespace axiscal::handlers {
namespace {

absl::Status RequireKind(const std::string& kind) {
  const auto kinds = {records::kIdentify, records::kCloseLoop, records::kCompensate, records::kToolSetter};
  if (kind.empty() || std::find(kinds.begin(), kinds.end(), kind) != kinds.end()) return absl::OkStatus();
  return convert::FieldError("kind", absl::StrCat("'", kind, "', must be one of ", absl::StrJoin(kinds, ", ")));
}

}  // namespace

absl::StatusOr<v1::ListJobsResponse> ListJobs(Core& core, const Call& call, const v1::ListJobsRequest& request) {
  storage::JobFilter filter;
  if (!request.machine_id().empty()) filter.machine = MachineId(request.machine_id());
  if (request.state() != v1::JOB_STATE_UNSPECIFIED) {
    ASSIGN_OR_RETURN(filter.state, convert::FromProto(request.state()));
  }
  filter.created = {OPTIONAL_UTC(request, from_utc_us), OPTIONAL_UTC(request, to_utc_us)};
  RETURN_IF_ERROR(RequireSpan(filter.created));
  RETURN_IF_ERROR(RequireKind(request.kind()));
  filter.kind = request.kind();
  ASSIGN_OR_RETURN(const records::PageRequest page, PageFrom(request.page_size(), request.page_token()));
  ASSIGN_OR_RETURN(const records::Page<records::JobRecord> rows,
                   FirstWithRows(call, page, [&](const records::PageRequest& part) {
                     return core.database.ListJobs(filter, part, call.visible);
                   }));
  v1::ListJobsResponse response;
  for (const records::JobRecord& row : rows.rows) *response.add_jobs() = convert::ToProto(row);
  response.set_next_page_token(rows.next_token);
  return response;
}

}  // namespace axiscal::handlers
