#include "server/jobs/tool_setter_job.h"

#include "core/toolsetter/evaluate.h"
#include "proto/convert/job_params.h"
#include "server/jobs/job_sessions.h"

namespace axiscal::jobs {
namespace {

absl::StatusOr<storage::JobProduct> RunToolSetter(storage::Database& database, const records::JobRecord& job,
                                                  JobContext& context) {
  ASSIGN_OR_RETURN(const records::JobParams any_params, convert::ParseJobParams(job.params));
  const auto& params = std::get<records::ToolSetterParams>(any_params);
  context.ReportProgress("read session", 0.0, "");
  ASSIGN_OR_RETURN(const session::Session session, database.ReadSession(params.session));
  if (context.cancelled()) return absl::CancelledError("stopped");
  context.ReportProgress("fit", 0.1, "");
  storage::JobProduct product;
  ASSIGN_OR_RETURN(const reports::ToolSetter report, toolsetter::Evaluate(session, {params.fit_yaw, params.fit_pitch}));
  product.result = reports::ToJson(report);
  return product;
}

}  // namespace

JobFunction ToolSetterJob(storage::Database& database) {
  return
      [&database](const records::JobRecord& job, JobContext& context) { return RunToolSetter(database, job, context); };
}

}  // namespace axiscal::jobs
