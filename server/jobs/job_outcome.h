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

// Whether a job that waits again does so without its last attempt counted, by its error.
bool IsNotCounted(const records::JobError& error);

// Where the store is and who answers for it.
enum class StorePlace {
  kHere,      // a file: what goes wrong with it may come from the job (memory, disk), and would come again
  kElsewhere  // a server that may go away, which says nothing against a job
};

// For an attempt (1, 2, ...) that failed with `status`, having been asked to stop for `reason` or not. Waits grow by 4
// from `first_backoff` to ten minutes (a job that was lost often has begun many); the first is how long one whose
// attempt is not counted waits.
JobOutcome DecideOutcome(const absl::Status& status, StopReason reason, int attempt,
                         std::chrono::milliseconds first_backoff, StorePlace store);

}  // namespace axiscal::jobs

#endif  // AXISCAL_SERVER_JOBS_JOB_OUTCOME_H_
