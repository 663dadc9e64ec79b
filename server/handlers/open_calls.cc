#include "server/handlers/open_calls.h"

#include <utility>

namespace axiscal::handlers {

OpenCalls::Place::Place(OpenCalls& calls, Entry entry)
    : calls_(calls), entry_(std::make_shared<const Entry>(std::move(entry))) {
  const base::MutexLock lock(calls_.mutex_);
  calls_.entries_.insert(entry_);
}

OpenCalls::Place::~Place() {
  const base::MutexLock lock(calls_.mutex_);
  calls_.entries_.erase(entry_);
}

int OpenCalls::CutOffRefused() {
  std::set<std::shared_ptr<const Entry>> entries;
  {
    const base::MutexLock lock(mutex_);
    entries = entries_;
  }
  int count = 0;
  for (const std::shared_ptr<const Entry>& entry : entries) {
    const absl::Status status = entry->check();
    // A store that does not answer revokes nobody.
    if (!absl::IsNotFound(status) && !absl::IsPermissionDenied(status) && !absl::IsUnauthenticated(status)) continue;
    const base::MutexLock lock(mutex_);
    if (!entries_.contains(entry)) continue;
    entry->cut_off();
    ++count;
  }
  return count;
}

}  // namespace axiscal::handlers
