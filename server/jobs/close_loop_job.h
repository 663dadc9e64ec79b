// CLOSE_LOOP: finds what a machine's declared model lacks; makes a candidate calibration with the extended model.
#ifndef AXISCAL_SERVER_JOBS_CLOSE_LOOP_JOB_H_
#define AXISCAL_SERVER_JOBS_CLOSE_LOOP_JOB_H_

#include "server/jobs/job_context.h"

namespace axiscal::jobs {

// The job's result and the calibration's report are of reports::Loop, byte for byte what the same sessions give from
// files.
// Fails with the engine's words when the sessions do not fit the machine. `database` must outlive the function.
JobFunction CloseLoopJob(storage::Database& database);

}  // namespace axiscal::jobs

#endif  // AXISCAL_SERVER_JOBS_CLOSE_LOOP_JOB_H_
