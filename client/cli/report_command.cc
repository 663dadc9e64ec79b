// axiscal report CALIBRATION -o FILE: one page to print and sign, as PDF or HTML, without a browser.
#include <CLI/CLI.hpp>
#include <memory>

#include "absl/strings/numbers.h"
#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/output_paths.h"
#include "core/base/files.h"
#include "core/base/json_limits.h"
#include "core/machine/machine_json.h"
#include "core/session/case.h"
#include "core/session/text.h"
#include "core/sheet/calibration_sheet.h"
#include "core/sheet/html.h"
#include "core/sheet/pdf.h"

namespace axiscal::cli {
namespace {

constexpr size_t kMostReportBytes = size_t{256} << 20;  // correlations of many errors are long

struct ReportArguments {
  std::string calibration, machine, output, language = "en";
  std::vector<std::string> sessions;
};

absl::StatusOr<sheet::CalibrationToPrint> ReadStoredReport(Context& context, int64_t id) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  sheet::CalibrationToPrint found;
  ASSIGN_OR_RETURN(found.stored, client->GetCalibration(CalibrationId(id)));
  const records::NewCalibration& content = found.stored->content;
  ASSIGN_OR_RETURN(found.report, reports::ReadCalibrationReport(content.report_json));
  ASSIGN_OR_RETURN(const records::MachineRecord described,
                   client->GetMachineRevision(content.machine, content.machine_revision));
  ASSIGN_OR_RETURN(found.machine, machine::MachineFromJson(described.description_json));
  for (const SessionId& session : content.sessions) {
    ASSIGN_OR_RETURN(found.sessions.emplace_back(), client->GetSession(session));
  }
  return found;
}

absl::StatusOr<sheet::CalibrationToPrint> ReadReportFile(const ReportArguments& arguments) {
  sheet::CalibrationToPrint found;
  ASSIGN_OR_RETURN(const std::string text, base::ReadFile(arguments.calibration, kMostReportBytes));
  auto report = reports::ReadCalibrationReport(text);
  if (!report.ok()) return base::Within(arguments.calibration, report.status());
  found.report = *std::move(report);
  if (arguments.machine.empty()) {
    if (arguments.sessions.empty()) return found;
    return absl::InvalidArgumentError("--sessions: expected --machine with them");
  }
  ASSIGN_OR_RETURN(const std::string description, base::ReadFile(arguments.machine, base::kMaxJsonBytes));
  auto machine = machine::MachineFromJson(description);
  if (!machine.ok()) return base::Within(arguments.machine, machine.status());
  found.machine = *std::move(machine);
  for (const std::string& file : arguments.sessions) {
    ASSIGN_OR_RETURN(const session::Session read, session::ReadSessionFileOf(file, *found.machine));
    records::SessionRecord& session = found.sessions.emplace_back();
    session.name = session::FindHeader(read, "session").value_or("");
    session.instrument = session::FindHeader(read, "instrument").value_or("");
    session.header = read.header;
    if (const auto started = session::FindHeader(read, "started"); started.has_value())
      session.measured_at = session::ParseIso8601(*started);
  }
  return found;
}

absl::Status RunReport(Context& context, const ReportArguments& arguments) {
  const bool is_html = arguments.output.ends_with(".html");
  if (!is_html && !arguments.output.ends_with(".pdf")) {
    return absl::InvalidArgumentError(
        absl::StrCat("--output ", arguments.output, ": expected a name that ends in .pdf or .html"));
  }
  int64_t id = 0;
  const bool is_stored = absl::SimpleAtoi(arguments.calibration, &id);
  if (is_stored && !(arguments.machine.empty() && arguments.sessions.empty())) {
    return absl::InvalidArgumentError(
        "--machine, --sessions: expected with a report file only; of a stored calibration they are known");
  }
  std::vector<NamedPath> inputs = {{"CALIBRATION", is_stored ? "" : arguments.calibration},
                                   {"--machine", arguments.machine}};
  for (const std::string& file : arguments.sessions) inputs.emplace_back("--sessions", file);
  RETURN_IF_ERROR(CheckOutputs(inputs, {{"--output", arguments.output}}));
  ASSIGN_OR_RETURN(const sheet::CalibrationToPrint found,
                   is_stored ? ReadStoredReport(context, id) : ReadReportFile(arguments));
  const sheet::Sheet page =
      sheet::CalibrationSheet(found, arguments.language == "de" ? sheet::Language::kGerman : sheet::Language::kEnglish);
  std::string bytes;
  if (is_html) {
    bytes = sheet::ToHtml(page);
  } else {
    ASSIGN_OR_RETURN(bytes, sheet::ToPdf(page));
  }
  RETURN_IF_ERROR(base::WriteFileAtomically(arguments.output, bytes));
  context.Print({{"file", arguments.output}, {"bytes", static_cast<int64_t>(bytes.size())}},
                absl::StrCat("one page is in ", arguments.output, "\n"));
  return absl::OkStatus();
}

}  // namespace

void AddReportCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<ReportArguments>();
  CLI::App* report =
      app.add_subcommand("report", "A page of a calibration to print and sign, in the terms of ISO 230-1");
  report->add_option("CALIBRATION", arguments->calibration, "a stored calibration's number, or a report file")
      ->required();
  report->add_option("-o,--output", arguments->output, "the file: .pdf, or .html to print from a browser")->required();
  report->add_option("--language", arguments->language, "en or de")
      ->check(CLI::IsMember({"en", "de"}))
      ->capture_default_str();
  report->add_option("--machine", arguments->machine, "of a report file: its machine.json");
  report
      ->add_option("--sessions", arguments->sessions,
                   "of a report file: its session files, for instruments, serial numbers and operators")
      ->delimiter(',');
  report->footer(
      "A report file is what identify --report and close-loop --report write.\n"
      "Examples: axiscal report 12 -o calibration-12.pdf\n"
      "          axiscal report report.json --machine machine.json --sessions BX.csv,CR.csv --language de -o page.pdf");
  SetAction(report, context, [&context, arguments] { return RunReport(context, *arguments); });
}

}  // namespace axiscal::cli
