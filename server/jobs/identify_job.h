// IDENTIFY: fits a machine's declared errors to stored sessions; makes a candidate calibration with its report.
#ifndef AXISCAL_SERVER_JOBS_IDENTIFY_JOB_H_
#define AXISCAL_SERVER_JOBS_IDENTIFY_JOB_H_

#include "server/jobs/job_context.h"

namespace axiscal::jobs {

// Fails with the engine's words when the sessions do not fit the machine or the fit does not converge; what the data
// cannot tell is no failure, it is named in the calibration. `database` must outlive the function.
JobFunction IdentifyJob(storage::Database& database);

}  // namespace axiscal::jobs

#endif  // AXISCAL_SERVER_JOBS_IDENTIFY_JOB_H_
