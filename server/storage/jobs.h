// Rows of `job`, `job_attempt`, `job_program`. What each function returns: database.h.
// A lease runs on the steady clock of the process that owns the database, or, where several share it, on the time that
// a server is up (up_time.h), as a wait does: a wall clock that jumps takes no job away and holds none back.
#ifndef AXISCAL_SERVER_STORAGE_JOBS_H_
#define AXISCAL_SERVER_STORAGE_JOBS_H_

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/storage/connection.h"
#include "server/storage/database.h"

namespace axiscal::storage {

// Attempts that may be lost with their process before a job is DEAD: none of them says that the job is at fault, but
// one that ends its process each time must come to an end.
inline constexpr int kMostLostAttempts = 10;

// Who runs jobs, and when it is.
struct JobOwner {
  std::string id;  // new for every opening of the store
  Moment now;
  int64_t lease_now_us = 0;  // on the clock of leases
  bool is_alone = true;      // jobs of another owner belong to a dead process
};

absl::StatusOr<JobRecord> CreateJob(Connection& connection, const Moment& now, const NewJob& job, const JobRoom& room);
// SHA-256, hex, of a job's result and of whose it is.
std::string JobResultChecksum(JobId id, const std::string& result);
// DATA_LOSS JOB_DAMAGED unless it asks for what it was created with.
absl::Status CheckJobBody(Connection& connection, const JobRecord& job);
// DATA_LOSS JOB_DAMAGED unless its result is what was stored.
absl::StatusOr<JobRecord> GetJob(Connection& connection, JobId id);
// Whoever sees the job's machine sees the program from now on.
absl::Status LinkProgram(Connection& connection, JobId job, ProgramId program);
absl::StatusOr<Page<JobRecord>> ListJobs(Connection& connection, const JobFilter& filter, const PageRequest& request,
                                         const Visible& visible);
// Whether it waits. Then nobody claims it before the end of the transaction: a claim is the one write that does not
// wait for the others (SqlStore::ClaimJob()).
absl::StatusOr<bool> HoldWaiting(Connection& connection, JobId id);
absl::StatusOr<JobRecord> CancelJob(Connection& connection, UtcTime now, JobId id, const Caller& caller);
absl::StatusOr<JobRecord> RequeueJob(Connection& connection, const Moment& now, JobId id, const JobRoom& room,
                                     const Caller& caller);

absl::StatusOr<std::optional<JobRecord>> ClaimJob(Connection& connection, const JobOwner& owner,
                                                  std::chrono::microseconds lease);
absl::StatusOr<std::optional<std::chrono::microseconds>> NextJobWait(Connection& connection, const Moment& now);
// Of those that are there.
absl::StatusOr<std::vector<std::pair<JobId, int64_t>>> JobVersions(Connection& connection,
                                                                   const std::vector<JobId>& ids);
absl::StatusOr<JobQueue> CountJobs(Connection& connection);
absl::StatusOr<JobRecord> HeartbeatJob(Connection& connection, const JobOwner& owner, const JobClaim& claim,
                                       std::chrono::microseconds lease, const JobProgress& progress);
absl::StatusOr<JobRecord> SucceedJob(Connection& connection, const JobOwner& owner, const JobClaim& claim,
                                     const JobProduct& product);
absl::StatusOr<JobRecord> EndJob(Connection& connection, const JobOwner& owner, const JobClaim& claim, JobEnd end,
                                 const JobError& error, std::chrono::microseconds retry_after);
absl::StatusOr<std::vector<JobRecord>> RescueJobs(Connection& connection, const JobOwner& owner);
absl::StatusOr<std::vector<JobRecord>> ReturnJobs(Connection& connection, const JobOwner& owner,
                                                  const std::vector<JobClaim>& held);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_JOBS_H_
