// Where it is told that events have changed: those who watch them wake up and read the store. Safe from any thread.
#ifndef AXISCAL_SERVER_WATCH_EVENT_BOARD_H_
#define AXISCAL_SERVER_WATCH_EVENT_BOARD_H_

#include <chrono>
#include <cstdint>

#include "core/base/mutex.h"

namespace axiscal::watch {

class EventBoard {
 public:
  // Something may have changed. After it is on the disk.
  void Tell() {
    const base::MutexLock lock(mutex_);
    ++told_;
    changed_.NotifyAll();
  }
  // How often it was told so far. Ask before the store is read: what changes afterwards is not missed.
  int64_t told() {
    const base::MutexLock lock(mutex_);
    return told_;
  }
  // Returns when it was told more often than `seen`, or `timeout` is over.
  void Wait(int64_t seen, std::chrono::milliseconds timeout) {
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    const base::MutexLock lock(mutex_);
    while (told_ <= seen && std::chrono::steady_clock::now() < deadline) changed_.WaitUntil(mutex_, deadline);
  }

 private:
  base::Mutex mutex_;
  base::CondVar changed_;
  int64_t told_ AXISCAL_GUARDED_BY(mutex_) = 0;
};

}  // namespace axiscal::watch

#endif  // AXISCAL_SERVER_WATCH_EVENT_BOARD_H_
