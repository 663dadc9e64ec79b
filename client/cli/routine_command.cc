// axiscal routine put|list|runs|stop|resume|enable|disable|retry|remove
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "absl/strings/str_join.h"
#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/error_model_source.h"
#include "client/cli/record_output.h"
#include "core/base/files.h"
#include "core/base/json_limits.h"

namespace axiscal::cli {
namespace {

struct RoutineArguments {
  records::Routine routine;
  std::string machine, group, at, budget_file, page, note;
  bool closes_loop = false;
  std::optional<uint64_t> seed;
  int page_size = 0;
};

// "02:30": minutes of a day.
absl::StatusOr<int> ReadMinute(const std::string& text) {
  int hour = 0, minute = 0, read = 0;
  const bool is_time = std::sscanf(text.c_str(), "%2d:%2d%n", &hour, &minute, &read) == 2 &&
                       read == static_cast<int>(text.size()) && hour >= 0 && hour < 24 && minute >= 0 && minute < 60;
  if (!is_time) return absl::InvalidArgumentError("--at '" + text + "': expected HH:MM, UTC, as 02:30");
  return 60 * hour + minute;
}

std::string WhatText(const records::Routine& routine) {
  std::string text = absl::StrCat("when ", absl::StrJoin(routine.sessions, ", "));
  if (!routine.check_sessions.empty())
    absl::StrAppend(&text, " (and to prove on: ", absl::StrJoin(routine.check_sessions, ", "), ")");
  absl::StrAppend(&text,
                  routine.sessions.size() + routine.check_sessions.size() > 1 ? " were measured within " : " came",
                  routine.sessions.size() + routine.check_sessions.size() > 1 ? absl::StrCat(routine.within_hours, " h")
                                                                              : std::string());
  if (routine.at_utc_minute)
    absl::StrAppendFormat(&text, ", at %02d:%02d UTC", *routine.at_utc_minute / 60, *routine.at_utc_minute % 60);
  text += routine.work == records::RoutineWork::kFit ? ": identify" : ": close the loop";
  if (routine.approve_within_um) {
    absl::StrAppend(&text, "; approve what moves the tool point by at most ", *routine.approve_within_um, " um");
  } else {
    text += "; propose";
  }
  return text;
}

std::string RoutineText(const records::RoutineRecord& record) {
  const records::Routine& routine = record.content;
  std::string text =
      absl::StrCat("routine ", routine.name, routine.is_enabled ? "" : " (disabled)", " for ",
                   records::TextOf(routine.scope), " as ", routine.principal, ", said by ", record.changed_by, " at ",
                   TimeText(record.changed_at), " UTC (etag ", record.etag, ")\n  ", WhatText(routine), "\n");
  if (!routine.note.empty()) absl::StrAppend(&text, "  ", routine.note, "\n");
  for (const records::RoutineStop& stop : record.stops) {
    absl::StrAppend(&text, "  stopped on ", stop.machine.text(), " by ", stop.by, " at ", TimeText(stop.at), " UTC",
                    stop.note.empty() ? "" : ": " + stop.note, "\n");
  }
  return text;
}

Json RoutineJson(const records::RoutineRecord& record) {
  const records::Routine& routine = record.content;
  const auto names = [](const std::vector<std::string>& texts) {
    Json list = Json::Array();
    for (const std::string& text : texts) list.push_back(text);
    return list;
  };
  Json stops = Json::Array();
  for (const records::RoutineStop& stop : record.stops) {
    stops.push_back(
        {{"machine", stop.machine.text()}, {"by", stop.by}, {"note", stop.note}, {"at", TimeJson(stop.at)}});
  }
  const bool is_group = routine.scope.kind == records::Scope::Kind::kGroup;
  return {{"name", routine.name},
          {"machine", is_group ? Json() : Json(routine.scope.name)},
          {"group", is_group ? Json(routine.scope.name) : Json()},
          {"principal", routine.principal},
          {"sessions", names(routine.sessions)},
          {"check_sessions", names(routine.check_sessions)},
          {"within_hours", routine.within_hours},
          {"at_utc_minute", routine.at_utc_minute ? Json(*routine.at_utc_minute) : Json()},
          {"work", routine.work == records::RoutineWork::kFit ? "identify" : "close-loop"},
          {"declared", names(routine.declared)},
          {"max_effects", routine.max_effects ? Json(*routine.max_effects) : Json()},
          {"monte_carlo_runs", routine.monte_carlo_runs ? Json(*routine.monte_carlo_runs) : Json()},
          {"approve_within_um", NumberJson(routine.approve_within_um)},
          {"enabled", routine.is_enabled},
          {"note", routine.note},
          {"etag", record.etag},
          {"created_by", record.created_by},
          {"changed_by", record.changed_by},
          {"changed", TimeJson(record.changed_at)},
          {"stops", stops}};
}

Json ToJson(const records::RoutineRun& run) {
  const auto numbers = [](const std::vector<SessionId>& ids) {
    Json list = Json::Array();
    for (const SessionId id : ids) list.push_back(id.number());
    return list;
  };
  return {{"run", run.id.number()},
          {"routine", run.routine},
          {"routine_etag", run.routine_etag},
          {"machine", run.machine.text()},
          {"principal", run.principal},
          {"state", records::NameOf(run.state)},
          {"sessions", numbers(run.sessions)},
          {"check_sessions", numbers(run.check_sessions)},
          {"job", run.job ? Json(run.job->number()) : Json()},
          {"calibration", run.calibration ? Json(run.calibration->number()) : Json()},
          {"text", run.text},
          {"began", TimeJson(run.began_at)},
          {"ended", TimeJson(run.ended_at)}};
}

std::string RunText(const records::RoutineRun& run) {
  std::string text = absl::StrCat("run ", run.id.number(), " of ", run.routine, " on ", run.machine.text(), ", began ",
                                  TimeText(run.began_at), " UTC: ", records::NameOf(run.state));
  if (run.calibration) absl::StrAppend(&text, ", calibration ", run.calibration->number());
  if (run.job) absl::StrAppend(&text, ", job ", run.job->number());
  std::vector<int64_t> sessions;
  for (const auto* const list : {&run.sessions, &run.check_sessions})
    for (const SessionId id : *list) sessions.push_back(id.number());
  absl::StrAppend(&text, ", sessions ", absl::StrJoin(sessions, ","), "\n");
  if (!run.text.empty()) absl::StrAppend(&text, "  ", run.text, "\n");
  return text;
}

absl::Status PrintRoutine(Context& context, const absl::StatusOr<records::RoutineRecord>& record) {
  RETURN_IF_ERROR(record.status());
  context.Print(RoutineJson(*record), RoutineText(*record));
  return absl::OkStatus();
}

absl::Status Put(Context& context, RoutineArguments& arguments) {
  records::Routine& routine = arguments.routine;
  if (arguments.machine.empty() == arguments.group.empty())
    return absl::InvalidArgumentError("routine put: give either --machine or --group");
  routine.scope = arguments.group.empty() ? records::Scope{records::Scope::Kind::kMachine, arguments.machine}
                                          : records::Scope{records::Scope::Kind::kGroup, arguments.group};
  if (!arguments.at.empty()) {
    ASSIGN_OR_RETURN(routine.at_utc_minute, ReadMinute(arguments.at));
  }
  if (arguments.closes_loop) routine.work = records::RoutineWork::kLoop;
  routine.declared = SplitErrors(routine.declared);
  if (!arguments.budget_file.empty()) {
    ASSIGN_OR_RETURN(routine.budget_json, base::ReadFile(arguments.budget_file, base::kMaxJsonBytes));
  }
  if (arguments.seed) {
    if (!routine.monte_carlo_runs) return absl::InvalidArgumentError("--seed stands beside --monte-carlo");
    routine.monte_carlo_seed = *arguments.seed;
  }
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  return PrintRoutine(context, client->PutRoutine(routine));
}

absl::Status Enable(Context& context, const std::string& name, bool is_enabled) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const std::vector<records::RoutineRecord> routines, client->ListRoutines());
  for (const records::RoutineRecord& record : routines) {
    if (record.content.name != name) continue;
    records::Routine routine = record.content;
    routine.is_enabled = is_enabled;
    return PrintRoutine(context, client->PutRoutine(routine, record.etag));
  }
  return absl::NotFoundError("routine " + name + " does not exist");
}

