#include "server/jobs/worker_pool.h"

#include <memory>
#include <utility>

#include "core/base/demand.h"
#include "core/base/error_detail.h"

namespace axiscal::jobs {

WorkerPool::WorkerPool(int workers, int max_waiting) : max_waiting_(max_waiting) {
  DEMAND(workers > 0 && max_waiting > 0);
  for (int i = 0; i < workers; ++i) threads_.emplace_back([this] { Work(); });
}

WorkerPool::~WorkerPool() {
  Drain();
  for (std::thread& thread : threads_) thread.join();
}

absl::Status WorkerPool::Submit(std::function<void()> task) {
  {
    const base::MutexLock lock(mutex_);
    if (draining_) return base::Error(absl::StatusCode::kUnavailable, "the server is shutting down", {"DRAINING", {}});
    if (waiting_.size() >= static_cast<size_t>(max_waiting_)) {
      return base::Error(absl::StatusCode::kResourceExhausted,
                         absl::StrCat(waiting_.size(), " tasks wait, no more may"), {"QUEUE_FULL", {}});
    }
    waiting_.push_back(std::move(task));
  }
  changed_.NotifyAll();
  return absl::OkStatus();
}

bool WorkerPool::SubmitToIdle(std::function<void()> task) {
  {
    const base::MutexLock lock(mutex_);
    if (draining_ || waiting_.size() + running_ >= threads_.size()) return false;
    waiting_.push_back(std::move(task));
  }
  changed_.NotifyAll();
  return true;
}

bool WorkerPool::HasWaiting() {
  const base::MutexLock lock(mutex_);
  return !waiting_.empty();
}

void WorkerPool::ForEach(int count, const std::function<void(int)>& body) {
  // Helpers may begin after the caller has returned; what they look at then must still be there.
  struct Shared {
    base::Mutex mutex;
    base::CondVar changed;
    int next AXISCAL_GUARDED_BY(mutex) = 0;
    int helpers AXISCAL_GUARDED_BY(mutex) = 0;
  };
  const auto shared = std::make_shared<Shared>();
  const auto take = [shared, count] {
    const base::MutexLock lock(shared->mutex);
    return shared->next < count ? shared->next++ : -1;
  };
  const auto help = [this, shared, take, &body] {
    {
      const base::MutexLock lock(shared->mutex);
      ++shared->helpers;
    }
    for (int index = 0; !HasWaiting() && (index = take()) >= 0;) body(index);
    {
      const base::MutexLock lock(shared->mutex);
      --shared->helpers;
    }
    shared->changed.NotifyAll();
  };
  for (int index = 0; (index = take()) >= 0;) {
    // Threads that became idle meanwhile join.
    constexpr int kLookEvery = 16;
    while (index % kLookEvery == 0 && index + 1 < count && SubmitToIdle(help)) {
    }
    body(index);
  }
  const base::MutexLock lock(shared->mutex);
  while (shared->helpers > 0) shared->changed.Wait(shared->mutex);
}

void WorkerPool::Drain() {
  const base::MutexLock lock(mutex_);
  draining_ = true;
  changed_.NotifyAll();
  while (!waiting_.empty() || running_ > 0) changed_.Wait(mutex_);
}

void WorkerPool::Work() {
  while (true) {
    std::function<void()> task;
    {
      const base::MutexLock lock(mutex_);
      while (!draining_ && waiting_.empty()) changed_.Wait(mutex_);
      if (waiting_.empty()) return;
      task = std::move(waiting_.front());
      waiting_.pop_front();
      ++running_;
    }
    task();
    task = nullptr;  // what it holds goes before it counts as done
    {
      const base::MutexLock lock(mutex_);
      --running_;
    }
    changed_.NotifyAll();
  }
}

}  // namespace axiscal::jobs
