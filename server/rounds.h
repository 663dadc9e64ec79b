// A thread that does one thing again and again: what a server looks after while it runs.
#ifndef AXISCAL_SERVER_ROUNDS_H_
#define AXISCAL_SERVER_ROUNDS_H_

#include <chrono>
#include <functional>
#include <thread>

#include "core/base/mutex.h"

namespace axiscal::server {

// Each has a thread and a lock of its own, so that a round that takes minutes holds up no other's.
class Rounds {
 public:
  enum class Begin { kAtOnce, kAfterAPause };

  Rounds() = default;
  Rounds(const Rounds&) = delete;
  Rounds& operator=(const Rounds&) = delete;
  ~Rounds() { Stop(); }

  // Calls `round` from a thread of its own until Stop(), always `pause` after it has returned. At most once.
  void Start(Begin begin, std::chrono::steady_clock::duration pause, std::function<void()> round);
  // Returns when no round goes on and none will. Repeating is harmless, as it is where nothing was started. By one
  // thread, and not from a round.
  void Stop();

 private:
  void Run(Begin begin, std::chrono::steady_clock::duration pause, const std::function<void()>& round);
  // Whether another round is due.
  bool Pause(std::chrono::steady_clock::duration pause);

  base::Mutex mutex_;
  base::CondVar wake_;
  bool is_stopped_ AXISCAL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_ROUNDS_H_
