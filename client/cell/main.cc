// axiscal-cell: watches folders beside a machine and brings what controllers write there to the server (docs/cell.md).
#include <signal.h>
#include <sysexits.h>
#include <time.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "absl/synchronization/mutex.h"
#include "client/cell/cell.h"
#include "client/silence_grpc.h"
#include "core/base/files.h"

namespace {

using axiscal::cell::Cell;
using axiscal::cell::Config;

constexpr size_t kMaxConfigBytes = 1 << 20;

int Fail(const absl::Status& status) {
  std::fprintf(stderr, "axiscal-cell: %s\n", std::string(status.message()).c_str());
  return 1;
}

absl::StatusOr<Config> ReadConfiguration(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string text, axiscal::base::ReadFile(path, kMaxConfigBytes));
  return axiscal::cell::ReadConfig(text, path);
}

// SIGTERM and SIGINT are taken between two files and while nothing is to be done.
sigset_t BlockStopSignals() {
  signal(SIGPIPE, SIG_IGN);
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

// Whether one came meanwhile.
bool WaitForSignal(const sigset_t& signals, std::chrono::milliseconds time) {
  const timespec timeout = {time.count() / 1000, (time.count() % 1000) * 1'000'000};
  return sigtimedwait(&signals, nullptr, &timeout) > 0;
}

}  // namespace

int main(int argc, char** argv) {
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
  axiscal::client::SilenceGrpc();
  CLI::App app(
      "Watches folders beside a machine tool: what controllers and probes write there goes to the server, once, in "
      "order, over power cuts and days without network. Stops on SIGTERM.");
  std::string path = "/etc/axiscal/cell.toml";
  bool is_check = false, is_once = false;
  app.add_option("--config", path, "Configuration file (docs/cell.md)")->capture_default_str();
  app.add_flag("--check-config", is_check, "Say what is wrong with it, or nothing, and end");
  app.add_flag("--once", is_once,
               "Look until nothing is growing, send what waits, and end; 1 where something was left");
  app.footer("Example: axiscal-cell --config /etc/axiscal/cell.toml --check-config");
  app.set_version_flag("--version", AXISCAL_VERSION);
  CLI11_PARSE(app, argc, argv);

  const absl::StatusOr<Config> config = ReadConfiguration(path);
  if (!config.ok()) {
    Fail(config.status());
    return EX_CONFIG;
  }
  if (is_check) {
    const axiscal::client::Identity& identity = config->client.identity;
    for (const std::string& file : {identity.ca, identity.certificate, identity.key, identity.token_file}) {
      if (!file.empty() && access(file.c_str(), R_OK) != 0) {
        Fail(absl::NotFoundError(absl::StrCat(path, ": ", file, ": ", std::strerror(errno))));
        return EX_CONFIG;
      }
    }
    std::printf("%s: %zu folders, server %s, spool %s\n", path.c_str(), config->watches.size(), config->server.c_str(),
                config->spool.folder.c_str());
    return 0;
  }
  const sigset_t signals = BlockStopSignals();
  absl::StatusOr<std::unique_ptr<Cell>> cell = Cell::Create(*config);
  if (!cell.ok()) return Fail(cell.status());
  bool has_ended = false;
  const auto stops = [&] { return has_ended = has_ended || WaitForSignal(signals, std::chrono::milliseconds(0)); };
  while (!stops()) {
    (*cell)->Step(stops);
    const axiscal::cell::Status& status = (*cell)->status();
    if (is_once) {
      int growing = 0;
      for (const auto& folder : status.folders) growing += folder.growing - folder.without_end;
      const bool is_stuck = !status.problem.empty();
      if (!status.looks_on && (is_stuck || (growing == 0 && status.spool.waiting == 0)))
        return status.problem.empty() && status.alarms.empty() ? 0 : 1;
    }
    if (WaitForSignal(signals, (*cell)->Pause())) has_ended = true;
  }
  return 0;
}
