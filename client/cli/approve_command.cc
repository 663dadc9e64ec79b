// axiscal approve
#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/positive_number.h"
#include "client/cli/record_output.h"

namespace axiscal::cli {
namespace {

struct ApproveArguments {
  int64_t calibration = 0, etag = 0;
  std::string reason;
};

absl::Status Approve(Context& context, const ApproveArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  const CalibrationId id(arguments.calibration);
  int64_t etag = arguments.etag;
  if (etag == 0) {
    ASSIGN_OR_RETURN(const records::CalibrationRecord present, client->GetCalibration(id));
    etag = present.etag;
  }
  ASSIGN_OR_RETURN(const records::CalibrationRecord record, client->ApproveCalibration(id, etag, arguments.reason));
  context.Print(ToJson(record),
                absl::StrCat("calibration ", record.id.number(), " (version ", record.version, ") of machine ",
                             record.content.machine.text(), " is approved by ", record.approved_by,
                             "; compensation uses it from now on\n", CautionText(record)));
  return absl::OkStatus();
}

}  // namespace

void AddApproveCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<ApproveArguments>();
  CLI::App* approve = app.add_subcommand("approve", "Put a calibration in use; the machine's former one retires");
  approve->add_option("CALIBRATION", arguments->calibration, "its number")->required()->check(PositiveNumber());
  approve->add_option("--etag", arguments->etag, "refuse when it changed since this etag was read")
      ->check(PositiveNumber());
  approve->add_option("--reason", arguments->reason, "why, for the audit");
  approve->footer(
      "Approving an older version is the way back. Whom the server takes you for is written down as who approved.\n"
      "Example: axiscal approve 3 --reason \"measured twice after the service\"");
  SetAction(approve, context, [&context, arguments] { return Approve(context, *arguments); });
}

}  // namespace axiscal::cli
