// Time as the service uses it: UTC to tell people when (it may jump), steady time to measure how long (leases,
// deadlines, backoff).
#ifndef AXISCAL_CORE_BASE_CLOCK_H_
#define AXISCAL_CORE_BASE_CLOCK_H_

#include <chrono>

#include "core/base/mutex.h"

namespace axiscal::base {

// Microseconds since 1970-01-01 UTC: `_utc_us` on disk and wire.
using UtcTime = std::chrono::sys_time<std::chrono::microseconds>;
using SteadyTime = std::chrono::steady_clock::time_point;

// Safe from any thread.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual UtcTime UtcNow() const = 0;
  virtual SteadyTime SteadyNow() const = 0;
  // Waits with `mutex` released until `changed` is notified or the steady clock reaches `deadline`; may wake early, so
  // the caller loops on its own condition.
  virtual void WaitUntil(CondVar& changed, Mutex& mutex, SteadyTime deadline) AXISCAL_REQUIRES(mutex) = 0;
};

// The machine's clocks; lives as long as the program.
Clock& SystemClock();

inline int64_t ToUtcUs(UtcTime time) { return time.time_since_epoch().count(); }
inline UtcTime FromUtcUs(int64_t utc_us) { return UtcTime(std::chrono::microseconds(utc_us)); }

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_CLOCK_H_
