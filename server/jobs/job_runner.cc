#include "server/jobs/job_runner.h"

#include <algorithm>
#include <map>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/demand.h"
#include "core/base/error_detail.h"
#include "core/base/mutex.h"
#include "server/jobs/job_outcome.h"
#include "server/jobs/worker_pool.h"

namespace axiscal::jobs {

using records::JobRecord;
using storage::JobClaim;

// One keeper thread claims, keeps leases and rescues; the pool's threads run the functions. The database is never
// called with mutex_ held.
class JobRunner::Impl {
 public:
  Impl(storage::Database& database, const JobRunnerOptions& options) : database_(database), options_(options) {
    DEMAND(options.workers > 0 && options.max_queued > 0 && options.heartbeat.count() > 0 &&
           2 * options.heartbeat < options.lease);
  }

  void Register(const std::string& kind, JobKind job_kind) {
    DEMAND(!keeper_.joinable());
    kinds_[kind] = std::move(job_kind);
  }
  void Start() {
    DEMAND(!keeper_.joinable());
    // A place for every job, and for each that helps one.
    pool_ = std::make_unique<WorkerPool>(options_.workers, 2 * options_.workers);
    keeper_ = std::thread([this] { Keep(); });
  }
  void Drain(std::chrono::milliseconds patience);

  absl::StatusOr<JobRecord> Create(const storage::NewJob& job);
  absl::StatusOr<JobRecord> Get(JobId id);
  absl::StatusOr<JobRecord> Cancel(JobId id, const storage::Caller& caller);
  absl::StatusOr<JobRecord> Requeue(JobId id, const storage::Caller& caller);
  absl::StatusOr<std::shared_ptr<JobWatch>> Watch(JobId id);
  void LookAgain() { Wake(); }

 private:
  struct Running {
    JobRecord record;
    std::shared_ptr<JobContext> context;
  };

  void Tell(const JobEvent& event) {
    if (options_.tell) options_.tell(event);
  }

  // Keeper's thread.
  void Keep();
  base::SteadyTime ClaimAll();
  bool BeginClaim();
  absl::StatusOr<std::optional<JobRecord>> ClaimOne();
  void EndClaim();
  void Launch(const JobRecord& record);
  void BeatAll();
  void Rescue();
  // What was claimed here and runs nowhere, as the store went away meanwhile, goes back to the queue.
  void ReturnUnheld();
  void TellPutBack(const std::vector<JobRecord>& records);
  // Reads what other processes have done with the jobs that are watched or run here.
  void LookAtOthers();

  // Workers' threads.
  void RunJob(const JobRecord& record, JobContext& context);
  absl::StatusOr<storage::JobProduct> CallFunction(const JobRecord& record, JobContext& context);
  // Stores the outcome, tells it and forgets the attempt. As StoreOutcome().
  absl::StatusOr<JobRecord> EndAttempt(const JobRecord& record, JobContext& context,
                                       absl::StatusOr<storage::JobProduct> product, base::SteadyTime start);
  absl::StatusOr<JobRecord> StoreOutcome(const JobRecord& record, JobContext& context,
                                         absl::StatusOr<storage::JobProduct> product);
  void UpdateProgress(JobId id, const records::JobProgress& progress);

  absl::Status CheckNotDraining();
  storage::JobRoom Room() const { return {options_.max_queued, options_.max_of_principal, options_.max_of_machine}; }
  // Tells it where the job had not begun: nobody else would.
  absl::StatusOr<JobRecord> StoreCancel(JobId id, const storage::Caller& caller);
  void Wake();
  // Tells watchers, with the progress of this moment.
  JobRecord Publish(JobRecord record);

