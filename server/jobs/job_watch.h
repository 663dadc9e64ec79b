// Follows one job: for a server stream, without reading the disk again and again.
#ifndef AXISCAL_SERVER_JOBS_JOB_WATCH_H_
#define AXISCAL_SERVER_JOBS_JOB_WATCH_H_

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/mutex.h"
#include "core/records/job.h"

namespace axiscal::jobs {

// How long news of progress alone is held back after what was given before. A simulation of many short runs reports
// thousands of times a second: whoever draws each report has no time left for anything else. Five a second look live.
constexpr std::chrono::milliseconds kProgressEvery(200);

// One subscriber's view. Changes that come faster than Next() is called are merged: the newest is given, the terminal
// one never skipped. Progress alone is given every kProgressEvery at most, changes of the job itself at once.
class JobWatch {
 public:
  // The next state not seen yet: the first call gives the present one at once. Nothing after `timeout` without one that
  // is due (see whether the caller still listens, then call again), and nothing at once when done().
  std::optional<records::JobRecord> Next(std::chrono::milliseconds timeout);
  // A terminal state was given, or the runner is gone.
  bool done();

 private:
  friend class JobBoard;
  using Clock = std::chrono::steady_clock;
  // When `unseen_` may be given: at once, or where only progress is new, a while after what was given last.
  Clock::time_point Due() const AXISCAL_REQUIRES(mutex_);

  base::Mutex mutex_;
  base::CondVar changed_;
  std::optional<records::JobRecord> unseen_ AXISCAL_GUARDED_BY(mutex_);
  int64_t version_ AXISCAL_GUARDED_BY(mutex_) = 0;         // of the newest record delivered; older ones come too late
  bool closed_ AXISCAL_GUARDED_BY(mutex_) = false;         // nothing comes after `unseen_`
  int64_t given_version_ AXISCAL_GUARDED_BY(mutex_) = -1;  // of what Next() gave last; before it: none
  Clock::time_point given_at_ AXISCAL_GUARDED_BY(mutex_);
};

// Where changes of jobs are told to those who watch. Safe from any thread.
class JobBoard {
 public:
  // Follows `job` from now on. To begin with its present state, read that afterwards and Deliver() it.
  std::shared_ptr<JobWatch> Watch(JobId job);
  void Deliver(JobWatch& watch, const records::JobRecord& record);
  void Publish(const records::JobRecord& record);
  // The jobs that somebody follows.
  std::vector<JobId> watched();
  // Ends every watch.
  void Close();

 private:
  base::Mutex mutex_;
  std::map<JobId, std::vector<std::weak_ptr<JobWatch>>> watches_ AXISCAL_GUARDED_BY(mutex_);
  bool closed_ AXISCAL_GUARDED_BY(mutex_) = false;
};

}  // namespace axiscal::jobs

#endif  // AXISCAL_SERVER_JOBS_JOB_WATCH_H_
