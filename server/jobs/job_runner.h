// Runs the jobs of a database in this process: claims, runs, keeps the lease, stores the outcome, tells watchers.
// All creating and cancelling goes through here, so that workers and watchers hear of it. Where several processes share
// the database, what they do with a job that is watched or runs here is read there: when LookAgain() says so, and every
// kLooksAtOthers.
#ifndef AXISCAL_SERVER_JOBS_JOB_RUNNER_H_
#define AXISCAL_SERVER_JOBS_JOB_RUNNER_H_

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "server/jobs/job_context.h"
#include "server/jobs/job_watch.h"
#include "server/storage/database.h"

namespace axiscal::jobs {

// What happens to a job, for a log.
struct JobEvent {
  enum class What {
    kStarted,  // an attempt
    kEnded,    // an attempt, or a job that was cancelled before it began
    kLost,     // an attempt whose worker was not heard of for longer than its lease
  };
  What what = What::kStarted;
  records::JobRecord job;  // as it is then
  // Of kEnded and kLost: the job's state (SUCCEEDED, FAILED, CANCELLED, DEAD), RETRY or PARKED where it waits again, or
  // why the end could not be stored (LEASE_LOST, STORE_DOWN ...).
  std::string outcome;
  std::optional<std::chrono::microseconds> took;  // this attempt
};

// What became of a job that an attempt has left, as JobEvent::outcome has it.
std::string OutcomeOf(const records::JobRecord& job);

// How often it is looked what other processes have done, where nobody says that they have: a cancelled job is to end
// within half a second.
inline constexpr std::chrono::milliseconds kLooksAtOthers(400);

struct JobRunnerOptions {
  int workers = 2;           // jobs at once, > 0; a job uses one core
  int max_queued = 1000;     // waiting jobs, > 0; more are refused
  int max_of_principal = 0;  // as storage::JobRoom
  int max_of_machine = 0;
  std::chrono::milliseconds lease = std::chrono::seconds(30);         // a worker silent for this long loses its job
  std::chrono::milliseconds heartbeat = std::chrono::seconds(5);      // < lease / 2
  std::chrono::milliseconds first_backoff = std::chrono::seconds(5);  // then 4 times longer each attempt
  // Told of every start and end of an attempt, from several threads. May be empty.
  std::function<void(const JobEvent&)> tell;
  base::Clock* clock = &base::SystemClock();
};

struct JobKind {
  JobFunction run;
  std::chrono::milliseconds time_limit = std::chrono::minutes(10);  // of one attempt; then it ends as FAILED, DEADLINE
};

// Safe from any thread after Start().
class JobRunner {
 public:
  // `database` must outlive the runner.
  JobRunner(storage::Database& database, const JobRunnerOptions& options);
  // Drains at once: running jobs are told to stop and parked.
  ~JobRunner();
  JobRunner(const JobRunner&) = delete;
  JobRunner& operator=(const JobRunner&) = delete;

  // Before Start().
  void Register(const std::string& kind, JobKind job_kind);
  void Start();

  // INVALID_ARGUMENT JOB_KIND_UNKNOWN, RESOURCE_EXHAUSTED QUEUE_FULL, UNAVAILABLE DRAINING, or as Database::CreateJob.
  absl::StatusOr<records::JobRecord> Create(const storage::NewJob& job);
  // With the progress of this moment.
  absl::StatusOr<records::JobRecord> Get(JobId id);
  absl::StatusOr<records::JobRecord> Cancel(JobId id, const storage::Caller& caller);
  absl::StatusOr<records::JobRecord> Requeue(JobId id, const storage::Caller& caller);
  // NOT_FOUND JOB_NOT_FOUND. The watch outlives the job and, closed, the runner.
  absl::StatusOr<std::shared_ptr<JobWatch>> Watch(JobId id);
  // Another process has done something with jobs. Never waits.
  void LookAgain();

  // Claims nothing more, lets running jobs go on for `patience`, then tells the rest to stop and puts them back into
  // the queue, their attempt not counted. Returns when no job runs; watches are then closed.
  void Drain(std::chrono::milliseconds patience);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace axiscal::jobs

#endif  // AXISCAL_SERVER_JOBS_JOB_RUNNER_H_
