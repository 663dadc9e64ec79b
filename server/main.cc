// axiscald: the server. Flags to options, signals to an orderly end.
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdio>
#include <map>
#include <thread>

#include "absl/synchronization/mutex.h"
#include "core/base/files.h"
#include "server/config.h"
#include "server/listener.h"
#include "server/log.h"
#include "server/server.h"

namespace {

using axiscal::server::Configured;
using axiscal::server::LogFormat;
using axiscal::server::LogLevel;
using axiscal::server::Server;
using axiscal::server::ServerOptions;
using axiscal::server::Setting;

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

constexpr size_t kMaxConfigBytes = 1 << 20;

// What the command line says: a text for each setting that it names, by flag.
struct CommandLine {
  std::string config_path;
  bool is_check = false;
  std::map<std::string, std::string> texts;
  std::map<std::string, bool> switches;
};

void AddOptions(CLI::App& app, CommandLine& line) {
  app.add_option("--config", line.config_path,
                 "Configuration file (docs/configuration.md); the environment overrides "
                 "it, flags override both")
      ->envname("AXISCALD_CONFIG");
  app.add_flag("--check-config", line.is_check,
               "Say what the configuration comes to, or what is wrong with it, and end");
  const axiscal::server::Config defaults;
  for (const Setting& setting : axiscal::server::Settings()) {
    if (setting.is_switch()) {
      app.add_flag(setting.flag, line.switches[setting.flag], setting.meaning);
      continue;
    }
    const std::string value = axiscal::server::ValueText(setting, defaults);
    app.add_option(setting.flag, line.texts[setting.flag],
                   setting.meaning + (value.empty() ? "" : " (default " + value + ")"));
  }
}

absl::StatusOr<Configured> ReadConfiguration(const CLI::App& app, const CommandLine& line) {
  Configured configured;
  if (!line.config_path.empty()) {
    ASSIGN_OR_RETURN(const std::string text, axiscal::base::ReadFile(line.config_path, kMaxConfigBytes));
    RETURN_IF_ERROR(axiscal::server::ReadToml(text, line.config_path, configured));
  }
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) variables.push_back(*variable);
  RETURN_IF_ERROR(axiscal::server::ReadEnvironment(variables, configured));
  for (const Setting& setting : axiscal::server::Settings()) {
    if (app.count(setting.flag) == 0) continue;
    const std::string text =
        setting.is_switch() ? (line.switches.at(setting.flag) ? "true" : "false") : line.texts.at(setting.flag);
    RETURN_IF_ERROR(axiscal::server::SetText(setting, text, setting.flag, configured));
  }
  RETURN_IF_ERROR(axiscal::server::Check(configured));
  return configured;
}

void PrintConfiguration(const Configured& configured) {
  for (const Setting& setting : axiscal::server::Settings()) {
    const auto place = configured.place.find(setting.key);
    std::printf("%s = %s (%s)\n", setting.key.c_str(), axiscal::server::ValueText(setting, configured.config).c_str(),
                place == configured.place.end() ? "default" : place->second.c_str());
  }
}

ServerOptions OptionsOf(const axiscal::server::Config& config) {
  ServerOptions options;
  options.database_path = config.database;
  options.listen_address = config.listen;
  options.asks_identity = config.asks_identity;
  options.tls = axiscal::server::TlsFilesOf(config);
  options.workers = static_cast<int>(config.workers);
  options.max_uploads = static_cast<int>(config.max_uploads);
  options.window_bytes = static_cast<int>(config.window_bytes);
  options.drain = std::chrono::seconds(config.drain_seconds);
  options.silence = std::chrono::seconds(config.silence_seconds);
  options.connection_idle = std::chrono::seconds(config.idle_seconds);
  return options;
}

std::string Address(const std::string& listen_address, int port) {
  const size_t colon = listen_address.rfind(':');
  if (port == 0 || colon == std::string::npos || listen_address.rfind("unix:", 0) == 0) return listen_address;
  return listen_address.substr(0, colon + 1) + std::to_string(port);
}

}  // namespace

int main(int argc, char** argv) {
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
  CLI::App app("Axiscal server: keeps machine tools true. Stops on SIGTERM: finishes what it can, parks the rest.");
  app.footer(
      "Examples:\n  axiscald --db /var/lib/axiscal/axiscal.db --workers 4\n  axiscald --config "
      "/etc/axiscal/axiscald.toml "
      "--check-config\nEach flag but the first two is also a variable of the environment: AXISCALD_WORKERS.");
  app.set_version_flag("--version", AXISCAL_VERSION);
  CommandLine line;
  AddOptions(app, line);
  CLI11_PARSE(app, argc, argv);
  const absl::StatusOr<Configured> configured = ReadConfiguration(app, line);
  if (!configured.ok()) {
    std::fprintf(stderr, "axiscald: %s\n", std::string(configured.status().message()).c_str());
    return 1;
  }
  if (line.is_check) {
    PrintConfiguration(*configured);
    return 0;
  }
  const ServerOptions options = OptionsOf(configured->config);

  const sigset_t signals = BlockStopSignals();
  axiscal::server::StartLog(configured->config.log_json ? LogFormat::kJson : LogFormat::kKeyValue);
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
