// axiscald: the server. Flags to options, signals to an orderly end.
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdio>
#include <thread>

#include "absl/synchronization/mutex.h"
#include "server/listener.h"
#include "server/log.h"
#include "server/server.h"

namespace {

using axiscal::server::LogFormat;
using axiscal::server::LogLevel;
using axiscal::server::Server;
using axiscal::server::ServerOptions;

// SIGTERM and SIGINT are taken by sigwait in main: stopping a server inside a signal handler dies in Debian's Abseil.
sigset_t BlockStopSignals() {
  signal(SIGPIPE, SIG_IGN);
  signal(SIGXFSZ, SIG_IGN);
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

// While it lives, one more of these signals ends the process at once: whoever sends it has waited long enough. As after
// kill -9, nothing that was acknowledged is lost.
class EndAtOnce {
 public:
  explicit EndAtOnce(const sigset_t& signals) : thread_([this, signals] { Wait(signals); }) {}
  ~EndAtOnce() {
    is_over_ = true;
    pthread_kill(thread_.native_handle(), SIGTERM);
    thread_.join();
  }
  EndAtOnce(const EndAtOnce&) = delete;
  EndAtOnce& operator=(const EndAtOnce&) = delete;

 private:
  void Wait(const sigset_t& signals) {
    int received = 0;
    sigwait(&signals, &received);
    if (is_over_) return;
    Log(LogLevel::kWarning, "killed", {{"text", "a second signal: not waiting for what still runs"}});
    axiscal::server::FlushLog();
    _exit(128 + received);
  }

  std::atomic<bool> is_over_ = false;
  std::thread thread_;
};

std::string Address(const std::string& listen_address, int port) {
  const size_t colon = listen_address.rfind(':');
  if (port == 0 || colon == std::string::npos || listen_address.rfind("unix:", 0) == 0) return listen_address;
  return listen_address.substr(0, colon + 1) + std::to_string(port);
}

}  // namespace

int main(int argc, char** argv) {
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
  CLI::App app("Axiscal server: keeps machine tools true. Stops on SIGTERM: finishes what it can, parks the rest.");
  app.footer("Example:\n  axiscald --db /var/lib/axiscal/axiscal.db --listen 0.0.0.0:7410 --workers 4");
  app.set_version_flag("--version", AXISCAL_VERSION);
  ServerOptions options;
  options.listen_address = "127.0.0.1:7410";
  int drain_seconds = 20, silence_seconds = 300, idle_seconds = 300;
  bool log_json = false;
  app.add_option("--db", options.database_path, "Database file; made when it is not there")->required();
  app.add_option("--listen", options.listen_address, "Address and port; port 0 picks a free one")
      ->capture_default_str();
  app.add_option("--workers", options.workers, "Jobs at once; each uses one core")->capture_default_str();
  app.add_option("--max-uploads", options.max_uploads, "Streams that bring something, at a time")
      ->capture_default_str();
  app.add_option("--window-bytes", options.window_bytes, "Bytes a stream may run ahead of the server")
      ->capture_default_str();
  app.add_option("--drain-seconds", drain_seconds, "How long calls and jobs may go on after SIGTERM")
      ->capture_default_str();
  app.add_option("--silence-seconds", silence_seconds, "A caller silent for so long in a stream is cut off")
      ->capture_default_str();
  app.add_option("--idle-seconds", idle_seconds, "A connection without a call for so long is closed")
      ->capture_default_str();
  app.add_flag("--log-json", log_json, "Log lines as JSON instead of key=value");
  CLI11_PARSE(app, argc, argv);
  options.drain = std::chrono::seconds(drain_seconds);
  options.silence = std::chrono::seconds(silence_seconds);
  options.connection_idle = std::chrono::seconds(idle_seconds);

  const sigset_t signals = BlockStopSignals();
  axiscal::server::StartLog(log_json ? LogFormat::kJson : LogFormat::kKeyValue);
  const int64_t descriptors = axiscal::server::RaiseDescriptorLimit();
  Log(LogLevel::kInfo, "start",
      {{"version", AXISCAL_VERSION},
       {"db", options.database_path},
       {"listen", options.listen_address},
       {"workers", std::to_string(options.workers)},
       {"max_descriptors", std::to_string(descriptors)}});
  absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(options);
  if (!server.ok()) {
    std::fprintf(stderr, "axiscald: %s\n", std::string(server.status().message()).c_str());
    return 1;
  }
  std::printf("axiscald listens on %s\n", Address(options.listen_address, (*server)->port()).c_str());
  std::fflush(stdout);

  int received = 0;
  sigwait(&signals, &received);
  {
    const EndAtOnce second(signals);
    (*server)->Shutdown();
  }
  axiscal::server::FlushLog();
  return 0;
}
