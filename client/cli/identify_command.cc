// axiscal identify
#include <CLI/CLI.hpp>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/error_model_source.h"
#include "client/cli/job_wait.h"
#include "client/cli/output_paths.h"
#include "client/cli/record_output.h"
#include "client/cli/session_choice.h"
#include "core/base/files.h"
#include "core/base/json_limits.h"
#include "core/base/units.h"
#include "core/identify/held.h"
#include "core/identify/identify.h"
#include "core/identify/monte_carlo.h"
#include "core/identify/residuals_csv.h"
#include "core/machine/error_json.h"
#include "core/machine/machine_json.h"

namespace axiscal::cli {
namespace {

struct IdentifyArguments {
  std::string machine, request_id;
  std::vector<std::string> sessions, declared;
  bool all = false, no_wait = false;
  std::string budget, model, hold, residuals;
  std::vector<std::string> hold_only;
  std::optional<int> monte_carlo;
  std::optional<uint64_t> seed;
};

absl::Status ReadSimulation(const IdentifyArguments& arguments, records::IdentifyParams* params) {
  params->monte_carlo_runs = arguments.monte_carlo;
  if (arguments.seed) {
    if (!arguments.monte_carlo) return absl::InvalidArgumentError("--seed: expected --monte-carlo with it");
    params->monte_carlo_seed = *arguments.seed;
  }
  if (arguments.budget.empty()) return absl::OkStatus();
  ASSIGN_OR_RETURN(params->budget_json, base::ReadFile(arguments.budget, base::kMaxJsonBytes));
  return absl::OkStatus();
}

// The errors of an errors.json as the job takes them: which, not how large.
absl::StatusOr<std::vector<std::string>> ErrorsOf(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string text, base::ReadFile(path, base::kMaxJsonBytes));
  auto errors = machine::ListErrors(text);
  if (!errors.ok()) return base::Within(path, errors.status());
  return errors;
}

// A number is a calibration; all else a file.
absl::Status ReadHeld(Context& context, const IdentifyArguments& arguments, records::IdentifyParams* params) {
  const std::string& hold = arguments.hold;
  if (hold.empty() && !arguments.hold_only.empty()) {
    return absl::InvalidArgumentError("--hold-only: expected --hold with it");
  }
  if (hold.empty()) return absl::OkStatus();
  int64_t id = 0;
  if (absl::SimpleAtoi(hold, &id)) {
    if (arguments.hold_only.empty()) {
      params->held_calibration = CalibrationId(id);
      return absl::OkStatus();
    }
    ASSIGN_OR_RETURN(client::Client * client, context.Connect());
    ASSIGN_OR_RETURN(const records::CalibrationRecord record, client->GetCalibration(CalibrationId(id)));
    ASSIGN_OR_RETURN(params->held_errors_json,
                     identify::OnlyConstants("--hold-only", arguments.hold_only, ToJson(record).Dump()));
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(params->held_errors_json, base::ReadFile(hold, base::kMaxJsonBytes));
  if (const absl::Status json = base::CheckJson(params->held_errors_json); !json.ok()) return base::Within(hold, json);
  if (arguments.hold_only.empty()) return absl::OkStatus();
  ASSIGN_OR_RETURN(params->held_errors_json,
                   identify::OnlyConstants("--hold-only", arguments.hold_only, params->held_errors_json));
  return absl::OkStatus();
}

absl::StatusOr<std::vector<SessionId>> ChooseSessions(client::Client& client, const IdentifyArguments& arguments) {
  if (arguments.all == !arguments.sessions.empty()) {
    return absl::InvalidArgumentError("identify: expected either --sessions or --all");
  }
  const MachineId machine(arguments.machine);
  if (!arguments.all) return NamedSessions(client, machine, "--sessions", arguments.sessions);
  ASSIGN_OR_RETURN(const std::vector<records::SessionRecord> stored, CompleteSessions(client, machine));
  if (stored.empty()) {
    return absl::NotFoundError(absl::StrCat("--all: machine ", arguments.machine, " has no complete session"));
  }
  std::vector<SessionId> chosen;
  for (const records::SessionRecord& record : stored) chosen.push_back(record.id);
  return chosen;
}

// The errors that the job's fit holds and those that it fits.
absl::Status ReadFittedErrors(client::Client& client, const machine::Machine& machine,
                              const records::IdentifyParams& params, identify::Options* options) {
  machine::ErrorModel asked;
  if (params.declared.empty()) asked = machine::DeclaredModel(machine);
  for (const std::string& error : params.declared) {
    ASSIGN_OR_RETURN(const machine::ErrorModel one, machine::ReadAskedError(error, machine));
    asked.terms.insert(asked.terms.end(), one.terms.begin(), one.terms.end());
  }
  options->model = asked;
  if (params.held_calibration) {
    ASSIGN_OR_RETURN(const records::CalibrationRecord held, client.GetCalibration(*params.held_calibration));
    ASSIGN_OR_RETURN(options->held_errors,
                     identify::ReadHeldErrors(held.content.model_json, held.content.report_json, machine));
  } else if (!params.held_errors_json.empty()) {
    ASSIGN_OR_RETURN(options->held_errors, identify::ReadHeldErrors(params.held_errors_json, machine));
  }
  if (!options->held_errors) return absl::OkStatus();
  ASSIGN_OR_RETURN(options->model,
                   identify::BesideHeld(machine, asked, !params.declared.empty(), *options->held_errors));
  return absl::OkStatus();
}

// The fit of a job that has ended, made again here from the stored sessions: what it left of every reading is not kept
// on the service. ABORTED where the report says otherwise, as a service of another version may.
absl::Status WriteIdentifyResiduals(client::Client& client, const records::IdentifyParams& params,
                                    const records::CalibrationRecord& made, const std::string& path) {
  ASSIGN_OR_RETURN(const records::MachineRecord record,
                   client.GetMachineRevision(params.machine, made.content.machine_revision));
  ASSIGN_OR_RETURN(const machine::Machine machine, machine::MachineFromJson(record.description_json));
  std::vector<session::Session> sessions;
  std::map<std::string, int> uses;
  for (const SessionId& id : params.sessions) {
    ASSIGN_OR_RETURN(sessions.emplace_back(), client.DownloadSession(id));
    ++uses[session::FindHeader(sessions.back(), "session").value_or("")];
  }
  for (size_t i = 0; i < sessions.size(); ++i) {  // as the job calls sessions that share a name
    for (session::HeaderEntry& entry : sessions[i].header) {
      if (entry.key == "session" && uses[entry.value] > 1)
        absl::StrAppend(&entry.value, "#", params.sessions[i].number());
    }
  }
  identify::Options options;
  RETURN_IF_ERROR(ReadFittedErrors(client, machine, params, &options));
  if (!params.budget_json.empty()) {
    ASSIGN_OR_RETURN(options.budget, identify::ReadBudget(params.budget_json, machine));
  }
  ASSIGN_OR_RETURN(const identify::Fit fit, identify::FitSessions(machine, sessions, options));
  const double rms_um = fit.result.fit.rms_mm * base::kUmPerMm, said_um = made.content.rms_after_um.value_or(rms_um);
  constexpr double kSame = 1e-6;  // of the rms: another order of summing
  if (std::abs(rms_um - said_um) > kSame * (said_um + kSame)) {
    return absl::AbortedError(
        absl::StrFormat("--residuals: the fit leaves %.6g um here and %.6g um on the service: is it "
                        "another version?",
                        rms_um, said_um));
  }
  return base::WriteFileAtomically(path, identify::ResidualsCsvHeader() + identify::ResidualsCsv("fit", fit));
}

absl::Status Identify(Context& context, const IdentifyArguments& arguments) {
  if (arguments.no_wait && !arguments.residuals.empty())
    return absl::InvalidArgumentError("identify: with --no-wait there is nothing yet for --residuals");
  std::vector<NamedPath> inputs = {
      {"--model", arguments.model}, {"--hold", arguments.hold}, {"--budget", arguments.budget}};
  if (context.server.empty()) inputs.push_back({"the database", context.database});
  RETURN_IF_ERROR(CheckOutputs(inputs, {{"--residuals", arguments.residuals}}));
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  records::IdentifyParams params;
  params.machine = MachineId(arguments.machine);
  params.declared = SplitErrors(arguments.declared);
  RETURN_IF_ERROR(ReadHeld(context, arguments, &params));
  if (!arguments.model.empty()) {
    ASSIGN_OR_RETURN(params.declared, ErrorsOf(arguments.model));
  }
  RETURN_IF_ERROR(ReadSimulation(arguments, &params));
  ASSIGN_OR_RETURN(params.sessions, ChooseSessions(*client, arguments));
  ASSIGN_OR_RETURN(const records::JobRecord job, client->CreateJob(params, arguments.request_id));
  if (arguments.no_wait) {
    context.Print(ToJson(job), absl::StrCat("job ", job.id.number(), " is queued; follow it with: axiscal jobs watch ",
                                            job.id.number(), "\n"));
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(const records::JobRecord done, FollowJob(context, *client, job.id));
  if (!done.calibration) return absl::InternalError(absl::StrCat("job ", job.id.number(), " made no calibration"));
  ASSIGN_OR_RETURN(const records::CalibrationRecord record, client->GetCalibration(*done.calibration));
  if (!arguments.residuals.empty())
    RETURN_IF_ERROR(WriteIdentifyResiduals(*client, params, record, arguments.residuals));
  context.Print(ToJson(record), CalibrationText(record));
  context.Note(absl::StrCat("use it with: axiscal approve ", record.id.number()));
  return absl::OkStatus();
}

}  // namespace

void AddIdentifyCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<IdentifyArguments>();
  CLI::App* identify =
      app.add_subcommand("identify", "Find a machine's errors from its sessions; makes a candidate calibration");
  identify->add_option("--machine", arguments->machine, "the machine")->required();
  identify->add_option("SESSIONS,--sessions", arguments->sessions, "sessions to use, by number or name")
      ->delimiter(',');
  identify->add_flag("--all", arguments->all, "use every complete session of the machine");
  CLI::Option* const declare = identify->add_option(
      "--declare", arguments->declared,
      "errors to identify, instead of the machine's declared ones: symbols, or terms of errors.json");
  identify
      ->add_option("--model", arguments->model,
                   "errors.json: the errors to identify, of any shape, maps too; its numbers are not used")
      ->excludes(declare);
  identify->add_option("--hold", arguments->hold,
                       "errors that are known and not fitted: a calibration's number, or a file (errors.json, or what "
                       "calibration show --json prints)");
  identify->add_option("--hold-only", arguments->hold_only, "of them only these constant errors")->delimiter(',');
  identify->add_option("--budget", arguments->budget, "error budget, JSON: sources of error that scatter the readings");
  identify
      ->add_option("--monte-carlo", arguments->monte_carlo, "simulate the sessions so often, report how errors spread")
      ->check(CLI::Range(1, identify::kMaxMonteCarloRuns));
  identify->add_option("--seed", arguments->seed, "seed of the simulation; the same seed gives the same report (1)");
  identify->add_option("--residuals", arguments->residuals,
                       "write every reading with prediction, residual, weight and why it was set aside (CSV)");
  identify->add_option("--request-id", arguments->request_id, "repeat under the same id to get the same job");
  identify->add_flag("--no-wait", arguments->no_wait, "print the job and return at once");
  identify->footer(
      "Errors are ISO 230-1 symbols (EX0C, EA0B, EZ0T). Each session's set-up (place of the sphere, run-out of the "
      "ball ...) is fitted\n"
      "beside them. What the sessions cannot tell is said so and gets no number.\n"
      "--hold keeps errors of an earlier calibration at their values (the head first, then the table); what is "
      "fitted carries their uncertainty\n"
      "too, and the new calibration holds both.\n"
      "--monte-carlo simulates them with all that --budget names, on all of the server's workers, and states the "
      "spread beside.\n"
      "Examples: axiscal identify --machine mt --all\n"
      "          axiscal identify --machine mt --all --budget sources.json --monte-carlo 1000\n"
      "          axiscal identify --machine mt --sessions BX,BY,CR --declare EA0B,EC0B,EX0C\n"
      "          axiscal identify --machine mt --sessions table --hold 1");
  SetAction(identify, context, [&context, arguments] { return Identify(context, *arguments); });
}

}  // namespace axiscal::cli
