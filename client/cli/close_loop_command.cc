// axiscal close-loop: the effects that a machine's model lacks, from a case folder without database and server, or as a
// job on stored sessions.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/job_wait.h"
#include "client/cli/loop_text.h"
#include "client/cli/output_paths.h"
#include "client/cli/record_output.h"
#include "client/cli/session_choice.h"
#include "core/base/files.h"
#include "core/base/json_limits.h"
#include "core/base/mutex.h"
#include "core/decide/close_loop.h"
#include "core/identify/residuals_csv.h"
#include "core/instruments/plausible.h"
#include "core/loop/pictures.h"
#include "core/machine/error_json.h"
#include "core/session/case.h"

namespace axiscal::cli {
namespace {

struct CloseLoopArguments {
  std::string folder, machine, report, errors, residuals, plot, request_id;
  std::vector<std::string> fit, check;
  std::optional<int> max_effects;
  std::string budget;
  std::optional<int> monte_carlo;
  std::optional<uint64_t> seed;
  bool no_wait = false;
};

absl::Status WriteOutputs(const CloseLoopArguments& arguments, const std::string& report, const std::string& errors) {
  if (!arguments.report.empty()) RETURN_IF_ERROR(base::WriteFileAtomically(arguments.report, report));
  if (!arguments.errors.empty()) RETURN_IF_ERROR(base::WriteFileAtomically(arguments.errors, errors));
  return absl::OkStatus();
}

absl::Status WritePictures(const std::string& folder, const std::vector<loop::Picture>& pictures) {
  for (const loop::Picture& picture : pictures) {
    const std::string path = absl::StrCat(folder, "/", picture.file);
    RETURN_IF_ERROR(base::WriteFileAtomically(path, picture.svg));
    if (picture.panels.empty()) continue;
    // What it shows, beside it.
    RETURN_IF_ERROR(base::WriteFileAtomically(path.substr(0, path.rfind('.')) + ".csv",
                                              plot::Csv(picture.x_label, picture.y_label, picture.panels)));
  }
  return absl::OkStatus();
}

// The folder for pictures, made where it is missing; before any work, so that a bad name costs none.
absl::Status MakeFolder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder))
    return absl::InvalidArgumentError(absl::StrCat("--plot ", folder, ": ", error ? error.message() : "no folder"));
  return absl::OkStatus();
}

absl::Status CheckPaths(const CloseLoopArguments& arguments, const std::vector<NamedPath>& inputs) {
  return CheckOutputs(
      inputs, {{"--report", arguments.report}, {"--errors", arguments.errors}, {"--residuals", arguments.residuals}});
}

// The simulation that was asked for, and the text of its budget; both ways take the same.
absl::Status CheckSimulation(const CloseLoopArguments& arguments) {
  if (arguments.monte_carlo) return absl::OkStatus();
  if (arguments.seed) return absl::InvalidArgumentError("--seed: expected --monte-carlo with it");
  if (!arguments.budget.empty()) return absl::InvalidArgumentError("--budget: expected --monte-carlo with it");
  return absl::OkStatus();
}

absl::StatusOr<std::string> BudgetText(const CloseLoopArguments& arguments) {
  if (arguments.budget.empty()) return std::string();
  return base::ReadFile(arguments.budget, base::kMaxJsonBytes);
}

// Without a server the runs of the simulation share the machine's cores.
void OnAllCores(int count, const std::function<void(int)>& body) {
  std::atomic<int> next = 0;
  std::vector<std::thread> threads;
  const int others = std::min(count, static_cast<int>(std::max(1u, std::thread::hardware_concurrency()))) - 1;
  const auto work = [&] {
    for (int index = next++; index < count; index = next++) body(index);
  };
  for (int i = 0; i < others; ++i) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
}

absl::Status AddSimulation(const CloseLoopArguments& arguments, const machine::Machine& machine,
                           decide::Options* options) {
  if (!arguments.monte_carlo) return absl::OkStatus();
  options->monte_carlo.emplace();
  options->monte_carlo->runs = *arguments.monte_carlo;
  options->monte_carlo->seed = arguments.seed.value_or(options->monte_carlo->seed);
  options->monte_carlo->for_each = OnAllCores;
  ASSIGN_OR_RETURN(options->budget_json, BudgetText(arguments));
  if (options->budget_json.empty()) return absl::OkStatus();
  auto budget = identify::ReadBudget(options->budget_json, machine);
  if (!budget.ok()) return base::Within(arguments.budget, budget.status());
  options->monte_carlo->budget = *std::move(budget);
  return absl::OkStatus();
}

