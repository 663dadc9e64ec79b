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

// One subscriber's view. Changes that come faster than Next() is called are merged: the newest is given, the terminal
// one never skipped.
class JobWatch {
 public:
  // The next state not seen yet: the first call gives the present one at once. Nothing after `timeout` without a change
  // (see whether the caller still listens, then call again), and nothing at once when done().
  std::optional<records::JobRecord> Next(std::chrono::milliseconds timeout);
  // A terminal state was given, or the runner is gone.
  bool done();

 private:
  friend class JobBoard;
  base::Mutex mutex_;
  base::CondVar changed_;
  std::optional<records::JobRecord> unseen_ AXISCAL_GUARDED_BY(mutex_);
  int64_t version_ AXISCAL_GUARDED_BY(mutex_) = 0;  // of the newest record delivered; older ones come too late
  bool closed_ AXISCAL_GUARDED_BY(mutex_) = false;  // nothing comes after `unseen_`
};

// Where changes of jobs are told to those who watch. Safe from any thread.
class JobBoard {
 public:
  // Follows `job` from now on. To begin with its present state, read that afterwards and Deliver() it.
  std::shared_ptr<JobWatch> Watch(JobId job);
  void Deliver(JobWatch& watch, const records::JobRecord& record);
  void Publish(const records::JobRecord& record);
  // Ends every watch.
  void Close();

 private:
  base::Mutex mutex_;
  std::map<JobId, std::vector<std::weak_ptr<JobWatch>>> watches_ AXISCAL_GUARDED_BY(mutex_);
  bool closed_ AXISCAL_GUARDED_BY(mutex_) = false;
};

}  // namespace axiscal::jobs

#endif  // AXISCAL_SERVER_JOBS_JOB_WATCH_H_
