// axiscal events, events ack|shelve
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/positive_number.h"
#include "client/cli/record_output.h"

namespace axiscal::cli {
namespace {

struct EventsArguments {
  std::string machine, page, note, until;
  bool follows = false, is_open_only = false, is_back = false;
  std::optional<int64_t> after;
  int page_size = 0;
  int64_t id = 0;
};

std::optional<MachineId> MachineOf(const EventsArguments& arguments) {
  if (arguments.machine.empty()) return std::nullopt;
  return MachineId(arguments.machine);
}

absl::Status List(Context& context, const EventsArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const auto page, client->ListEvents({MachineOf(arguments), arguments.is_open_only},
                                                       {arguments.page_size, arguments.page}));
  std::string text;
  for (const records::Event& event : page.rows) absl::StrAppend(&text, EventText(event));
  if (page.rows.empty()) text = "no events\n";
  context.Print(PageJson("events", page), text + PageText(page));
  return absl::OkStatus();
}

// A line for each change; with --json one document a line. Whoever reads it keeps the number of the last whole line,
// and goes on with --after.
absl::Status Follow(Context& context, const EventsArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  absl::Status written;
  RETURN_IF_ERROR(client->WatchEvents(MachineOf(arguments), arguments.after, [&](const records::EventNews& news) {
    if (!news.change) return true;
    const std::string line = context.json ? ToJson(*news.change).Line() + "\n" : ChangeText(*news.change);
    const bool is_out = std::fwrite(line.data(), 1, line.size(), stdout) == line.size() && std::fflush(stdout) == 0;
    if (!is_out) written = absl::UnavailableError("standard output takes nothing more");
    return is_out;
  }));
  return written;
}

absl::Status Acknowledge(Context& context, const EventsArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::Event event, client->AcknowledgeEvent(EventId(arguments.id), arguments.note));
  context.Print(ToJson(event), EventText(event));
  return absl::OkStatus();
}

absl::Status Shelve(Context& context, const EventsArguments& arguments) {
  std::optional<base::UtcTime> until;
  if (arguments.until.empty() != arguments.is_back)
    return absl::InvalidArgumentError("events shelve: give either --until or --back");
  if (!arguments.is_back) {
    ASSIGN_OR_RETURN(until, ParseTime("--until", arguments.until));
  }
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::Event event, client->ShelveEvent(EventId(arguments.id), until, arguments.note));
  context.Print(ToJson(event), EventText(event));
  return absl::OkStatus();
}

}  // namespace

void AddEventsCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<EventsArguments>();
  CLI::App* events = app.add_subcommand(
      "events", "What people should hear of: out of tolerance, steps, forecasts, sessions that were missed ...");
  events->require_subcommand(0, 1);
  events->add_option("--machine", arguments->machine, "of this machine only");
  events->add_flag("--open", arguments->is_open_only, "only those that are not cleared");
  events->add_option("--page-size", arguments->page_size, "events per page (1 to 1000)")->check(CLI::Range(1, 1000));
  events->add_option("--page", arguments->page, "token of the next page");
  CLI::Option* follow = events->add_flag("--follow", arguments->follows,
                                         "print each change as it happens, over restarts of the server, until stopped");
  events
      ->add_option("--after", arguments->after,
                   "with --follow: those after this change (0: from the beginning); else what happens from now on")
      ->needs(follow)
      ->check(CLI::NonNegativeNumber);
  events->footer(
      "Examples:\n  axiscal events --open\n  axiscal events --follow --after 0 --json\n"
      "  axiscal events ack 7 --note \"the chuck was hit, service comes on Monday\"\nWhat each kind means: "
      "docs/events.md.");
  SetAction(events, context, [&context, arguments, events] {
    if (!events->get_subcommands().empty()) return context.status;  // it has acted
    return arguments->follows ? Follow(context, *arguments) : List(context, *arguments);
  });

  CLI::App* ack = events->add_subcommand("ack", "Say that you have seen it, and a word");
  ack->add_option("EVENT", arguments->id, "its number")->required()->check(PositiveNumber());
  ack->add_option("--note", arguments->note, "your word")->required();
  SetAction(ack, context, [&context, arguments] { return Acknowledge(context, *arguments); });

  CLI::App* shelve = events->add_subcommand("shelve", "Nobody needs to hear of it until a time");
  shelve->add_option("EVENT", arguments->id, "its number")->required()->check(PositiveNumber());
  shelve->add_option("--until", arguments->until, "UTC (2026-05-12 or 2026-05-12T14:00:00), within a year");
  shelve->add_flag("--back", arguments->is_back, "it is back at once");
  shelve->add_option("--note", arguments->note, "in your words");
  SetAction(shelve, context, [&context, arguments] { return Shelve(context, *arguments); });
}

}  // namespace axiscal::cli