  storage::Database& database_;
  const JobRunnerOptions options_;
  std::map<std::string, JobKind> kinds_;  // not changed after Start()
  JobBoard board_;
  // Held from storing the end of an attempt until it is told and has left running_, and while a job is claimed and its
  // start told: an attempt begins after the end of the one before it, unless that one lost its lease. Never locked with
  // mutex_ held.
  base::Mutex turn_mutex_;
  base::Mutex mutex_;
  base::CondVar changed_;
  std::map<JobId, Running> running_ AXISCAL_GUARDED_BY(mutex_);
  bool woken_ AXISCAL_GUARDED_BY(mutex_) = false;          // the keeper has something to do
  bool claiming_ AXISCAL_GUARDED_BY(mutex_) = false;       // a job may be claimed and not in running_ yet
  bool draining_ AXISCAL_GUARDED_BY(mutex_) = false;       // nothing new
  bool parking_ AXISCAL_GUARDED_BY(mutex_) = false;        // what runs is told to stop
  bool stopping_ AXISCAL_GUARDED_BY(mutex_) = false;       // the keeper ends
  bool may_be_unheld_ AXISCAL_GUARDED_BY(mutex_) = false;  // the answer to a claim, or an outcome, was lost
  base::SteadyTime next_beat_{};                           // keeper's thread
  // Others' leases are believed from then on: those who live could prolong them. Keeper's thread.
  base::SteadyTime rescue_from_{};
  std::map<JobId, int64_t> versions_;  // of jobs that are watched or run here; keeper's thread
  base::Mutex drain_mutex_;            // one Drain() at a time
  std::unique_ptr<WorkerPool> pool_;
  std::thread keeper_;
};

// ---- keeper

void JobRunner::Impl::Keep() {
  next_beat_ = options_.clock->SteadyNow() + options_.heartbeat;
  // It may have begun as the store came back, for all.
  if (database_.is_shared()) rescue_from_ = options_.clock->SteadyNow() + options_.lease;
  while (true) {
    if (database_.is_shared()) LookAtOthers();
    base::SteadyTime wake_at = ClaimAll();
    if (const base::SteadyTime now = options_.clock->SteadyNow(); now >= next_beat_) {
      next_beat_ = now + options_.heartbeat;
      BeatAll();
      ReturnUnheld();
      Rescue();
    }
    wake_at = std::min(wake_at, next_beat_);
    bool is_woken = false;
    while (!is_woken) {
      base::SteadyTime next = wake_at;
      if (database_.is_shared()) next = std::min(next, options_.clock->SteadyNow() + kLooksAtOthers);
      {
        const base::MutexLock lock(mutex_);
        while (!woken_ && !stopping_ && options_.clock->SteadyNow() < next)
          options_.clock->WaitUntil(changed_, mutex_, next);
        if (stopping_) return;
        is_woken = std::exchange(woken_, false) || options_.clock->SteadyNow() >= wake_at;
      }
      // To claim means to write; to look at others does not.
      if (!is_woken) LookAtOthers();
    }
  }
}

void JobRunner::Impl::LookAtOthers() {
  std::vector<JobId> jobs = board_.watched();
  {
    const base::MutexLock lock(mutex_);
    for (const auto& [id, running] : running_) jobs.push_back(id);
  }
  std::sort(jobs.begin(), jobs.end());
  jobs.erase(std::unique(jobs.begin(), jobs.end()), jobs.end());
  if (jobs.empty()) return versions_.clear();
  const auto present = database_.JobVersions(jobs);
  if (!present.ok()) return;
  std::map<JobId, int64_t> versions;
  for (const auto& [id, version] : *present) {
    const auto known = versions_.find(id);
    if (known != versions_.end() && known->second == version) {
      versions[id] = version;
      continue;
    }
    const absl::StatusOr<JobRecord> record = database_.GetJob(id);
    if (!record.ok()) continue;
    versions[id] = version;
    Publish(*record);
    const base::MutexLock lock(mutex_);
    const auto found = running_.find(id);
    if (found == running_.end() || !record->cancel_requested) continue;
    if (record->running_attempt == found->second.record.running_attempt)
      found->second.context->Stop(StopReason::kCancelled);
  }
  versions_ = std::move(versions);
}

// An idle worker is there and nobody drains. Drain() gives the claim that follows time to end, as it does what runs.
bool JobRunner::Impl::BeginClaim() {
  const base::MutexLock lock(mutex_);
  claiming_ = !draining_ && running_.size() < static_cast<size_t>(options_.workers);
  return claiming_;
}

void JobRunner::Impl::EndClaim() {
  {
    const base::MutexLock lock(mutex_);
    claiming_ = false;
  }
  changed_.NotifyAll();
}

absl::StatusOr<std::optional<JobRecord>> JobRunner::Impl::ClaimOne() {
  const base::MutexLock turn(turn_mutex_);
  absl::StatusOr<std::optional<JobRecord>> claimed = database_.ClaimJob(options_.lease);
  if (claimed.ok() && claimed->has_value()) Launch(**claimed);
  if (absl::IsUnavailable(claimed.status())) {
    const base::MutexLock lock(mutex_);
    may_be_unheld_ = true;
  }
  return claimed;
}

// Fills the idle workers. When to try again: when the next job's backoff is over.
base::SteadyTime JobRunner::Impl::ClaimAll() {
  const base::SteadyTime later = options_.clock->SteadyNow() + options_.heartbeat;
  while (BeginClaim()) {
    const absl::StatusOr<std::optional<JobRecord>> claimed = ClaimOne();
    EndClaim();
    if (!claimed.ok()) return later;
    if (claimed->has_value()) continue;
    const absl::StatusOr<std::optional<std::chrono::microseconds>> next = database_.NextJobWait();
    if (!next.ok() || !next->has_value()) return later;
    // A job that could begin at once and was not given is in another's hands: asked again at once, and again, it would
    // cost the store more than it waits.
    constexpr std::chrono::milliseconds kInOtherHands(100), kLeast(1);
    const auto wait = **next <= std::chrono::microseconds::zero() ? kInOtherHands
                                                                  : std::max<std::chrono::microseconds>(**next, kLeast);
    return std::min(later, options_.clock->SteadyNow() + wait);
  }
  return later;  // a worker that becomes idle wakes the keeper
}

void JobRunner::Impl::Launch(const JobRecord& record) {
  const auto kind = kinds_.find(record.kind);
  auto time_limit = kind != kinds_.end() ? kind->second.time_limit : std::chrono::milliseconds(0);
  StopReason at_limit = StopReason::kDeadline;
  if (record.deadline) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(*record.deadline - options_.clock->UtcNow());
    if (left < time_limit) at_limit = StopReason::kTooLate;
    time_limit = std::min(time_limit, left);
  }
  const JobId id = record.id;
  auto context = std::make_shared<JobContext>(
      *options_.clock, options_.clock->SteadyNow() + time_limit, at_limit,
      [this, id](const records::JobProgress& progress) { UpdateProgress(id, progress); },
      [this](int count, const auto& body) { pool_->ForEach(count, body); });
  {
    const base::MutexLock lock(mutex_);
    running_[id] = {record, context};
    // Drain() may have told the others to stop between the claim and now.
    if (parking_) context->Stop(StopReason::kDraining);
  }
  if (record.cancel_requested) context->Stop(StopReason::kCancelled);
  Tell({JobEvent::What::kStarted, record, "", {}});
  Publish(record);
  const absl::Status submitted = pool_->Submit([this, record, context] { RunJob(record, *context); });
  DEMAND(submitted.ok());  // there are no more jobs and helpers than workers
}

