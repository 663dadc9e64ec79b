#include "core/base/clock.h"

namespace axiscal::base {
namespace {

class RealClock final : public Clock {
 public:
  UtcTime UtcNow() const override {
    return std::chrono::time_point_cast<std::chrono::microseconds>(std::chrono::system_clock::now());
  }
  SteadyTime SteadyNow() const override { return std::chrono::steady_clock::now(); }
  void WaitUntil(CondVar& changed, Mutex& mutex, SteadyTime deadline) override AXISCAL_REQUIRES(mutex) {
    changed.WaitUntil(mutex, deadline);
  }
};

}  // namespace

Clock& SystemClock() {
  static RealClock* const clock = new RealClock;  // never destroyed: threads may outlive main
  return *clock;
}

}  // namespace axiscal::base
