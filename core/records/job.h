// A job, the service's long work: what it is, how far, and how it ended.
#ifndef AXISCAL_CORE_RECORDS_JOB_H_
#define AXISCAL_CORE_RECORDS_JOB_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/base/clock.h"
#include "core/base/ids.h"

namespace axiscal::records {

// Never renumber.
enum class JobState { kQueued = 1, kRunning = 2, kSucceeded = 3, kFailed = 4, kCancelled = 5, kDead = 6 };

inline bool IsTerminal(JobState state) { return state != JobState::kQueued && state != JobState::kRunning; }

struct JobProgress {
  std::string stage;      // "fit", "write program"
  double fraction = 0.0;  // 0 .. 1 of the whole job
  std::string detail;     // "iteration 4, rms 2.97 um"

  bool operator==(const JobProgress&) const = default;
};

struct JobError {
  absl::StatusCode code = absl::StatusCode::kUnknown;
  std::string reason;  // "DEADLINE", "OWNER_LOST" ...; may be empty
  std::string message;
};

struct JobRecord {
  JobId id;
  std::string kind;                  // "identify", "compensate", ... (job_params.h)
  std::optional<MachineId> machine;  // the machine it works on
  std::string params;                // what it is to do, as bytes: convert::ParseJobParams reads them
  std::string input_hash;            // of all inputs and the engine's version; empty: not comparable
  int priority = 0;                  // larger runs first
  JobState state = JobState::kQueued;
  int attempt = 0;  // counted when claimed
  int max_attempts = 3;
  // Which attempt runs, counted over all that there ever were (`attempt` may start again); 0 when none does.
  int64_t running_attempt = 0;
  bool cancel_requested = false;
  JobProgress progress;
  std::string result;                        // the report of a succeeded job; empty in lists
  std::optional<CalibrationId> calibration;  // that it made
  std::vector<ProgramId> programs;           // that it made
  std::optional<JobError> error;             // of the last attempt that failed
  std::string created_by;
  std::string request_id = {}, trace = {};  // of the call that created it; trace: its traceparent; empty: none
  base::UtcTime created_at;
  std::optional<base::UtcTime> started_at, ended_at;  // of the last attempt
  int64_t version = 0;                                // grows with every change of the row
  std::optional<base::UtcTime> deadline;              // what has not ended by then fails
};

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_JOB_H_
