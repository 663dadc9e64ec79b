// axiscal jobs list|watch|cancel|requeue
#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/job_wait.h"
#include "client/cli/positive_number.h"
#include "client/cli/record_output.h"

namespace axiscal::cli {
namespace {

struct JobsArguments {
  std::string machine, state, page, kind, from, to;
  int page_size = 0;
  int64_t id = 0;
};

const std::vector<std::pair<std::string, records::JobState>> kStates = {
    {"queued", records::JobState::kQueued},       {"running", records::JobState::kRunning},
    {"succeeded", records::JobState::kSucceeded}, {"failed", records::JobState::kFailed},
    {"cancelled", records::JobState::kCancelled}, {"dead", records::JobState::kDead}};

std::string JobText(const records::JobRecord& record) {
  std::string text = absl::StrCat("job ", record.id.number(), ": ", record.kind, ", ", StateName(record.state));
  if (!record.progress.stage.empty() && !records::IsTerminal(record.state)) {
    absl::StrAppend(&text, absl::StrFormat(", %s %.0f %%", record.progress.stage, 100 * record.progress.fraction));
  }
  if (record.calibration) absl::StrAppend(&text, ", made calibration ", record.calibration->number());
  for (const ProgramId& id : record.programs) absl::StrAppend(&text, ", made program ", id.number());
  return text + "\n";
}

// A table's cell; `jobs watch` and --json give the whole text.
std::string Short(const std::string& text) {
  constexpr size_t kShown = 50;
  return text.size() <= kShown ? text : text.substr(0, kShown - 3) + "...";
}

absl::Status List(Context& context, const JobsArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  client::JobFilter filter;
  if (!arguments.machine.empty()) filter.machine = MachineId(arguments.machine);
  for (const auto& [name, state] : kStates) {
    if (name == arguments.state) filter.state = state;
  }
  filter.kind = arguments.kind;
  ASSIGN_OR_RETURN(filter.created, ParseSpan(arguments.from, arguments.to));
  ASSIGN_OR_RETURN(const auto page, client->ListJobs(filter, {arguments.page_size, arguments.page}));
  std::vector<std::vector<std::string>> rows = {
      {"id", "kind", "machine", "state", "done", "stage", "created (UTC)", "by"}};
  for (const records::JobRecord& record : page.rows) {
    rows.push_back({absl::StrCat(record.id.number()), record.kind, record.machine ? record.machine->text() : "-",
                    StateName(record.state), absl::StrFormat("%.0f %%", 100 * record.progress.fraction),
                    record.error ? Short(record.error->message) : record.progress.stage, TimeText(record.created_at),
                    record.created_by});
  }
  context.Print(PageJson("jobs", page), Table(rows) + PageText(page));
  return absl::OkStatus();
}

absl::Status Watch(Context& context, const JobsArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ProgressBar bar = context.Bar(absl::StrCat("job ", arguments.id));
  ASSIGN_OR_RETURN(const records::JobRecord record,
                   client->WatchJob(JobId(arguments.id), [&bar](const records::JobRecord& now) {
                     bar.Show(now.progress.fraction, absl::StrCat(now.progress.stage, " ", now.progress.detail));
                     return true;
                   }));
  context.Print(ToJson(record), JobText(record));
  return OutcomeOf(record);
}

absl::Status Cancel(Context& context, const JobsArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::JobRecord record, client->CancelJob(JobId(arguments.id)));
  const bool still_runs = !records::IsTerminal(record.state);
  context.Print(ToJson(record),
                still_runs ? absl::StrCat("job ", arguments.id, " stops at its next step\n") : JobText(record));
  return absl::OkStatus();
}

absl::Status Requeue(Context& context, const JobsArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::JobRecord record, client->RequeueJob(JobId(arguments.id)));
  context.Print(ToJson(record), JobText(record));
  return absl::OkStatus();
}

}  // namespace

void AddJobsCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<JobsArguments>();
  CLI::App* jobs = app.add_subcommand("jobs", "Long work: list, watch, cancel, requeue");
  jobs->require_subcommand(1);

  CLI::App* list = jobs->add_subcommand("list", "List jobs, newest first");
  std::vector<std::string> names;
  for (const auto& [name, state] : kStates) names.push_back(name);
  list->add_option("--machine", arguments->machine, "of this machine only");
  list->add_option("--state", arguments->state, "in this state only")->check(CLI::IsMember(names));
  list->add_option("--kind", arguments->kind, "of this kind only")
      ->check(CLI::IsMember({records::kIdentify, records::kCloseLoop, records::kCompensate, records::kToolSetter}));
  list->add_option("--from", arguments->from, "created at or after this UTC time (2026-05-31 or 2026-05-31T14:03:07)");
  list->add_option("--to", arguments->to, "created before this UTC time");
  list->add_option("--page-size", arguments->page_size, "jobs per page (1 to 1000)")->check(CLI::Range(1, 1000));
  list->add_option("--page", arguments->page, "token of the next page");
  SetAction(list, context, [&context, arguments] { return List(context, *arguments); });

  const auto add = [&](const std::string& name, const std::string& help, auto run) {
    CLI::App* command = jobs->add_subcommand(name, help);
    command->add_option("JOB", arguments->id, "its number")->required()->check(PositiveNumber());
    SetAction(command, context, [&context, arguments, run] { return run(context, *arguments); });
  };
  add("watch", "Follow a job to its end; the exit code is the job's outcome", Watch);
  add("cancel", "Ask a job to stop", Cancel);
  add("requeue", "Run a failed or dead job once more", Requeue);
}

}  // namespace axiscal::cli
