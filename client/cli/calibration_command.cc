// axiscal calibration list|show|retire
#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/positive_number.h"
#include "client/cli/record_output.h"

namespace axiscal::cli {
namespace {

struct CalibrationArguments {
  std::string machine, page, approved_of, reason, state, from, to;
  int page_size = 0;
  int64_t id = 0, etag = 0, session = 0;
};

const std::vector<std::pair<std::string, records::CalibrationState>> kCalibrationStates = {
    {"candidate", records::CalibrationState::kCandidate},
    {"approved", records::CalibrationState::kApproved},
    {"retired", records::CalibrationState::kRetired}};

absl::Status List(Context& context, const CalibrationArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  records::CalibrationFilter filter;
  if (!arguments.machine.empty()) filter.machine = MachineId(arguments.machine);
  for (const auto& [name, state] : kCalibrationStates) {
    if (name == arguments.state) filter.state = state;
  }
  if (arguments.session != 0) filter.session = SessionId(arguments.session);
  ASSIGN_OR_RETURN(filter.measured, ParseSpan(arguments.from, arguments.to));
  ASSIGN_OR_RETURN(const auto page, client->ListCalibrations(filter, {arguments.page_size, arguments.page}));
  std::vector<std::vector<std::string>> rows = {{"id", "machine", "version", "state", "rms before um", "rms after um",
                                                 "made (UTC)", "approved by", "rejected sessions"}};
  for (const records::CalibrationRecord& record : page.rows) {
    rows.push_back({absl::StrCat(record.id.number()), record.content.machine.text(), absl::StrCat(record.version),
                    StateName(record.state), NumberText(record.content.rms_before_um),
                    NumberText(record.content.rms_after_um), TimeText(record.created_at), record.approved_by,
                    RejectedText(record)});
  }
  context.Print(PageJson("calibrations", page), Table(rows) + PageText(page));
  return absl::OkStatus();
}

absl::Status Show(Context& context, const CalibrationArguments& arguments) {
  if (arguments.approved_of.empty() == (arguments.id == 0)) {
    return absl::InvalidArgumentError("calibration show: expected either a number or --approved MACHINE");
  }
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::CalibrationRecord record,
                   arguments.id != 0 ? client->GetCalibration(CalibrationId(arguments.id))
                                     : client->GetApprovedCalibration(MachineId(arguments.approved_of)));
  context.Print(ToJson(record), CalibrationText(record));
  return absl::OkStatus();
}

absl::Status Retire(Context& context, const CalibrationArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  const CalibrationId id(arguments.id);
  ASSIGN_OR_RETURN(const records::CalibrationRecord present, client->GetCalibration(id));
  const int64_t etag = arguments.etag != 0 ? arguments.etag : present.etag;
  ASSIGN_OR_RETURN(const records::CalibrationRecord record, client->RetireCalibration(id, etag, arguments.reason));
  const bool was_in_use = present.state == records::CalibrationState::kApproved;
  context.Print(
      ToJson(record),
      absl::StrCat("calibration ", record.id.number(), " (version ", record.version, ") of machine ",
                   record.content.machine.text(), " is retired",
                   was_in_use ? "; nothing of this machine is corrected until another one is approved" : "", "\n"));
  return absl::OkStatus();
}

}  // namespace

void AddCalibrationCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<CalibrationArguments>();
  CLI::App* calibration = app.add_subcommand("calibration", "What was identified: list, show, retire");
  calibration->require_subcommand(1);

  CLI::App* list = calibration->add_subcommand("list", "List calibrations, newest first");
  list->add_option("--machine", arguments->machine, "of this machine only");
  std::vector<std::string> states;
  for (const auto& [name, state] : kCalibrationStates) states.push_back(name);
  list->add_option("--state", arguments->state, "in this state only")->check(CLI::IsMember(states));
  list->add_option("--session", arguments->session, "that stand on this session only")->check(PositiveNumber());
  list->add_option("--from", arguments->from, "measured at or after this UTC time (2026-05-31 or 2026-05-31T14:03:07)");
  list->add_option("--to", arguments->to, "measured before this UTC time");
  list->add_option("--page-size", arguments->page_size, "calibrations per page (1 to 1000)")
      ->check(CLI::Range(1, 1000));
  list->add_option("--page", arguments->page, "token of the next page");
  SetAction(list, context, [&context, arguments] { return List(context, *arguments); });

  CLI::App* show = calibration->add_subcommand(
      "show", "Errors with uncertainties, what the data could not tell, rms before and after");
  show->add_option("ID", arguments->id, "its number")->check(PositiveNumber());
  show->add_option("--approved", arguments->approved_of, "the one in use on this machine");
  show->footer(
      "With --json also the model, the whole report (correlations, set-ups, outliers) and where it comes from.");
  SetAction(show, context, [&context, arguments] { return Show(context, *arguments); });

  CLI::App* retire = calibration->add_subcommand("retire", "Take a calibration out of use, or give a candidate up");
  retire->add_option("ID", arguments->id, "its number")->required()->check(PositiveNumber());
  retire->add_option("--etag", arguments->etag, "refuse when it changed since this etag was read")
      ->check(PositiveNumber());
  retire->add_option("--reason", arguments->reason, "why, for the audit");
  retire->footer(
      "It stays readable, and approve puts it back in use.\n"
      "Example: axiscal calibration retire 4 --reason \"the ball was loose\"");
  SetAction(retire, context, [&context, arguments] { return Retire(context, *arguments); });
}

}  // namespace axiscal::cli
