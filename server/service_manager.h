// What systemd is told (sd_notify(3)), and its watchdog. The protocol is one datagram to the socket that $NOTIFY_SOCKET
// names, so no library is linked for it. Without that variable nothing is sent.
#ifndef AXISCAL_SERVER_SERVICE_MANAGER_H_
#define AXISCAL_SERVER_SERVICE_MANAGER_H_

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <thread>

#include "core/base/mutex.h"
#include "core/base/status.h"

namespace axiscal::server {

// Sends `state`, lines of NAME=VALUE ("READY=1"), to `socket_path`: a file, or "@name" of the abstract namespace. OK
// where the path is null or empty: nobody asks. UNAVAILABLE with the reason where it cannot be sent.
absl::Status Notify(const char* socket_path, const std::string& state);
// The same to $NOTIFY_SOCKET.
absl::Status NotifyServiceManager(const std::string& state);

// After which silence systemd ends the process: $WATCHDOG_USEC (`microseconds`), unless $WATCHDOG_PID (`pid`) names
// another process. Nothing where it does not watch, or the text is no number > 0.
std::optional<std::chrono::microseconds> WatchdogTime(const char* microseconds, const char* pid);

// While it lives, asks `check` on a thread of its own each half of `time` and sends WATCHDOG=1 after each OK. A check
// that fails or does not return is silence. `tell` hears of each change between OK and an error.
class Watchdog {
 public:
  Watchdog(std::chrono::microseconds time, std::function<absl::Status()> check,
           std::function<absl::Status(const std::string&)> notify, std::function<void(const absl::Status&)> tell);
  // Waits for a check that is under way.
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

 private:
  void Run();

  const std::chrono::microseconds time_;
  const std::function<absl::Status()> check_;
  const std::function<absl::Status(const std::string&)> notify_;
  const std::function<void(const absl::Status&)> tell_;
  base::Mutex mutex_;
  base::CondVar wake_;
  bool is_over_ AXISCAL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_SERVICE_MANAGER_H_