void JobRunner::Impl::BeatAll() {
  std::vector<Running> all;
  {
    const base::MutexLock lock(mutex_);
    for (const auto& [id, running] : running_) all.push_back(running);
  }
  for (const Running& running : all) {
    const JobClaim claim = storage::ClaimOf(running.record);
    const absl::StatusOr<JobRecord> beaten = database_.HeartbeatJob(claim, options_.lease, running.record.progress);
    if (beaten.ok() && beaten->cancel_requested) running.context->Stop(StopReason::kCancelled);
    if (beaten.ok()) Publish(*beaten);
    // Ended meanwhile, or given to another attempt. Any other failure is tried again with the next beat: the lease
    // outlives several.
    if (absl::IsAborted(beaten.status())) running.context->Stop(StopReason::kLeaseLost);
  }
}

void JobRunner::Impl::Rescue() {
  const base::SteadyTime now = options_.clock->SteadyNow();
  if (now < rescue_from_) {
    if (!database_.NextJobWait().ok()) rescue_from_ = now + options_.lease;
    return;
  }
  const absl::StatusOr<std::vector<JobRecord>> rescued = database_.RescueJobs();
  if (rescued.ok()) return TellPutBack(*rescued);
  if (database_.is_shared()) rescue_from_ = now + options_.lease;
}

