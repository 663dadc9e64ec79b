// COMPENSATE: rewrites a stored NC program for a machine's approved calibration (or the one that was named); makes a
// program and a report.
#ifndef AXISCAL_SERVER_JOBS_COMPENSATE_JOB_H_
#define AXISCAL_SERVER_JOBS_COMPENSATE_JOB_H_

#include "server/jobs/job_context.h"

namespace axiscal::jobs {

// Kind of the programs it makes.
inline constexpr char kCompensatedProgram[] = "compensated-nc";

// Fails with the engine's words when a block cannot be corrected; FAILED_PRECONDITION MACHINE_CHANGED when the
// machine's axes are no longer those that the calibration was fitted with. `database` must outlive the function.
JobFunction CompensateJob(storage::Database& database);

}  // namespace axiscal::jobs

#endif  // AXISCAL_SERVER_JOBS_COMPENSATE_JOB_H_
