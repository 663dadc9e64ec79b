#include "server/jobs/worker_pool.h"

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
    const std::lock_guard<std::mutex> lock(mutex_);
    if (draining_) return base::Error(absl::StatusCode::kUnavailable, "the server is shutting down", {"DRAINING", {}});
    if (waiting_.size() >= static_cast<size_t>(max_waiting_)) {
      return base::Error(absl::StatusCode::kResourceExhausted,
                         absl::StrCat(waiting_.size(), " tasks wait, no more may"), {"QUEUE_FULL", {}});
    }
    waiting_.push_back(std::move(task));
  }
  changed_.notify_all();
  return absl::OkStatus();
}

void WorkerPool::Drain() {
  std::unique_lock<std::mutex> lock(mutex_);
  draining_ = true;
  changed_.notify_all();
  changed_.wait(lock, [this] { return waiting_.empty() && running_ == 0; });
}

void WorkerPool::Work() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return draining_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    std::function<void()> task = std::move(waiting_.front());
    waiting_.pop_front();
    ++running_;
    lock.unlock();
    task();
    task = nullptr;  // what it holds goes before it counts as done
    lock.lock();
    --running_;
    changed_.notify_all();
  }
}

}  // namespace axiscal::jobs
