// axiscal session list|get
#include <CLI/CLI.hpp>
#include <memory>

#include "absl/strings/str_join.h"
#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/output_paths.h"
#include "client/cli/positive_number.h"
#include "client/cli/record_output.h"
#include "core/session/write_session.h"

namespace axiscal::cli {
namespace {

struct SessionArguments {
  std::string machine, page, output, instrument, name, from, to, label, note;
  std::vector<std::string> labels;
  int page_size = 0;
  int64_t id = 0;
};

std::string RemarkText(const records::SessionRecord& record) {
  if (!record.remark) return "";
  const records::SessionRemark& remark = *record.remark;
  std::vector<std::string> parts;
  if (remark.is_rejected) parts.push_back("REJECTED: " + remark.reason);
  if (!remark.labels.empty()) parts.push_back("[" + absl::StrJoin(remark.labels, " ") + "]");
  if (!remark.note.empty()) parts.push_back(remark.note);
  return absl::StrJoin(parts, "; ");
}

absl::Status Annotate(Context& context, const SessionArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::SessionRecord record,
                   client->AnnotateSession(SessionId(arguments.id), arguments.note, arguments.labels));
  context.Print(cli::ToJson(record), absl::StrCat("session ", arguments.id, ": ", RemarkText(record), "\n"));
  return absl::OkStatus();
}

absl::Status Reject(Context& context, const SessionArguments& arguments, bool is_rejected) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const client::Client::RejectedSession rejected,
                   client->RejectSession(SessionId(arguments.id), is_rejected, arguments.note));
  Json document = cli::ToJson(rejected.session);
  Json calibrations = Json::Array();
  std::string text = absl::StrCat("session ", arguments.id, is_rejected ? " is rejected\n" : " counts again\n");
  for (const CalibrationId& id : rejected.calibrations) {
    calibrations.push_back(id.number());
    absl::StrAppend(&text, "  calibration ", id.number(), " stands on it",
                    is_rejected ? ": it cannot be approved, and counts in no history\n" : "\n");
  }
  document["calibrations"] = calibrations;
  context.Print(document, text);
  return absl::OkStatus();
}

absl::Status List(Context& context, const SessionArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  client::SessionFilter filter;
  if (!arguments.machine.empty()) filter.machine = MachineId(arguments.machine);
  filter.instrument = arguments.instrument;
  filter.name = arguments.name;
  filter.label = arguments.label;
  ASSIGN_OR_RETURN(filter.measured, ParseSpan(arguments.from, arguments.to));
  ASSIGN_OR_RETURN(const auto page, client->ListSessions(filter, {arguments.page_size, arguments.page}));
  std::vector<std::vector<std::string>> rows = {
      {"id", "machine", "session", "instrument", "readings", "state", "measured (UTC)", "stored (UTC)", "remark"}};
  for (const records::SessionRecord& record : page.rows) {
    rows.push_back({absl::StrCat(record.id.number()), record.machine.text(), record.name, record.instrument,
                    absl::StrCat(record.reading_count), StateName(record.state), TimeText(record.measured_at),
                    TimeText(record.created_at), RemarkText(record)});
  }
  context.Print(PageJson("sessions", page), Table(rows) + PageText(page));
  return absl::OkStatus();
}

absl::Status Get(Context& context, const SessionArguments& arguments) {
  if (context.server.empty())
    RETURN_IF_ERROR(CheckOutputs({{"the database", context.database}}, {{"--output", arguments.output}}));
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const session::Session session, client->DownloadSession(SessionId(arguments.id)));
  RETURN_IF_ERROR(session::WriteSessionFile(session, arguments.output));
  context.Print(
      {{"id", arguments.id}, {"readings", session.reading_count()}, {"file", arguments.output}},
      absl::StrCat("session ", arguments.id, ": ", session.reading_count(), " readings in ", arguments.output, "\n"));
  return absl::OkStatus();
}

}  // namespace

void AddSessionCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<SessionArguments>();
  CLI::App* session = app.add_subcommand("session", "Stored measuring sessions: list, get, annotate, reject");
  session->require_subcommand(1);

  CLI::App* list = session->add_subcommand("list", "List sessions, newest first");
  list->add_option("--machine", arguments->machine, "of this machine only");
  list->add_option("--instrument", arguments->instrument, "of this instrument only (ballbar, touch ...)");
  list->add_option("--name", arguments->name, "of this name only");
  list->add_option("--label", arguments->label, "with this label only");
  list->add_option("--from", arguments->from, "measured at or after this UTC time (2026-05-31 or 2026-05-31T14:03:07)");
  list->add_option("--to", arguments->to,
                   "measured before this UTC time; where a file does not say when, it came then");
  list->add_option("--page-size", arguments->page_size, "sessions per page (1 to 1000)")->check(CLI::Range(1, 1000));
  list->add_option("--page", arguments->page, "token of the next page");
  SetAction(list, context, [&context, arguments] { return List(context, *arguments); });

  CLI::App* get = session->add_subcommand("get", "Write a stored session to a file");
  get->add_option("ID", arguments->id, "number of the session")->required()->check(PositiveNumber());
  get->add_option("-o,--output", arguments->output, "the file")->required();
  SetAction(get, context, [&context, arguments] { return Get(context, *arguments); });

  CLI::App* annotate = session->add_subcommand("annotate", "Say something of a session: replaces its note and labels");
  annotate->add_option("ID", arguments->id, "number of the session")->required()->check(PositiveNumber());
  annotate->add_option("--note", arguments->note, "in your words; without it there is none");
  annotate->add_option("--label", arguments->labels, "a short word that lists may be held to; as often as needed");
  SetAction(annotate, context, [&context, arguments] { return Annotate(context, *arguments); });

  for (const bool is_rejected : {true, false}) {
    CLI::App* command =
        session->add_subcommand(is_rejected ? "reject" : "accept",
                                is_rejected ? "Say that a session does not count; what stands on it is marked"
                                            : "Say that a session which was rejected counts again");
    command->add_option("ID", arguments->id, "number of the session")->required()->check(PositiveNumber());
    command->add_option("--note", arguments->note, "why")->required();
    SetAction(command, context,
              [&context, arguments, is_rejected] { return Reject(context, *arguments, is_rejected); });
  }
}

}  // namespace axiscal::cli
