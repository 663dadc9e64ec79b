// TOOL_SETTER jobs: the beam's reference from a stored tool-setter session, length and wear from a tool-curve session.
#ifndef AXISCAL_SERVER_JOBS_TOOL_SETTER_JOB_H_
#define AXISCAL_SERVER_JOBS_TOOL_SETTER_JOB_H_

#include "server/jobs/job_context.h"

namespace axiscal::jobs {

// `database` must outlive the function. The result is the report of core/toolsetter/evaluate.h; no calibration: beam
// and wear are no errors of the machine.
JobFunction ToolSetterJob(storage::Database& database);

}  // namespace axiscal::jobs

#endif  // AXISCAL_SERVER_JOBS_TOOL_SETTER_JOB_H_