// What an upload asks of sessions, asked of files.
absl::Status CheckPlausible(const std::vector<std::string>& files, const std::vector<session::Session>& sessions,
                            const machine::Machine& machine) {
  for (size_t i = 0; i < files.size(); ++i)
    RETURN_IF_ERROR(base::Within(files[i], instruments::CheckPlausible(sessions[i], machine)));
  return absl::OkStatus();
}

// The readings of the last fit, and those of the check sessions under it.
absl::Status WriteResiduals(const std::string& path, const machine::Machine& machine,
                            const std::vector<instruments::MeasuringRun>& check, const loop::Report& report) {
  if (path.empty()) return absl::OkStatus();
  std::string text = identify::ResidualsCsvHeader() + identify::ResidualsCsv("fit", *report.last_fit);
  if (!check.empty() && !report.is_check_fitted) {
    identify::Options options;
    options.profile_intervals = false;
    ASSIGN_OR_RETURN(const identify::Fit checked, identify::CheckRuns(machine, check, *report.last_fit, options));
    text += identify::ResidualsCsv("check", checked);
  }
  return base::WriteFileAtomically(path, text);
}

absl::Status CloseLoopOfFiles(Context& context, const CloseLoopArguments& arguments) {
  ASSIGN_OR_RETURN(const session::Case measured, session::ReadCase(arguments.folder));
  std::vector<NamedPath> inputs = {{"machine.json", arguments.folder + "/machine.json"}};
  for (const auto* files : {&measured.fit_files, &measured.check_files}) {
    for (const std::string& file : *files) inputs.push_back({"session", file});
  }
  RETURN_IF_ERROR(CheckPaths(arguments, inputs));
  RETURN_IF_ERROR(CheckPlausible(measured.fit_files, measured.fit, measured.machine));
  RETURN_IF_ERROR(CheckPlausible(measured.check_files, measured.check, measured.machine));
  if (!arguments.plot.empty()) RETURN_IF_ERROR(MakeFolder(arguments.plot));
  ASSIGN_OR_RETURN(auto fit, identify::BindSessions(measured.machine, measured.fit));
  ASSIGN_OR_RETURN(auto check, identify::BindSessions(measured.machine, measured.check));
  decide::Options options;
  options.max_effects = arguments.max_effects;
  RETURN_IF_ERROR(AddSimulation(arguments, measured.machine, &options));
  ProgressBar bar = context.Bar("closing the loop");
  base::Mutex mutex;  // a simulation reports from every core
  options.progress = [&bar, &mutex](const identify::Progress& progress) {
    const base::MutexLock lock(mutex);
    bar.Show(progress.fraction, progress.detail);
  };
  ASSIGN_OR_RETURN(const loop::Report report, decide::CloseLoop(measured.machine, fit, check, options));
  const reports::Loop said = loop::ReportOf(measured.machine, report);
  const std::string json = reports::ToJson(said);
  RETURN_IF_ERROR(WriteOutputs(arguments, json,
                               machine::WriteErrors(report.fitted.model, measured.machine, report.fitted.covariance)));
  RETURN_IF_ERROR(WriteResiduals(arguments.residuals, measured.machine, check, report));
  if (!arguments.plot.empty())
    RETURN_IF_ERROR(WritePictures(arguments.plot, loop::Pictures(measured.machine, fit, check, report)));
  context.Print(Json::Document(json), LoopText(said) + MonteCarloText(said.fitted, false));
  return absl::OkStatus();
}