void JobRunner::Impl::ReturnUnheld() {
  std::vector<JobClaim> held;
  {
    const base::MutexLock lock(mutex_);
    if (!std::exchange(may_be_unheld_, false)) return;
    // A worker that is about to store an outcome is among them; one whose outcome is lost after this says so again.
    for (const auto& [id, running] : running_) held.push_back(storage::ClaimOf(running.record));
  }
  const absl::StatusOr<std::vector<JobRecord>> returned = database_.ReturnJobs(held);
  if (returned.ok()) return TellPutBack(*returned);
  const base::MutexLock lock(mutex_);
  may_be_unheld_ = true;
}

void JobRunner::Impl::TellPutBack(const std::vector<JobRecord>& records) {
  for (const JobRecord& record : records) {
    const bool is_late = record.state == records::JobState::kFailed;
    Tell({is_late ? JobEvent::What::kEnded : JobEvent::What::kLost, record, OutcomeOf(record), {}});
    Publish(record);
  }
  if (!records.empty()) Wake();
}

// ---- workers

void JobRunner::Impl::RunJob(const JobRecord& record, JobContext& context) {
  const base::SteadyTime start = options_.clock->SteadyNow();
  absl::StatusOr<storage::JobProduct> product = CallFunction(record, context);
  const absl::StatusOr<JobRecord> ended = EndAttempt(record, context, std::move(product), start);
  // An outcome that could not be stored leaves the job RUNNING until the store answers: ReturnUnheld().
  if (ended.ok()) Publish(*ended);
  changed_.NotifyAll();
}

absl::StatusOr<JobRecord> JobRunner::Impl::EndAttempt(const JobRecord& record, JobContext& context,
                                                      absl::StatusOr<storage::JobProduct> product,
                                                      base::SteadyTime start) {
  const base::MutexLock turn(turn_mutex_);
  const absl::StatusOr<JobRecord> ended = StoreOutcome(record, context, std::move(product));
  const auto took = std::chrono::duration_cast<std::chrono::microseconds>(options_.clock->SteadyNow() - start);
  Tell({JobEvent::What::kEnded, ended.ok() ? *ended : record,
        ended.ok() ? OutcomeOf(*ended) : base::ErrorReason(ended.status()), took});
  const base::MutexLock lock(mutex_);
  // The entry is another attempt's where this one had lost its lease.
  const auto found = running_.find(record.id);
  if (found != running_.end() && found->second.context.get() == &context) running_.erase(found);
  // Any other refusal of the store is the outcome's own: it would come again, so the lapse of the lease counts.
  if (absl::IsUnavailable(ended.status())) may_be_unheld_ = true;
  woken_ = true;
  return ended;
}

