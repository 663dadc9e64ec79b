// axiscal identify
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/job_wait.h"
#include "client/cli/record_output.h"

namespace axiscal::cli {
namespace {

struct Arguments {
  std::string machine, request_id;
  std::vector<std::string> sessions, declared;
  bool all = false, no_wait = false;
};

absl::StatusOr<std::vector<storage::SessionRecord>> CompleteSessions(client::Client& client,
                                                                     const std::string& machine) {
  std::vector<storage::SessionRecord> sessions;
  client::SessionFilter filter{MachineId(machine), storage::SessionState::kComplete};
  storage::PageRequest request{1000, ""};
  do {
    ASSIGN_OR_RETURN(const auto page, client.ListSessions(filter, request));
    sessions.insert(sessions.end(), page.rows.begin(), page.rows.end());
    request.token = page.next_token;
  } while (!request.token.empty());
  std::reverse(sessions.begin(), sessions.end());  // in the order in which they were stored
  return sessions;
}

bool IsNumber(const std::string& text) {
  return text.size() <= 18 &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

// A number is an id; anything else the name of exactly one stored session.
absl::StatusOr<SessionId> Resolve(const std::string& text, const std::string& machine,
                                  const std::vector<storage::SessionRecord>& stored) {
  if (IsNumber(text)) return SessionId(std::stoll(text));
  std::string ids;
  SessionId found;
  int count = 0;
  for (const storage::SessionRecord& record : stored) {
    if (record.name != text) continue;
    found = record.id;
    absl::StrAppend(&ids, count++ == 0 ? "" : ", ", record.id.number());
  }
  if (count == 1) return found;
  if (count == 0) {
    return absl::NotFoundError(absl::StrCat("--sessions: machine ", machine, " has no complete session '", text, "'"));
  }
  return absl::InvalidArgumentError(absl::StrCat("--sessions: ", count, " sessions of machine ", machine,
                                                 " are called '", text, "', give the number: one of ", ids));
}

absl::StatusOr<std::vector<SessionId>> ChooseSessions(client::Client& client, const Arguments& arguments) {
  if (arguments.all == !arguments.sessions.empty()) {
    return absl::InvalidArgumentError("identify: expected either --sessions or --all");
  }
  std::vector<SessionId> chosen;
  const bool only_numbers =
      !arguments.all && std::all_of(arguments.sessions.begin(), arguments.sessions.end(), IsNumber);
  std::vector<storage::SessionRecord> stored;
  if (!only_numbers) {
    ASSIGN_OR_RETURN(stored, CompleteSessions(client, arguments.machine));
  }
  if (arguments.all && stored.empty()) {
    return absl::NotFoundError(absl::StrCat("--all: machine ", arguments.machine, " has no complete session"));
  }
  for (const storage::SessionRecord& record : stored) {
    if (arguments.all) chosen.push_back(record.id);
  }
  for (const std::string& text : arguments.sessions) {
    ASSIGN_OR_RETURN(const SessionId id, Resolve(text, arguments.machine, stored));
    chosen.push_back(id);
  }
  return chosen;
}

absl::Status Identify(Context& context, const Arguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  convert::IdentifyParams params;
  params.machine = MachineId(arguments.machine);
  params.declared = arguments.declared;
  ASSIGN_OR_RETURN(params.sessions, ChooseSessions(*client, arguments));
  ASSIGN_OR_RETURN(const storage::JobRecord job, client->CreateJob(params, arguments.request_id));
  if (arguments.no_wait) {
    context.Print(ToJson(job), absl::StrCat("job ", job.id.number(), " is queued; follow it with: axiscal jobs watch ",
                                            job.id.number(), "\n"));
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(const storage::JobRecord done, FollowJob(context, *client, job.id));
  if (!done.calibration) return absl::InternalError(absl::StrCat("job ", job.id.number(), " made no calibration"));
  ASSIGN_OR_RETURN(const storage::CalibrationRecord record, client->GetCalibration(*done.calibration));
  context.Print(ToJson(record), CalibrationText(record));
  context.Note(absl::StrCat("use it with: axiscal approve ", record.id.number()));
  return absl::OkStatus();
}

}  // namespace

void AddIdentifyCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* identify =
      app.add_subcommand("identify", "Find a machine's errors from its sessions; makes a candidate calibration");
  identify->add_option("--machine", arguments->machine, "the machine")->required();
  identify->add_option("--sessions", arguments->sessions, "sessions to use, by number or name")->delimiter(',');
  identify->add_flag("--all", arguments->all, "use every complete session of the machine");
  identify->add_option("--declare", arguments->declared, "errors to identify, instead of the machine's declared ones")
      ->delimiter(',');
  identify->add_option("--request-id", arguments->request_id, "repeat under the same id to get the same job");
  identify->add_flag("--no-wait", arguments->no_wait, "print the job and return at once");
  identify->footer(
      "Errors are ISO 230-1 symbols (EX0C, EA0B, EZ0T). Each session's set-up (place of the sphere, run-out of the "
      "ball ...) is fitted\n"
      "beside them. What the sessions cannot tell is said so and gets no number.\n"
      "Examples: axiscal identify --machine mt --all\n"
      "          axiscal identify --machine mt --sessions BX,BY,CR --declare EA0B,EC0B,EX0C");
  SetAction(identify, context, [&context, arguments] { return Identify(context, *arguments); });
}

}  // namespace axiscal::cli