absl::Status CloseLoopOnService(Context& context, const CloseLoopArguments& arguments) {
  std::vector<NamedPath> inputs;
  if (context.server.empty()) inputs.push_back({"the database", context.database});
  RETURN_IF_ERROR(CheckPaths(arguments, inputs));
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  records::CloseLoopParams params;
  params.machine = MachineId(arguments.machine);
  params.max_effects = arguments.max_effects;
  params.monte_carlo_runs = arguments.monte_carlo;
  params.monte_carlo_seed = arguments.seed.value_or(params.monte_carlo_seed);
  ASSIGN_OR_RETURN(params.budget_json, BudgetText(arguments));
  ASSIGN_OR_RETURN(params.fit, NamedSessions(*client, params.machine, "--fit", arguments.fit));
  ASSIGN_OR_RETURN(params.check, NamedSessions(*client, params.machine, "--check", arguments.check));
  ASSIGN_OR_RETURN(const records::JobRecord job, client->CreateJob(params, arguments.request_id));
  if (arguments.no_wait) {
    context.Print(ToJson(job), absl::StrCat("job ", job.id.number(), " is queued; follow it with: axiscal jobs watch ",
                                            job.id.number(), "\n"));
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(const records::JobRecord done, FollowJob(context, *client, job.id));
  if (!done.calibration) return absl::InternalError(absl::StrCat("job ", job.id.number(), " made no calibration"));
  ASSIGN_OR_RETURN(const records::CalibrationRecord record, client->GetCalibration(*done.calibration));
  RETURN_IF_ERROR(WriteOutputs(arguments, done.result, record.content.model_json));
  ASSIGN_OR_RETURN(const reports::Loop report, reports::ReadLoop(done.result));
  const std::string text = LoopText(report) + MonteCarloText(report.fitted, false);
  Json json = Json::Document(done.result);
  json["job"] = done.id.number();
  json["calibration"] = record.id.number();
  context.Print(json, text);
  context.Note(absl::StrCat("calibration ", record.id.number(),
                            " holds the extended model; use it with: axiscal approve ", record.id.number()));
  return absl::OkStatus();
}

absl::Status CloseLoop(Context& context, const CloseLoopArguments& arguments) {
  RETURN_IF_ERROR(CheckSimulation(arguments));
  if (arguments.folder.empty() == arguments.machine.empty()) {
    return absl::InvalidArgumentError("close-loop: expected either a case folder or --machine");
  }
  const bool is_job = !arguments.machine.empty();
  if (!is_job && (!arguments.fit.empty() || !arguments.check.empty() || arguments.no_wait)) {
    return absl::InvalidArgumentError("close-loop: --fit, --check and --no-wait need --machine");
  }
  if (is_job && arguments.fit.empty()) return absl::InvalidArgumentError("close-loop: expected --fit with --machine");
  if (is_job && !arguments.plot.empty()) {
    return absl::InvalidArgumentError("close-loop: --plot needs a case folder: pictures are drawn from its readings");
  }
  if (is_job && !arguments.residuals.empty()) {
    return absl::InvalidArgumentError(
        "close-loop: --residuals needs a case folder: the sessions of the store are written to files by session get");
  }
  if (arguments.no_wait && !(arguments.report.empty() && arguments.errors.empty())) {
    return absl::InvalidArgumentError("close-loop: with --no-wait there is nothing yet for --report and --errors");
  }
  return is_job ? CloseLoopOnService(context, arguments) : CloseLoopOfFiles(context, arguments);
}

}  // namespace

void AddCloseLoopCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<CloseLoopArguments>();
  CLI::App* command = app.add_subcommand(
      "close-loop", "Find the effects that a machine's model lacks, in a case folder or in stored sessions");
  command->add_option("CASE", arguments->folder, "folder with machine.json, fit/*.csv and check/*.csv");
  command->add_option("--machine", arguments->machine, "a stored machine: the work is a job, its result a candidate");
  command->add_option("--fit", arguments->fit, "stored sessions to fit and search, by number or name")->delimiter(',');
  command->add_option("--check", arguments->check, "stored sessions to prove the effects on")->delimiter(',');
  command->add_option("--report", arguments->report, "write the full report (JSON) to this file");
  command->add_option("--errors", arguments->errors,
                      "write the extended model's errors (errors.json) to this file, for compensate");
  command->add_option("--residuals", arguments->residuals,
                      "write every reading with prediction, residual, weight and why it was set aside (CSV); of a case "
                      "folder only");
  command->add_option(
      "--plot", arguments->plot,
      "write pictures (SVG) into this folder: residuals against each variable and ball-bar traces, before "
      "and after, and the ranking of candidates; of a case folder only");
  command->add_option("--max-effects", arguments->max_effects, "stop after this many effects (none: after all)")
      ->check(CLI::Range(1, records::kMaxEffects));
  command
      ->add_option(
          "--monte-carlo", arguments->monte_carlo,
          "when the loop has ended, simulate the fit sessions under the extended model so often and report how "
          "errors and effects spread")
      ->check(CLI::Range(1, identify::kMaxMonteCarloRuns));
  command->add_option("--budget", arguments->budget, "error budget of the simulation, JSON: sources of error by name");
  command->add_option("--seed", arguments->seed, "seed of the simulation; the same seed gives the same report (1)");
  command->add_option("--request-id", arguments->request_id, "repeat under the same id to get the same job");
  command->add_flag("--no-wait", arguments->no_wait, "print the job and return at once");
  command->footer(
      "A case folder needs no database and no server. Both ways give the same report.\n"
      "Examples: axiscal close-loop tuesday/ --report report.json --plot pictures/\n"
      "          axiscal close-loop tuesday/ --errors errors.json && axiscal compensate --machine tuesday/machine.json "
      "--errors errors.json --tool-tip \"0 0 -350\" in.nc -o out.nc\n"
      "          axiscal close-loop --machine mt --fit BX,BY,CR --check BZ,CT");
  SetAction(command, context, [&context, arguments] { return CloseLoop(context, *arguments); });
}

}  // namespace axiscal::cli