absl::StatusOr<storage::JobProduct> JobRunner::Impl::CallFunction(const JobRecord& record, JobContext& context) {
  const auto kind = kinds_.find(record.kind);
  if (kind == kinds_.end()) {
    return base::Error(absl::StatusCode::kUnimplemented, "this server cannot run jobs of kind " + record.kind,
                       {"JOB_KIND_UNKNOWN", {}});
  }
  if (context.cancelled()) return absl::CancelledError("stopped before it began");
  // We throw nothing, but libraries under a job may (out of memory); one job must not end the server.
  try {
    return kind->second.run(record, context);
  } catch (const std::exception& exception) {
    return base::Error(absl::StatusCode::kInternal, std::string("job ended by exception: ") + exception.what(),
                       {"JOB_EXCEPTION", {}});
  }
}

absl::StatusOr<JobRecord> JobRunner::Impl::StoreOutcome(const JobRecord& record, JobContext& context,
                                                        absl::StatusOr<storage::JobProduct> product) {
  const JobClaim claim = storage::ClaimOf(record);
  absl::Status status = product.status();
  if (product.ok()) {
    absl::StatusOr<JobRecord> succeeded = database_.SucceedJob(claim, *product);
    if (succeeded.ok() || absl::IsAborted(succeeded.status())) return succeeded;
    status = succeeded.status();
  }
  if (context.stop_reason() == StopReason::kLeaseLost) return status;
  const JobOutcome outcome = DecideOutcome(status, context.stop_reason(), record.attempt, options_.first_backoff,
                                           database_.is_shared() ? StorePlace::kElsewhere : StorePlace::kHere);
  return database_.EndJob(claim, outcome.end, outcome.error, outcome.retry_after);
}

void JobRunner::Impl::UpdateProgress(JobId id, const records::JobProgress& progress) {
  const base::MutexLock lock(mutex_);
  const auto found = running_.find(id);
  if (found == running_.end()) return;
  found->second.record.progress = progress;
  board_.Publish(found->second.record);
}

// ---- callers

absl::Status JobRunner::Impl::CheckNotDraining() {
  const base::MutexLock lock(mutex_);
  if (!draining_) return absl::OkStatus();
  return base::Error(absl::StatusCode::kUnavailable, "the server is shutting down", {"DRAINING", {}});
}

void JobRunner::Impl::Wake() {
  {
    const base::MutexLock lock(mutex_);
    woken_ = true;
  }
  changed_.NotifyAll();
}

JobRecord JobRunner::Impl::Publish(JobRecord record) {
  const base::MutexLock lock(mutex_);
  const auto found = running_.find(record.id);
  if (found != running_.end() && record.running_attempt == found->second.record.running_attempt) {
    record.progress = found->second.record.progress;
    if (record.version > found->second.record.version) found->second.record = record;
  }
  board_.Publish(record);
  return record;
}

absl::StatusOr<JobRecord> JobRunner::Impl::Create(const storage::NewJob& job) {
  RETURN_IF_ERROR(CheckNotDraining());
  if (kinds_.find(job.kind) == kinds_.end()) {
    return base::Error(absl::StatusCode::kInvalidArgument, "no jobs of kind " + job.kind,
                       {"JOB_KIND_UNKNOWN", {{"kind", job.kind}}});
  }
  ASSIGN_OR_RETURN(const JobRecord record, database_.CreateJob(job, Room()));
  Publish(record);
  Wake();
  return record;
}

absl::StatusOr<JobRecord> JobRunner::Impl::Get(JobId id) {
  ASSIGN_OR_RETURN(JobRecord record, database_.GetJob(id));
  const base::MutexLock lock(mutex_);
  const auto found = running_.find(id);
  if (found != running_.end() && record.running_attempt == found->second.record.running_attempt) {
    record.progress = found->second.record.progress;
  }
  return record;
}

absl::StatusOr<JobRecord> JobRunner::Impl::StoreCancel(JobId id, const storage::Caller& caller) {
  const base::MutexLock turn(turn_mutex_);
  ASSIGN_OR_RETURN(const JobRecord record, database_.CancelJob(id, caller));
  const bool never_began = record.state == records::JobState::kCancelled && !record.started_at;
  if (never_began) Tell({JobEvent::What::kEnded, record, OutcomeOf(record), {}});
  return record;
}

