// What to do with a job after its function has returned.
#ifndef AXISCAL_SERVER_JOBS_JOB_OUTCOME_H_
#define AXISCAL_SERVER_JOBS_JOB_OUTCOME_H_

#include <chrono>

#include "server/jobs/job_context.h"

namespace axiscal::jobs {

struct JobOutcome {
  storage::JobEnd end = storage::JobEnd::kFailed;
  records::JobError error;
  std::chrono::milliseconds retry_after{0};
};

// Codes that another attempt may cure; the others come from the job itself and would come again.
bool IsWorthRetrying(absl::StatusCode code);

// For an attempt (1, 2, ...) that failed with `status`, having been asked to stop for `reason` or not. Waits grow by 4
// from `first_backoff`.
JobOutcome DecideOutcome(const absl::Status& status, StopReason reason, int attempt,
                         std::chrono::milliseconds first_backoff);

}  // namespace axiscal::jobs

#endif  // AXISCAL_SERVER_JOBS_JOB_OUTCOME_H_
