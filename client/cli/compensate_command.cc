// axiscal compensate: with a calibration of the service, sent and rewritten in one stream or kept there as a job, or
// with machine.json and errors.json and no database at all.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/error_model_source.h"
#include "client/cli/job_wait.h"
#include "client/cli/line_ranges.h"
#include "client/cli/output_paths.h"
#include "client/cli/record_output.h"
#include "client/cli/rewrite_arguments.h"
#include "core/base/files.h"
#include "core/compensate/compensator.h"
#include "core/machine/machine_json.h"
#include "core/nc/rewrite.h"

namespace axiscal::cli {
namespace {

namespace fs = std::filesystem;

struct CompensateArguments {
  std::string machine, errors, input, output, report, subprograms_out;
  int64_t calibration = 0;
  bool keep = false;
  RewriteArguments rewrite;
};

// The part of a report that --orientation adds: the first blocks whose direction was not reached by line.
std::string OrientationText(const std::optional<reports::Orientation>& orientation) {
  constexpr size_t kShown = 5;
  if (!orientation) return "";
  const auto row = [](const std::string& name, const reports::AngleSpread& spread) {
    return std::vector<std::string>{name, NumberText(spread.max_urad), NumberText(spread.rms_urad)};
  };
  std::vector<std::vector<std::string>> rows = {{"", "max urad", "rms urad"}};
  for (const auto& [axis, spread] : orientation->correction) rows.push_back(row("correction of " + axis, spread));
  rows.push_back(row("tool direction error before", orientation->error_before));
  rows.push_back(row("tool direction error after", orientation->error_after));
  std::string text = Table(rows);
  const int64_t count = orientation->blocks_not_reached;
  if (count == 0) return text;
  absl::StrAppend(&text, "direction not reached in ", count, count == 1 ? " block" : " blocks",
                  " (no rotary command changes by more than ",
                  absl::StrFormat("%g", orientation->max_rotary_correction_deg), " deg):\n");
  const std::vector<reports::Finding>& findings = orientation->not_reached;
  for (size_t i = 0; i < findings.size() && i < kShown; ++i) {
    absl::StrAppend(&text, "  line ", findings[i].line, ": ", findings[i].block, "  (", findings[i].reason, ")\n");
  }
  if (count > static_cast<int64_t>(kShown)) absl::StrAppend(&text, "  ... more in the report\n");
  return text;
}

std::string HolesText(const std::optional<reports::Holes>& holes) {
  constexpr size_t kShown = 5;
  if (!holes) return "";
  std::string text = absl::StrFormat("%d holes of drilling cycles, at most %.1f um left at the bottom\n",
                                     holes->corrected, holes->left_max_um);
  for (size_t i = 0; i < holes->left.size() && i < kShown; ++i) {
    const reports::Finding& found = holes->left[i];
    absl::StrAppend(&text, "  line ", found.line, ": ", found.block, "  (", found.reason, ")\n");
  }
  if (holes->not_exact > static_cast<int64_t>(kShown)) absl::StrAppend(&text, "  ... more in the report\n");
  return text;
}

std::string RewriteReportText(const reports::Rewrite& report, const std::string& output) {
  std::string text =
      absl::StrFormat("%s: %d of %d blocks corrected, %d split, %d passed unchanged\n", output,
                      report.blocks.corrected, report.blocks.read, report.blocks.split, report.blocks.passed);
  std::vector<std::vector<std::string>> rows = {{"", "max um", "rms um"}};
  const auto row = [&rows](const std::string& name, const reports::Spread& spread) {
    rows.push_back({name, NumberText(spread.max_um), NumberText(spread.rms_um)});
  };
  for (const auto& [axis, spread] : report.correction) row("correction of " + axis, spread);
  row("tool-point error before", report.error_before);
  row("tool-point error after", report.error_after);
  absl::StrAppend(&text, Table(rows), OrientationText(report.orientation), HolesText(report.holes));
  absl::StrAppend(&text, LineRangesText("not corrected", report.not_corrected, report.ranges_not_corrected));
  for (const std::string& note : report.notes) absl::StrAppend(&text, "note: ", note, "\n");
  return text;
}

// What was refused, one line each, for the error's text.
std::string RefusedText(const nc::RewriteReport& report) {
  std::string text;
  for (const nc::Finding& finding : report.refused)
    absl::StrAppend(&text, "\n  line ", finding.line, ": ", finding.block, "  (", finding.reason, ")");
  return text;
}

// Outputs are opened before the work, so that a report that cannot be written stops it.
absl::Status OpenReport(const CompensateArguments& arguments, base::AtomicFile* file) {
  return arguments.report.empty() ? absl::OkStatus() : file->Open(arguments.report);
}

absl::Status WriteReport(const CompensateArguments& arguments, const std::string& json, base::AtomicFile* file) {
  if (arguments.report.empty()) return absl::OkStatus();
  RETURN_IF_ERROR(file->Write(json));
  return file->Commit();
}

absl::Status CheckPaths(const Context& context, const CompensateArguments& arguments) {
  std::vector<NamedPath> inputs = {{"the input", arguments.input}};
  if (context.server.empty()) inputs.push_back({"the database", context.database});
  if (!arguments.errors.empty()) {
    inputs.push_back({"--machine", arguments.machine});
    inputs.push_back({"--errors", arguments.errors});
  }
  return CheckOutputs(inputs, {{"--output", arguments.output}, {"--report", arguments.report}});
}

// Letters, digits, blanks and "._-+:/" may stand in the program's mark.
std::string MarkName(const std::string& path) {
  std::string name = fs::path(path).filename().string();
  for (char& c : name) {
    if (!std::isalnum(static_cast<unsigned char>(c)) && std::string(" ._-+:/").find(c) == std::string::npos) c = '_';
  }
  return name;
}

// Where corrected subprograms go: a folder of their own, so that no source is written over.
absl::Status CheckSubprograms(const CompensateArguments& arguments) {
  const std::string &in = arguments.rewrite.subprograms, &out = arguments.subprograms_out;
  if (in.empty() && out.empty()) return absl::OkStatus();
  if (in.empty() || out.empty()) {
    return absl::InvalidArgumentError(
        "--subprograms and --subprograms-out: state both, where subprograms are read and where they are written");
  }
  if (arguments.errors.empty()) {
    return absl::InvalidArgumentError(
        "--subprograms: with a calibration of the service a program comes alone; state --errors, or put the "
        "subprograms behind the program's end in its file");
  }
  std::error_code error;
  fs::create_directories(out, error);
  if (error)
    return absl::UnavailableError(absl::StrCat("--subprograms-out: cannot make '", out, "': ", error.message()));
  if (fs::equivalent(in, out, error))
    return absl::InvalidArgumentError("--subprograms-out: '" + out + "' is the folder of --subprograms");
  return absl::OkStatus();
}

absl::Status WriteSubprograms(const CompensateArguments& arguments, const std::vector<nc::Subprogram>& files) {
  for (const nc::Subprogram& file : files)
    RETURN_IF_ERROR(base::WriteFileAtomically((fs::path(arguments.subprograms_out) / file.name).string(), file.text));
  return absl::OkStatus();
}

absl::Status CompensateFiles(Context& context, const CompensateArguments& arguments) {
  RETURN_IF_ERROR(CheckSubprograms(arguments));
  ASSIGN_OR_RETURN(const MachineWithErrors model, ReadModelFiles(arguments.machine, arguments.errors));
  ASSIGN_OR_RETURN(nc::RewriteOptions options, ToRewriteOptions(arguments.rewrite, model.machine));
  options.calibration = MarkName(arguments.errors);
  compensate::Options compensator_options;
  ASSIGN_OR_RETURN(compensator_options.tool_tip_mm, ToolTip(arguments.rewrite));
  compensator_options.time_s = arguments.rewrite.time_s;
  compensator_options.temperature_celsius = arguments.rewrite.temperature_celsius;
  ASSIGN_OR_RETURN(const auto compensator,
                   compensate::Compensator::Create(model.machine, model.errors, compensator_options));
  base::AtomicFile report_file;
  RETURN_IF_ERROR(OpenReport(arguments, &report_file));
  nc::RewriteReport report;
  const absl::Status status = nc::RewriteFile(arguments.input, arguments.output, compensator, options, &report);
  const reports::Rewrite said = nc::ReportOf(report);
  const std::string report_json = reports::ToJson(said);
  // The report tells also why a program was refused.
  RETURN_IF_ERROR(WriteReport(arguments, report_json, &report_file));
  if (!status.ok())
    return absl::Status(status.code(), absl::StrCat(arguments.input, ": ", status.message(), RefusedText(report)));
  RETURN_IF_ERROR(WriteSubprograms(arguments, report.subprograms));
  context.Print(Json::Document(report_json), RewriteReportText(said, arguments.output));
  return absl::OkStatus();
}

absl::Status FetchProgram(client::Client& client, ProgramId id, const std::string& path) {
  base::AtomicFile file;
  RETURN_IF_ERROR(file.Open(path));
  RETURN_IF_ERROR(client.GetProgram(id, [&file](const std::string& bytes) { return file.Write(bytes); }).status());
  return file.Commit();
}

absl::StatusOr<records::CompensateParams> ParamsOf(const CompensateArguments& arguments, client::Client& client) {
  records::CompensateParams params;
  ASSIGN_OR_RETURN(params.tool_tip_mm, ToolTip(arguments.rewrite));
  params.machine = MachineId(arguments.machine);
  ASSIGN_OR_RETURN(const records::MachineRecord record, client.GetMachine(params.machine));
  ASSIGN_OR_RETURN(const machine::Machine machine, machine::MachineFromJson(record.description_json));
  ASSIGN_OR_RETURN(params.options, ToRewriteOptions(arguments.rewrite, machine));
  params.time_s = arguments.rewrite.time_s;
  params.temperature_celsius = arguments.rewrite.temperature_celsius;
  if (arguments.calibration != 0) params.calibration = CalibrationId(arguments.calibration);
  return params;
}

struct OnService {
  std::string report;  // JSON
  std::optional<JobId> job;  // of what is kept there
  ProgramId program;
};

// Up and down in one call; nothing stays on the service.
absl::StatusOr<OnService> RewriteInStream(client::Client& client, const records::CompensateParams& params,
                                          const CompensateArguments& arguments) {
  base::AtomicFile file;
  RETURN_IF_ERROR(file.Open(arguments.output));
  OnService made;
  ASSIGN_OR_RETURN(made.report, client.RewriteProgramFile(params, arguments.input, [&file](const std::string& bytes) {
    return file.Write(bytes);
  }));
  RETURN_IF_ERROR(file.Commit());
  return made;
}

// The program, the rewritten one and the report stay on the service.
absl::StatusOr<OnService> RewriteAsJob(const Context& context, client::Client& client, records::CompensateParams params,
                                       const CompensateArguments& arguments) {
  ASSIGN_OR_RETURN(const records::ProgramRecord program, client.PutProgramFile(arguments.input));
  params.program = program.id;
  ASSIGN_OR_RETURN(const records::JobRecord job, client.CreateJob(params));
  ASSIGN_OR_RETURN(const records::JobRecord done, FollowJob(context, client, job.id));
  if (done.programs.empty()) return absl::InternalError(absl::StrCat("job ", job.id.number(), " made no program"));
  RETURN_IF_ERROR(FetchProgram(client, done.programs[0], arguments.output));
  return OnService{done.result, done.id, done.programs[0]};
}

absl::Status CompensateOnService(Context& context, const CompensateArguments& arguments) {
  RETURN_IF_ERROR(ToolTip(arguments.rewrite).status());
  base::AtomicFile report_file;
  RETURN_IF_ERROR(OpenReport(arguments, &report_file));
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::CompensateParams params, ParamsOf(arguments, *client));
  ASSIGN_OR_RETURN(const OnService made, arguments.keep ? RewriteAsJob(context, *client, params, arguments)
                                                        : RewriteInStream(*client, params, arguments));
  RETURN_IF_ERROR(WriteReport(arguments, made.report, &report_file));
  ASSIGN_OR_RETURN(const reports::Rewrite report, reports::ReadRewrite(made.report));
  Json json = Json::Document(made.report);
  if (made.job) {
    json["job"] = made.job->number();
    json["program"] = made.program.number();
  }
  context.Print(json, RewriteReportText(report, arguments.output));
  return absl::OkStatus();
}

absl::Status Compensate(Context& context, const CompensateArguments& arguments) {
  RETURN_IF_ERROR(CheckPaths(context, arguments));
  if (arguments.errors.empty()) RETURN_IF_ERROR(CheckSubprograms(arguments));
  if (arguments.keep && !arguments.errors.empty())
    return absl::InvalidArgumentError("--keep stores programs on the service, which --errors does without");
  return arguments.errors.empty() ? CompensateOnService(context, arguments) : CompensateFiles(context, arguments);
}

}  // namespace

void AddCompensateCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<CompensateArguments>();
  CLI::App* compensate =
      app.add_subcommand("compensate", "Rewrite an NC program so that the tool goes where the program says");
  compensate->add_option("INPUT", arguments->input, "the program")->required();
  compensate->add_option("-o,--output", arguments->output, "the rewritten program")->required();
  AddModelOptions(*compensate, arguments->machine, arguments->errors, arguments->calibration);
  compensate->add_option("--report", arguments->report, "write the report as JSON");
  compensate->add_flag("--keep", arguments->keep,
                       "as a job: the program, the rewritten one and the report stay on the service");
  AddRewriteOptions(*compensate, arguments->rewrite);
  compensate->add_option("--subprograms-out", arguments->subprograms_out,
                         "with --subprograms: a folder for those that the program calls, corrected");
  compensate->footer(
      "Every byte that is not a corrected axis word stays. A program that cannot be corrected safely, or was corrected "
      "before, is\n"
      "refused with line and reason, and nothing is written.\n"
      "Examples: axiscal compensate --machine mt --tool-tip \"0 0 -350\" in.nc -o out.nc\n"
      "          axiscal compensate --machine mt --tool-tip \"0 0 -350\" --orientation in.nc -o out.nc\n"
      "          axiscal compensate --machine machine.json --errors errors.json --tool-tip \"0 0 -350\" in.nc -o "
      "out.nc --report report.json");
  SetAction(compensate, context, [&context, arguments] { return Compensate(context, *arguments); });
}

}  // namespace axiscal::cli
