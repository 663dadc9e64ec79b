// axiscal: the command line. Global options, one sub-command, one exit code.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>

#include "absl/synchronization/mutex.h"
#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/embedded.h"
#include "client/cli/exit_code.h"
#include "client/silence_grpc.h"
#include "core/base/error_detail.h"

namespace axiscal::cli {
namespace {

void AddGlobalOptions(CLI::App& app, Context& context) {
  app.require_subcommand(1);
  app.fallthrough();
  auto* server = app.add_option("--server", context.server, "address of a running axiscald, HOST:PORT or unix:PATH")
                     ->envname("AXISCAL_SERVER");
  app.add_option("--db", context.database, "without --server: run the service in this process on this file")
      ->envname("AXISCAL_DB")
      ->capture_default_str()
      ->excludes(server);
  app.add_option("--ca", context.identity.ca, "of a server with TLS: the authority of its certificate, a PEM file")
      ->envname("AXISCAL_CA");
  app.add_option("--certificate", context.identity.certificate, "your certificate, a PEM file, with --key")
      ->envname("AXISCAL_CERTIFICATE");
  app.add_option("--key", context.identity.key, "its key, a PEM file")->envname("AXISCAL_KEY");
  app.add_option("--token-file", context.identity.token_file, "a file with your token, read again for each call")
      ->envname("AXISCAL_TOKEN_FILE");
  app.add_option("--user", context.user, "a name for the server's log; whom it takes you for: axiscal admin whoami")
      ->envname("AXISCAL_USER")
      ->capture_default_str();
  app.add_flag("--json", context.json, "print one JSON document; errors as JSON on standard error");
  app.set_version_flag("--version", AXISCAL_VERSION);
}

void AddCommands(CLI::App& app, Context& context) {
  AddMachineCommand(app, context);
  AddReduceCommand(app, context);
  AddUploadCommand(app, context);
  AddSpoolCommand(app, context);
  AddCellsCommand(app, context);
  AddSessionCommand(app, context);
  AddIdentifyCommand(app, context);
  AddApproveCommand(app, context);
  AddCalibrationCommand(app, context);
  AddCloseLoopCommand(app, context);
  AddCompensateCommand(app, context);
  AddVerifyCommand(app, context);
  AddPredictCommand(app, context);
  AddCompareCommand(app, context);
  AddReportCommand(app, context);
  AddFiguresCommand(app, context);
  AddTableCommand(app, context);
  AddProgramCommand(app, context);
  AddPlanCommand(app, context);
  AddSimulateCommand(app, context);
  AddToolSetterCommand(app, context);
  AddPublishedCommand(app, context);
  AddCareCommand(app, context);
  AddHistoryCommand(app, context);
  AddDriftCommand(app, context);
  AddVolumetricCommand(app, context);
  AddMarkCommand(app, context);
  AddExpectCommand(app, context);
  AddEventsCommand(app, context);
  AddRoutineCommand(app, context);
  AddJobsCommand(app, context);
  AddBackupCommand(app, context);
  AddDoctorCommand(app, context);
  AddAdminCommand(app, context);
}

void PrintError(const absl::Status& status, bool json) {
  const std::string message(status.message());
  if (!json) {
    std::fprintf(stderr, "axiscal: %s\n", message.c_str());
    return;
  }
  const Json document = {{"error",
                          {{"code", absl::StatusCodeToString(status.code())},
                           {"reason", base::ErrorReason(status)},
                           {"message", message},
                           {"exit_code", static_cast<int>(ExitCodeOf(status))}}}};
  std::fprintf(stderr, "%s\n", document.Dump().c_str());
}

// A command line that cannot be read leaves context.json as it was.
bool AsksForJson(int argc, char** argv) {
  return std::any_of(argv + 1, argv + argc, [](const std::string& word) { return word == "--json"; });
}

void PrintUsageError(const CLI::ParseError& error) {
  const Json document = {{"error",
                          {{"code", absl::StatusCodeToString(absl::StatusCode::kInvalidArgument)},
                           {"reason", "USAGE"},
                           {"message", error.what()},
                           {"exit_code", static_cast<int>(kUsage)}}}};
  std::fprintf(stderr, "%s\n", document.Dump().c_str());
}

int Main(int argc, char** argv) {
  Context context(StartServiceHere);
  CLI::App app(
      "Axiscal keeps machine tools true: upload what probes measured, identify the machine's errors, compensate NC "
      "programs.",
      "axiscal");
  AddGlobalOptions(app, context);
  AddCommands(app, context);
  app.footer(std::string("Examples:\n"
                         "  axiscal machine add machine.json && axiscal machine explain mt\n"
                         "  axiscal upload tuesday/*.csv && axiscal identify --machine mt --all && axiscal approve 1\n"
                         "  axiscal compensate --machine mt --tool-tip \"0 0 -350\" in.nc -o out.nc\n") +
             kExitCodeHelp);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {  // CLI11 reports --help and usage errors this way
    if (error.get_exit_code() == 0 || !AsksForJson(argc, argv)) return app.exit(error) == 0 ? kOk : kUsage;
    PrintUsageError(error);
    return kUsage;
  }
  if (!context.status.ok()) PrintError(context.status, context.json);
  if (std::fflush(stdout) != 0) return kFailed;
  return ExitCodeOf(context.status);
}

}  // namespace
}  // namespace axiscal::cli

int main(int argc, char** argv) {
  // Debian's Abseil aborts at lock orders that gRPC's own shutdown uses.
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
  // A file beyond the user's limit (ulimit -f) is an error of the write, like a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  axiscal::client::SilenceGrpc();
  return axiscal::cli::Main(argc, argv);
}
