// What a running job sees of the service around it.
#ifndef AXISCAL_SERVER_JOBS_JOB_CONTEXT_H_
#define AXISCAL_SERVER_JOBS_JOB_CONTEXT_H_

#include <atomic>
#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "core/base/clock.h"
#include "server/storage/database.h"

namespace axiscal::jobs {

// Why a job should stop.
enum class StopReason { kNone, kCancelled, kDeadline, kTooLate, kDraining, kLeaseLost };

class JobContext {
 public:
  using Publish = std::function<void(const records::JobProgress&)>;
  using ForEachFunction = std::function<void(int count, const std::function<void(int)>& body)>;
  // `at_deadline`: why it stops then.
  JobContext(base::Clock& clock, base::SteadyTime deadline, StopReason at_deadline, Publish publish,
             ForEachFunction for_each)
      : clock_(clock),
        deadline_(deadline),
        at_deadline_(at_deadline),
        publish_(std::move(publish)),
        for_each_(std::move(for_each)) {}

  // Cheap; ask in every solver iteration. Once true it stays true: return soon, with any error.
  bool cancelled();
  // The reason for stopping; kNone while cancelled() is false.
  StopReason stop_reason() const { return stop_reason_.load(); }
  // The hard limit of this job's kind, or until when it is wanted, steady time.
  base::SteadyTime deadline() const { return deadline_; }
  // Told to watchers at once and stored with the next heartbeat. Call as often as you like.
  void ReportProgress(const std::string& stage, double fraction, const std::string& detail);

  // Calls body(0) .. body(count - 1) on this thread and on workers that are idle; returns when all have returned. The
  // rest of this class may be used from the bodies.
  void ForEach(int count, const std::function<void(int)>& body) { for_each_(count, body); }

  // For the runner: asks the job to stop. The first reason stands.
  void Stop(StopReason reason);

 private:
  base::Clock& clock_;
  const base::SteadyTime deadline_;
  const StopReason at_deadline_;
  const Publish publish_;
  const ForEachFunction for_each_;
  std::atomic<StopReason> stop_reason_{StopReason::kNone};
};

// Does the work of one kind. What it returns is stored with the job's success in one transaction, so a repeated attempt
// never stores twice. An error of code UNAVAILABLE, ABORTED or RESOURCE_EXHAUSTED is tried again (with backoff, up to
// max_attempts), any other ends the job as FAILED with that code, message and base::ErrorDetail reason. Runs on a
// worker's thread; several jobs of a kind may run at once.
using JobFunction = std::function<absl::StatusOr<storage::JobProduct>(const records::JobRecord&, JobContext&)>;

}  // namespace axiscal::jobs

#endif  // AXISCAL_SERVER_JOBS_JOB_CONTEXT_H_
