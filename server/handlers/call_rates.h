// How often each principal may call. Whoever calls more often is refused at once, before anything is read for him: a
// flood from one cell slows no other.
#ifndef AXISCAL_SERVER_HANDLERS_CALL_RATES_H_
#define AXISCAL_SERVER_HANDLERS_CALL_RATES_H_

#include <map>
#include <string>

#include "core/base/clock.h"
#include "core/base/mutex.h"
#include "core/base/status.h"

namespace axiscal::handlers {

// Safe from any thread.
class CallRates {
 public:
  // `per_second` > 0; a caller that was quiet may make twice as many at once.
  explicit CallRates(int per_second, base::Clock& clock = base::SystemClock())
      : per_second_(per_second), clock_(clock) {}

  // RESOURCE_EXHAUSTED RATE_EXCEEDED. `who`: a principal, or whatever calls are counted by.
  absl::Status Take(const std::string& who);
  // Of how many callers something is remembered: those that were not quiet lately.
  size_t remembered() const;

 private:
  // Calls that are left, and since when they were not counted up.
  struct Left {
    double calls = 0;
    base::SteadyTime at;
  };
  // Those that may call as often as they like are as if they had never called.
  void ForgetQuiet(base::SteadyTime now) AXISCAL_REQUIRES(mutex_);
  double LeftNow(const Left& left, base::SteadyTime now) const;

  const int per_second_;
  base::Clock& clock_;
  mutable base::Mutex mutex_;
  std::map<std::string, Left> left_ AXISCAL_GUARDED_BY(mutex_);
  base::SteadyTime forgot_at_ AXISCAL_GUARDED_BY(mutex_){};
};

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_CALL_RATES_H_