absl::Status List(Context& context, const RoutineArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(
      const std::vector<records::RoutineRecord> routines,
      client->ListRoutines(arguments.machine.empty() ? std::nullopt : std::optional(MachineId(arguments.machine))));
  Json list = Json::Array();
  std::string text;
  for (const records::RoutineRecord& record : routines) {
    list.push_back(RoutineJson(record));
    text += RoutineText(record);
  }
  context.Print({{"routines", list}}, text.empty() ? "no routines\n" : text);
  return absl::OkStatus();
}

absl::Status ListRuns(Context& context, const RoutineArguments& arguments) {
  records::RunFilter filter;
  if (!arguments.machine.empty()) filter.machine = MachineId(arguments.machine);
  filter.routine = arguments.routine.name;
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const auto page, client->ListRoutineRuns(filter, {arguments.page_size, arguments.page}));
  Json runs = Json::Array();
  std::string text;
  for (const records::RoutineRun& run : page.rows) {
    runs.push_back(ToJson(run));
    text += RunText(run);
  }
  context.Print({{"runs", runs}, {"next_page", page.next_token}},
                (text.empty() ? "it has not run yet\n" : text) + PageText(page));
  return absl::OkStatus();
}

absl::Status Stop(Context& context, const RoutineArguments& arguments, bool stopped) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  return PrintRoutine(
      context, client->StopRoutine(arguments.routine.name, MachineId(arguments.machine), stopped, arguments.note));
}

