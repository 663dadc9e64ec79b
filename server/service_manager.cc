#include "server/service_manager.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>

#include "absl/strings/numbers.h"
#include "core/base/clock.h"

namespace axiscal::server {

absl::Status Notify(const char* socket_path, const std::string& state) {
  if (socket_path == nullptr || *socket_path == '\0') return absl::OkStatus();
  const auto fail = [&](const std::string& what) {
    return absl::UnavailableError(absl::StrCat("NOTIFY_SOCKET = ", socket_path, ": ", what));
  };
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  const size_t length = std::strlen(socket_path);
  if ((socket_path[0] != '/' && socket_path[0] != '@') || length >= sizeof(address.sun_path)) {
    return fail("expected an absolute path or @name of at most 107 bytes");
  }
  std::memcpy(address.sun_path, socket_path, length);
  if (address.sun_path[0] == '@') address.sun_path[0] = '\0';
  const int socket_fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket_fd < 0) return fail(std::strerror(errno));
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + length);
  const ssize_t sent =
      sendto(socket_fd, state.data(), state.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&address), size);
  const int error = errno;
  close(socket_fd);
  return sent == static_cast<ssize_t>(state.size()) ? absl::OkStatus() : fail(std::strerror(error));
}

absl::Status NotifyServiceManager(const std::string& state) { return Notify(std::getenv("NOTIFY_SOCKET"), state); }

std::optional<std::chrono::microseconds> WatchdogTime(const char* microseconds, const char* pid) {
  int64_t number = 0, of_process = 0;
  if (microseconds == nullptr || !absl::SimpleAtoi(microseconds, &number) || number <= 0) return std::nullopt;
  if (pid != nullptr && (!absl::SimpleAtoi(pid, &of_process) || of_process != getpid())) return std::nullopt;
  return std::chrono::microseconds(number);
}

Watchdog::Watchdog(std::chrono::microseconds time, std::function<absl::Status()> check,
                   std::function<absl::Status(const std::string&)> notify,
                   std::function<void(const absl::Status&)> tell)
    : time_(time), check_(std::move(check)), notify_(std::move(notify)), tell_(std::move(tell)) {
  thread_ = std::thread([this] { Run(); });
}

Watchdog::~Watchdog() {
  {
    const base::MutexLock lock(mutex_);
    is_over_ = true;
    wake_.NotifyAll();
  }
  thread_.join();
}

void Watchdog::Run() {
  bool was_ok = true;
  while (true) {
    absl::Status status = check_();
    if (status.ok()) status = notify_("WATCHDOG=1");
    if (status.ok() != was_ok) tell_(status);
    was_ok = status.ok();
    const base::SteadyTime next = base::SystemClock().SteadyNow() + time_ / 2;
    const base::MutexLock lock(mutex_);
    while (!is_over_ && base::SystemClock().SteadyNow() < next) wake_.WaitUntil(mutex_, next);
    if (is_over_) return;
  }
}

}  // namespace axiscal::server
