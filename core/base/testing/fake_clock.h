// A clock that stands still until a test moves it.
#ifndef AXISCAL_CORE_BASE_TESTING_FAKE_CLOCK_H_
#define AXISCAL_CORE_BASE_TESTING_FAKE_CLOCK_H_

#include "core/base/clock.h"

namespace axiscal::base {

class FakeClock final : public Clock {
 public:
  UtcTime UtcNow() const override {
    const MutexLock lock(mutex_);
    return utc_;
  }
  SteadyTime SteadyNow() const override {
    const MutexLock lock(mutex_);
    return steady_;
  }
  // Wakes the caller every millisecond, so that it sees an Advance() without being known to this clock.
  void WaitUntil(CondVar& changed, Mutex& mutex, SteadyTime deadline) override AXISCAL_REQUIRES(mutex) {
    changed.WaitUntil(mutex, std::chrono::system_clock::now() + std::chrono::milliseconds(1));
  }

  // Both clocks go on by `duration`.
  void Advance(std::chrono::microseconds duration) {
    const MutexLock lock(mutex_);
    utc_ += duration;
    steady_ += duration;
  }
  // Somebody sets the wall clock; steady time does not notice.
  void SetUtc(UtcTime utc) {
    const MutexLock lock(mutex_);
    utc_ = utc;
  }

 private:
  mutable Mutex mutex_;
  UtcTime utc_ AXISCAL_GUARDED_BY(mutex_) = FromUtcUs(1'700'000'000'000'000);
  SteadyTime steady_ AXISCAL_GUARDED_BY(mutex_) = SteadyTime(std::chrono::seconds(1000));
};

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_TESTING_FAKE_CLOCK_H_