absl::StatusOr<JobRecord> JobRunner::Impl::Cancel(JobId id, const storage::Caller& caller) {
  ASSIGN_OR_RETURN(const JobRecord record, StoreCancel(id, caller));
  {
    const base::MutexLock lock(mutex_);
    const auto found = running_.find(id);
    if (found != running_.end() && record.cancel_requested) found->second.context->Stop(StopReason::kCancelled);
  }
  return Publish(record);
}

absl::StatusOr<JobRecord> JobRunner::Impl::Requeue(JobId id, const storage::Caller& caller) {
  RETURN_IF_ERROR(CheckNotDraining());
  ASSIGN_OR_RETURN(const JobRecord record, database_.RequeueJob(id, Room(), caller));
  Publish(record);
  Wake();
  return record;
}

absl::StatusOr<std::shared_ptr<JobWatch>> JobRunner::Impl::Watch(JobId id) {
  std::shared_ptr<JobWatch> watch = board_.Watch(id);
  ASSIGN_OR_RETURN(const JobRecord record, Get(id));
  board_.Deliver(*watch, record);
  return watch;
}

void JobRunner::Impl::Drain(std::chrono::milliseconds patience) {
  const base::MutexLock one_at_a_time(drain_mutex_);
  {
    const base::MutexLock lock(mutex_);
    draining_ = true;
    const base::SteadyTime give_up_at = options_.clock->SteadyNow() + patience;
    while ((claiming_ || !running_.empty()) && options_.clock->SteadyNow() < give_up_at)
      options_.clock->WaitUntil(changed_, mutex_, give_up_at);
    parking_ = true;
    for (auto& [id, running] : running_) running.context->Stop(StopReason::kDraining);
  }
  // Running functions see it within an iteration; a claim just made is told in Launch().
  {
    const base::MutexLock lock(mutex_);
    stopping_ = true;
  }
  changed_.NotifyAll();
  if (keeper_.joinable()) keeper_.join();
  if (pool_ != nullptr) pool_->Drain();
  // Nothing runs any more: what the store did not take of it is put back where the store is there again.
  if (pool_ != nullptr) ReturnUnheld();
  board_.Close();
}

std::string OutcomeOf(const JobRecord& job) {
  switch (job.state) {
    case records::JobState::kSucceeded:
      return "SUCCEEDED";
    case records::JobState::kFailed:
      return "FAILED";
    case records::JobState::kCancelled:
      return "CANCELLED";
    case records::JobState::kDead:
      return "DEAD";
    default:
      return job.error && IsNotCounted(*job.error) ? "PARKED" : "RETRY";
  }
}

// ---- the public face

JobRunner::JobRunner(storage::Database& database, const JobRunnerOptions& options)
    : impl_(std::make_unique<Impl>(database, options)) {}
JobRunner::~JobRunner() { impl_->Drain(std::chrono::milliseconds(0)); }
void JobRunner::Register(const std::string& kind, JobKind job_kind) { impl_->Register(kind, std::move(job_kind)); }
void JobRunner::Start() { impl_->Start(); }
absl::StatusOr<JobRecord> JobRunner::Create(const storage::NewJob& job) { return impl_->Create(job); }
absl::StatusOr<JobRecord> JobRunner::Get(JobId id) { return impl_->Get(id); }
absl::StatusOr<JobRecord> JobRunner::Cancel(JobId id, const storage::Caller& caller) {
  return impl_->Cancel(id, caller);
}
absl::StatusOr<JobRecord> JobRunner::Requeue(JobId id, const storage::Caller& caller) {
  return impl_->Requeue(id, caller);
}
absl::StatusOr<std::shared_ptr<JobWatch>> JobRunner::Watch(JobId id) { return impl_->Watch(id); }
void JobRunner::LookAgain() { impl_->LookAgain(); }
void JobRunner::Drain(std::chrono::milliseconds patience) { impl_->Drain(patience); }

}  // namespace axiscal::jobs
