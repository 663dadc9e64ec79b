#include "server/jobs/job_watch.h"

#include <algorithm>
#include <utility>

namespace axiscal::jobs {

JobWatch::Clock::time_point JobWatch::Due() const {
  const bool is_progress_alone = unseen_->version == given_version_ && !closed_;
  return is_progress_alone ? given_at_ + kProgressEvery : Clock::time_point::min();
}

std::optional<records::JobRecord> JobWatch::Next(std::chrono::milliseconds timeout) {
  const Clock::time_point deadline = Clock::now() + timeout;
  const base::MutexLock lock(mutex_);
  while (unseen_ || !closed_) {
    const Clock::time_point now = Clock::now();
    if (unseen_ && Due() <= now) {
      given_version_ = unseen_->version;
      given_at_ = now;
      return std::exchange(unseen_, std::nullopt);
    }
    if (now >= deadline) break;
    changed_.WaitUntil(mutex_, unseen_ ? std::min(deadline, Due()) : deadline);
  }
  return std::nullopt;
}

bool JobWatch::done() {
  const base::MutexLock lock(mutex_);
  return closed_ && !unseen_.has_value();
}

std::shared_ptr<JobWatch> JobBoard::Watch(JobId job) {
  auto watch = std::make_shared<JobWatch>();
  const base::MutexLock lock(mutex_);
  {
    const base::MutexLock watch_lock(watch->mutex_);
    watch->closed_ = closed_;
  }
  std::vector<std::weak_ptr<JobWatch>>& watches = watches_[job];
  std::erase_if(watches, [](const std::weak_ptr<JobWatch>& gone) { return gone.expired(); });
  watches.push_back(watch);
  return watch;
}

void JobBoard::Deliver(JobWatch& watch, const records::JobRecord& record) {
  {
    const base::MutexLock lock(watch.mutex_);
    if (record.version < watch.version_) return;
    watch.version_ = record.version;
    watch.unseen_ = record;
    watch.closed_ = watch.closed_ || IsTerminal(record.state);
  }
  watch.changed_.NotifyAll();
}

void JobBoard::Publish(const records::JobRecord& record) {
  const base::MutexLock lock(mutex_);
  const auto found = watches_.find(record.id);
  if (found == watches_.end()) return;
  for (const std::weak_ptr<JobWatch>& weak : found->second) {
    if (const std::shared_ptr<JobWatch> watch = weak.lock()) Deliver(*watch, record);
  }
  if (IsTerminal(record.state)) watches_.erase(found);
}

std::vector<JobId> JobBoard::watched() {
  std::vector<JobId> jobs;
  const base::MutexLock lock(mutex_);
  for (auto& [job, watches] : watches_) {
    std::erase_if(watches, [](const std::weak_ptr<JobWatch>& gone) { return gone.expired(); });
    if (!watches.empty()) jobs.push_back(job);
  }
  std::erase_if(watches_, [](const auto& of_job) { return of_job.second.empty(); });
  return jobs;
}

void JobBoard::Close() {
  const base::MutexLock lock(mutex_);
  closed_ = true;
  for (const auto& [job, watches] : watches_) {
    for (const std::weak_ptr<JobWatch>& weak : watches) {
      const std::shared_ptr<JobWatch> watch = weak.lock();
      if (watch == nullptr) continue;
      {
        const base::MutexLock watch_lock(watch->mutex_);
        watch->closed_ = true;
      }
      watch->changed_.NotifyAll();
    }
  }
  watches_.clear();
}

}  // namespace axiscal::jobs
