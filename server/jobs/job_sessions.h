// What a job that fits reads from the store: the machine as it is described now, and sessions ready for the engine.
#ifndef AXISCAL_SERVER_JOBS_JOB_SESSIONS_H_
#define AXISCAL_SERVER_JOBS_JOB_SESSIONS_H_

#include <vector>

#include "core/machine/machine.h"
#include "core/session/session.h"
#include "server/jobs/job_context.h"

namespace axiscal::jobs {

struct MachineInput {
  records::MachineRecord record;
  machine::Machine machine;
};

// MACHINE_NOT_FOUND, or as MachineFromJson.
absl::StatusOr<MachineInput> LoadMachine(storage::Database& database, const MachineId& id);

struct StoredSessions {
  std::vector<records::SessionRecord> records;
  std::vector<session::Session> sessions;  // in the same order; sessions that share a name are called "NAME#ID"
  base::UtcTime measured_at;               // of the newest
};

// In the order of `ids`. SESSION_NOT_FOUND; INVALID_ARGUMENT naming the session when the machine, described anew since
// the upload, does not fit it; CANCELLED.
absl::StatusOr<StoredSessions> LoadSessions(storage::Database& database, const std::vector<SessionId>& ids,
                                            const machine::Machine& machine, JobContext& context);

}  // namespace axiscal::jobs

#endif  // AXISCAL_SERVER_JOBS_JOB_SESSIONS_H_
