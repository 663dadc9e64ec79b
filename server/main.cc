// axiscald: the server. Flags to options, signals to an orderly end. Its sub-commands do what needs the file alone.
#include <pthread.h>
#include <signal.h>
#include <sysexits.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdio>
#include <map>
#include <thread>

#include "absl/synchronization/mutex.h"
#include "core/base/files.h"
#include "server/config.h"
#include "server/grpc_log.h"
#include "server/listener.h"
#include "server/log.h"
#include "server/offline.h"
#include "server/server.h"
#include "server/service_manager.h"
#include "server/storage/postgres_url.h"
#include "server/webhooks/addresses.h"

namespace {

using axiscal::server::Configured;
using axiscal::server::Log;
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
  std::string file, backup, from, to;  // of sub-commands
  bool take_damaged = false;
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

void AddCommands(CLI::App& app, CommandLine& line) {
  app.require_subcommand(0, 1);
  app.fallthrough();
  const char* const file = "the database; without it that of the configuration";
  CLI::App* const check = app.add_subcommand("check",
                                             "Say whether a database is what was stored: structure, references, "
                                             "checksums, audit; a file that no server has, or "
                                             "postgresql://USER@HOST/DATABASE, on which axiscald may work on");
  check->add_option("FILE", line.file, file);
  check->footer("Exit code 0: whole; 2: damaged, with a line for each damage; 1: it could not be looked at.");
  CLI::App* const restore = app.add_subcommand(
      "restore", "Put a backup in the place of the database; what was there is kept as FILE.replaced");
  restore->add_option("BACKUP", line.backup, "a file that `axiscal backup` has made")->required();
  restore->add_option("FILE", line.file, file);
  restore->add_flag("--take-damaged", line.take_damaged, "also a backup in which something is damaged");
  CLI::App* const compact =
      app.add_subcommand("compact", "Write the database anew without the space of what was removed");
  compact->add_option("FILE", line.file, file);
  CLI::App* const copy = app.add_subcommand(
      "copy",
      "Carry a store over from a file to a new database of PostgreSQL, or back; goes on where it was broken off");
  copy->add_option("--from", line.from, "the file, or postgresql://USER@HOST/DATABASE; no server has it")->required();
  copy->add_option("--to", line.to, "the same, new")->required();
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
  return configured;
}

absl::StatusOr<std::string> DatabaseOf(const CLI::App& app, const CommandLine& line) {
  if (!line.file.empty()) return line.file;
  ASSIGN_OR_RETURN(const Configured configured, ReadConfiguration(app, line));
  if (!configured.config.database.empty()) return configured.config.database;
  return absl::InvalidArgumentError("which database? Name it, or a configuration (--config)");
}

int RunOffline(const CLI::App& app, const CommandLine& line) {
  const std::string command = app.get_subcommands().front()->get_name();
  if (command == "copy") return axiscal::server::CopyOffline(line.from, line.to);
  const absl::StatusOr<std::string> file = DatabaseOf(app, line);
  if (!file.ok()) {
    std::fprintf(stderr, "axiscald: %s\n", std::string(file.status().message()).c_str());
    return 1;
  }
  if (command == "check") return axiscal::server::CheckOffline(*file);
  if (axiscal::storage::IsPostgresUrl(*file)) {
    std::fprintf(stderr, "axiscald %s: %s is no file: pg_dump and pg_restore are for it (docs/scale.md)\n",
                 command.c_str(), axiscal::storage::WithoutPassword(*file).c_str());
    return 1;
  }
  if (command == "compact") return axiscal::server::CompactOffline(*file);
  return axiscal::server::RestoreOffline(line.backup, *file, line.take_damaged);
}

absl::StatusOr<Configured> ReadAndCheck(const CLI::App& app, const CommandLine& line) {
  ASSIGN_OR_RETURN(Configured configured, ReadConfiguration(app, line));
  RETURN_IF_ERROR(axiscal::server::Check(configured));
  return configured;
}

void PrintConfiguration(const Configured& configured) {
  for (const Setting& setting : axiscal::server::Settings()) {
    const auto place = configured.place.find(setting.key);
    std::printf("%s = %s (%s)\n", setting.key.c_str(),
                axiscal::storage::WithoutPassword(axiscal::server::ValueText(setting, configured.config)).c_str(),
                place == configured.place.end() ? "default" : place->second.c_str());
  }
}

ServerOptions OptionsOf(const axiscal::server::Config& config) {
  ServerOptions options;
  options.database_path = config.database;
  options.listen_address = config.listen;
  options.http_address = config.http;
  options.asks_identity = config.asks_identity;
  options.tls = axiscal::server::TlsFilesOf(config);
  options.workers = static_cast<int>(config.workers);
  options.max_uploads = static_cast<int>(config.max_uploads);
  options.streams_per_principal = static_cast<int>(config.streams_per_principal);
  options.calls_per_second = static_cast<int>(config.calls_per_second);
  options.jobs_per_principal = static_cast<int>(config.jobs_per_principal);
  options.jobs_per_machine = static_cast<int>(config.jobs_per_machine);
  options.session_readings = config.session_readings;
  options.program_bytes = config.program_bytes;
  options.window_bytes = static_cast<int>(config.window_bytes);
  options.waiting_bytes = config.waiting_bytes;
  options.drain = std::chrono::seconds(config.drain_seconds);
  options.silence = std::chrono::seconds(config.silence_seconds);
  options.backup_folder = config.backup_folder;
  options.metrics_machines = static_cast<int>(config.metrics_machines);
  options.webhook_posts.emplace();
  options.webhook_posts->addresses = *axiscal::webhooks::AddressRule::Allowing(config.webhooks_allowed);
  options.webhook_posts->ca_file = config.webhooks_ca;
  options.webhook_posts->mail = axiscal::server::MailOf(config);
  options.keep_readings = std::chrono::hours(24 * config.keep_readings_days);
  options.keep_audit = std::chrono::hours(24 * config.keep_audit_days);
  options.connection_idle = std::chrono::seconds(config.idle_seconds);
  return options;
}

std::string Address(const std::string& listen_address, int port) {
  const size_t colon = listen_address.rfind(':');
  if (port == 0 || colon == std::string::npos || listen_address.rfind("unix:", 0) == 0) return listen_address;
  return listen_address.substr(0, colon + 1) + std::to_string(port);
}

// To systemd, where it has started us.
void Tell(const std::string& state) {
  const absl::Status status = axiscal::server::NotifyServiceManager(state);
  if (!status.ok()) Log(LogLevel::kWarning, "not_notified", {{"text", std::string(status.message())}});
}

std::unique_ptr<axiscal::server::Watchdog> StartWatchdog(Server& server) {
  const auto time = axiscal::server::WatchdogTime(std::getenv("WATCHDOG_USEC"), std::getenv("WATCHDOG_PID"));
  if (!time) return nullptr;
  return std::make_unique<axiscal::server::Watchdog>(
      *time, [&server] { return server.Check(); }, axiscal::server::NotifyServiceManager,
      [](const absl::Status& status) {
        Log(status.ok() ? LogLevel::kInfo : LogLevel::kError, "watchdog",
            {{"ok", status.ok() ? "true" : "false"}, {"text", std::string(status.message())}});
      });
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
  AddCommands(app, line);
  CLI11_PARSE(app, argc, argv);
  if (!app.get_subcommands().empty()) return RunOffline(app, line);
  const absl::StatusOr<Configured> configured = ReadAndCheck(app, line);
  if (!configured.ok()) {
    std::fprintf(stderr, "axiscald: %s\n", std::string(configured.status().message()).c_str());
    return EX_CONFIG;
  }
  if (line.is_check) {
    PrintConfiguration(*configured);
    return 0;
  }
  const ServerOptions options = OptionsOf(configured->config);

  const sigset_t signals = BlockStopSignals();
  axiscal::server::StartLog(configured->config.log_json ? LogFormat::kJson : LogFormat::kKeyValue);
  axiscal::server::TakeGrpcLog();
  axiscal::server::SetLogLevel(*axiscal::records::LogLevelNamed(configured->config.log_level));
  const int64_t descriptors = axiscal::server::RaiseDescriptorLimit();
  Log(LogLevel::kInfo, "start",
      {{"version", AXISCAL_VERSION},
       {"db", axiscal::storage::WithoutPassword(options.database_path)},
       {"listen", options.listen_address},
       {"http", options.http_address},
       {"workers", std::to_string(options.workers)},
       {"max_descriptors", std::to_string(descriptors)}});
  absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(options);
  if (!server.ok()) {
    std::fprintf(stderr, "axiscald: %s\n", std::string(server.status().message()).c_str());
    return 1;
  }
  std::printf("axiscald listens on %s\n", Address(options.listen_address, (*server)->port()).c_str());
  if (!options.http_address.empty()) {
    std::printf("axiscald serves HTTP on %s\n", Address(options.http_address, (*server)->http_port()).c_str());
  }
  std::fflush(stdout);
  Tell("READY=1\nSTATUS=listens on " + Address(options.listen_address, (*server)->port()));
  std::unique_ptr<axiscal::server::Watchdog> watchdog = StartWatchdog(**server);

  int received = 0;
  sigwait(&signals, &received);
  Tell("STOPPING=1\nSTATUS=finishes what it can");
  // From here on systemd counts TimeoutStopSec.
  watchdog.reset();
  {
    const EndAtOnce second(signals);
    (*server)->Shutdown();
  }
  axiscal::server::FlushLog();
  return 0;
}
