#include "server/rounds.h"

#include <utility>

#include "core/base/demand.h"

namespace axiscal::server {

void Rounds::Start(Begin begin, std::chrono::steady_clock::duration pause, std::function<void()> round) {
  DEMAND(!thread_.joinable());
  thread_ = std::thread([this, begin, pause, round = std::move(round)] { Run(begin, pause, round); });
}

void Rounds::Stop() {
  {
    const base::MutexLock lock(mutex_);
    is_stopped_ = true;
    wake_.NotifyAll();
  }
  if (thread_.joinable()) thread_.join();
}

void Rounds::Run(Begin begin, std::chrono::steady_clock::duration pause, const std::function<void()>& round) {
  constexpr std::chrono::steady_clock::duration kNone(0);
  for (bool is_due = Pause(begin == Begin::kAtOnce ? kNone : pause); is_due; is_due = Pause(pause)) round();
}

bool Rounds::Pause(std::chrono::steady_clock::duration pause) {
  const auto until = std::chrono::steady_clock::now() + pause;
  const base::MutexLock lock(mutex_);
  while (!is_stopped_ && std::chrono::steady_clock::now() < until) wake_.WaitUntil(mutex_, until);
  return !is_stopped_;
}

}  // namespace axiscal::server
