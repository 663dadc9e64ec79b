// What a job that fits reads from the store: the machine as it is described now, and sessions bound to it. A job binds
// and gates each session once, however many fits it makes.
#ifndef AXISCAL_SERVER_JOBS_JOB_SESSIONS_H_
#define AXISCAL_SERVER_JOBS_JOB_SESSIONS_H_

#include <functional>
#include <vector>

#include "core/instruments/run.h"
#include "core/machine/machine.h"
#include "server/jobs/job_context.h"

namespace axiscal::jobs {

struct MachineInput {
  records::MachineRecord record;
  machine::Machine machine;
};

// MACHINE_NOT_FOUND, or as MachineFromJson.
absl::StatusOr<MachineInput> LoadMachine(storage::Database& database, const MachineId& id);

struct MeasuredSessions {
  std::vector<records::SessionRecord> records;
  std::vector<instruments::MeasuringRun> runs;  // in the same order; sessions that share a name are called "NAME#ID"
  base::UtcTime measured_at;                    // of the newest
};

// In the order of `ids`. `cancelled` is polled between sessions. SESSION_NOT_FOUND; INVALID_ARGUMENT naming the session
// when the machine, described anew since the upload, does not fit it; as identify::BindMeasured; CANCELLED.
absl::StatusOr<MeasuredSessions> LoadSessions(storage::Database& database, const std::vector<SessionId>& ids,
                                              const machine::Machine& machine, const std::function<bool()>& cancelled);
absl::StatusOr<MeasuredSessions> LoadSessions(storage::Database& database, const std::vector<SessionId>& ids,
                                              const machine::Machine& machine, JobContext& context);

}  // namespace axiscal::jobs

#endif  // AXISCAL_SERVER_JOBS_JOB_SESSIONS_H_
