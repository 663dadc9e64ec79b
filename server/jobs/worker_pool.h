// A fixed number of threads that run tasks from a bounded queue in order of submission.
#ifndef AXISCAL_SERVER_JOBS_WORKER_POOL_H_
#define AXISCAL_SERVER_JOBS_WORKER_POOL_H_

#include <deque>
#include <functional>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "core/base/mutex.h"

namespace axiscal::jobs {

// Safe from any thread.
class WorkerPool {
 public:
  WorkerPool(int workers, int max_waiting);
  // Runs what was accepted, then joins.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  // RESOURCE_EXHAUSTED QUEUE_FULL when `max_waiting` tasks wait, UNAVAILABLE DRAINING after Drain(): the task is then
  // not run.
  absl::Status Submit(std::function<void()> task);
  // Runs `body(0)` .. `body(count - 1)` on the calling thread and on idle threads of the pool; returns when all have
  // returned. Idle threads help only while no task waits. May be called from a task.
  void ForEach(int count, const std::function<void(int)>& body);
  // Accepts nothing more and returns when every accepted task has run.
  void Drain();
  int workers() const { return static_cast<int>(threads_.size()); }

 private:
  void Work();
  // Whether a thread has nothing to do; if so, it gets the task.
  bool SubmitToIdle(std::function<void()> task);
  bool HasWaiting();

  const int max_waiting_;
  base::Mutex mutex_;
  base::CondVar changed_;
  std::deque<std::function<void()>> waiting_ AXISCAL_GUARDED_BY(mutex_);
  int running_ AXISCAL_GUARDED_BY(mutex_) = 0;
  bool draining_ AXISCAL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace axiscal::jobs

#endif  // AXISCAL_SERVER_JOBS_WORKER_POOL_H_