absl::Status Retry(Context& context, const RoutineArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::RoutineRun run,
                   client->RetryRoutine(arguments.routine.name, MachineId(arguments.machine)));
  context.Print(ToJson(run), RunText(run));
  return absl::OkStatus();
}

absl::Status Remove(Context& context, const std::string& name) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::RoutineRecord record, client->RemoveRoutine(name));
  context.Print(RoutineJson(record), "routine " + name + " is removed\n");
  return absl::OkStatus();
}

void AddPut(CLI::App& routine, Context& context) {
  auto arguments = std::make_shared<RoutineArguments>();
  records::Routine& said = arguments->routine;
  CLI::App* put = routine.add_subcommand("put", "Make a routine, or replace the one of that name");
  put->add_option("NAME", said.name, "its name")->required();
  put->add_option("--machine", arguments->machine, "for this machine");
  put->add_option("--group", arguments->group, "for the machines of this group");
  put->add_option("--as", said.principal, "the principal that it acts as, with that one's roles")->required();
  put->add_option("--sessions", said.sessions, "names of the sessions to fit (BX,CX)")->required()->delimiter(',');
  put->add_option("--within-hours", said.within_hours, "a set is measured within so long");
  put->add_option("--at", arguments->at, "wait for this time of a UTC day (02:30); else it begins at once");
  put->add_option("--declare", said.declared, "errors to fit, as of identify");
  put->add_flag("--close-loop", arguments->closes_loop, "close the loop in place of identifying");
  put->add_option("--check-sessions", said.check_sessions, "with --close-loop: names of sessions to prove on")
      ->delimiter(',');
  put->add_option("--max-effects", said.max_effects, "with --close-loop: stop after so many effects");
  put->add_option("--budget", arguments->budget_file, "error budget, a JSON file");
  put->add_option("--monte-carlo", said.monte_carlo_runs, "simulate the errors so often");
  put->add_option("--seed", arguments->seed, "of the simulation");
  put->add_option("--approve-within-um", said.approve_within_um,
                  "approve what moves the tool point by at most so much, where nothing else speaks against it; else "
                  "propose");
  put->add_option("--note", said.note, "for people");
  put->footer(
      "Example: axiscal routine put nightly --machine mt --as night --sessions BX,CX --within-hours 12\n"
      "The principal is made before: axiscal admin principal add night; axiscal admin role add night technician "
      "--machine mt\n"
      "What follows: docs/routines.md.");
  SetAction(put, context, [&context, arguments] { return Put(context, *arguments); });
}

}  // namespace

void AddRoutineCommand(CLI::App& app, Context& context) {
  CLI::App* routine = app.add_subcommand(
      "routine", "What runs by itself when sessions have come: identify or close the loop, then propose or approve");
  routine->require_subcommand(1);
  AddPut(*routine, context);
  auto arguments = std::make_shared<RoutineArguments>();
  const auto named = [&](const char* name, const char* help, bool on_machine,
                         const std::function<absl::Status()>& action) {
    CLI::App* command = routine->add_subcommand(name, help);
    command->add_option("NAME", arguments->routine.name, "the routine")->required();
    if (on_machine) command->add_option("--machine", arguments->machine, "on this machine")->required();
    SetAction(command, context, action);
    return command;
  };

  CLI::App* list = routine->add_subcommand("list", "List routines");
  list->add_option("--machine", arguments->machine, "that work for this machine");
  SetAction(list, context, [&context, arguments] { return List(context, *arguments); });

  CLI::App* runs = routine->add_subcommand("runs", "What became of each time that routines ran, newest first");
  runs->add_option("NAME", arguments->routine.name, "of this routine");
  runs->add_option("--machine", arguments->machine, "on this machine");
  runs->add_option("--page-size", arguments->page_size, "runs per page (1 to 1000)")->check(CLI::Range(1, 1000));
  runs->add_option("--page", arguments->page, "token of the next page");
  SetAction(runs, context, [&context, arguments] { return ListRuns(context, *arguments); });

  named("stop", "Stop a routine on one machine, what it runs there too", true, [&context, arguments] {
    return Stop(context, *arguments, true);
  })->add_option("--note", arguments->note, "why, in your words");
  named("resume", "Let a routine go on on a machine", true,
        [&context, arguments] { return Stop(context, *arguments, false); });
  named("retry", "Run it again on the sessions of its newest run, which failed or was stopped", true,
        [&context, arguments] { return Retry(context, *arguments); });
  named("disable", "It is kept and begins nothing on any machine", false,
        [&context, arguments] { return Enable(context, arguments->routine.name, false); });
  named("enable", "It works again, on sessions that come from now on", false,
        [&context, arguments] { return Enable(context, arguments->routine.name, true); });
  named("remove", "End a routine; its runs stay", false,
        [&context, arguments] { return Remove(context, arguments->routine.name); });
}

}  // namespace axiscal::cli
