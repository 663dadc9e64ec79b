// axiscal compensate: with a calibration of the service, sent and rewritten in one stream or kept there as a job, or
// with machine.json and errors.json and no database at all.
#include <CLI/CLI.hpp>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/dialect_choice.h"
#include "client/cli/error_model_source.h"
#include "client/cli/job_wait.h"
#include "client/cli/output_paths.h"
#include "client/cli/record_output.h"
#include "client/cli/rewrite_arguments.h"
#include "client/cli/rewrite_text.h"
#include "core/base/crc32c.h"
#include "core/base/files.h"
#include "core/base/json_limits.h"
#include "core/compensate/compensator.h"
#include "core/machine/machine_json.h"
#include "core/nc/rewrite.h"

namespace axiscal::cli {
namespace {

namespace fs = std::filesystem;

struct CompensateArguments {
  std::string machine, errors, input, output, report, subprograms_out;
  int64_t calibration = 0;
  bool keep = false, tables_off = false;
  RewriteArguments rewrite;
};

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

// What a program became, for comparison: length and checksum of its lines. Of our own comments only how they begin
// counts: not every dialect has them at one place.
class Fingerprint {
 public:
  absl::Status Take(const char* data, size_t size) {
    while (size > 0) {
      const void* const found = std::memchr(data, '\n', size);
      const size_t count = found == nullptr ? size : static_cast<size_t>(static_cast<const char*>(found) - data) + 1;
      line_.append(data, count);
      data += count, size -= count;
      if (found != nullptr) EndLine();
    }
    return absl::OkStatus();
  }
  std::string Text() {
    EndLine();
    return absl::StrFormat("%d %08x %c", bytes_, crc32c_, comment_);
  }

 private:
  void EndLine() {
    if (line_.size() > 9 && line_.compare(1, 8, "AXISCAL ") == 0 && (line_[0] == '(' || line_[0] == ';')) {
      comment_ = line_[0];
    } else {
      bytes_ += line_.size();
      crc32c_ = base::Crc32c(crc32c_, line_.data(), line_.size());
    }
    line_.clear();
  }

  std::string line_;
  size_t bytes_ = 0;
  uint32_t crc32c_ = 0;
  char comment_ = ' ';
};

std::string ProfileNote(const std::string& taken) {
  return taken.empty() ? "" : "of the machine's profile: " + taken + "\n";
}

// "": the program's words are to say it.
std::string DialectOf(const nc::StatedOptions& stated) { return stated.open.dialect ? "" : stated.options.dialect; }

// Where the dialect is said, for the output.
std::string DialectSource(const RewriteArguments& typed) {
  return typed.dialect.empty() ? "the machine's profile" : "--dialect";
}

absl::Status CompensateFiles(Context& context, const CompensateArguments& arguments) {
  RETURN_IF_ERROR(CheckSubprograms(arguments));
  ASSIGN_OR_RETURN(const MachineWithErrors model, ReadModelFiles(arguments.machine, arguments.errors));
  ASSIGN_OR_RETURN(const std::string description, base::ReadFile(arguments.machine, base::kMaxJsonBytes));
  ASSIGN_OR_RETURN(const machine::ProgramProfile profile, machine::ProgramProfileFromJson(description));
  ASSIGN_OR_RETURN(nc::StatedOptions stated, ToStatedOptions(arguments.rewrite, model.machine));
  ASSIGN_OR_RETURN(const std::string taken, nc::TakeProfile(profile, model.machine, &stated));
  nc::RewriteOptions& options = stated.options;
  options.calibration = MarkName(arguments.errors);
  options.machine = MarkName(model.machine.id);
  compensate::Options compensator_options;
  ASSIGN_OR_RETURN(compensator_options.tool_tip_mm, ToolTip(stated));
  compensator_options.time_s = arguments.rewrite.time_s;
  compensator_options.temperature_celsius = arguments.rewrite.temperature_celsius;
  ASSIGN_OR_RETURN(const auto compensator,
                   compensate::Compensator::Create(model.machine, model.errors, compensator_options));
  base::AtomicFile report_file;
  RETURN_IF_ERROR(OpenReport(arguments, &report_file));
  const DialectTrial trial = [&](const std::string& dialect) -> absl::StatusOr<std::string> {
    nc::RewriteOptions trial_options = options;
    trial_options.dialect = dialect;
    Fingerprint fingerprint;
    nc::RewriteReport trial_report;
    RETURN_IF_ERROR(nc::RewriteFileTo(
        arguments.input, [&](const char* bytes, size_t size) { return fingerprint.Take(bytes, size); }, compensator,
        trial_options, &trial_report));
    for (const nc::Subprogram& file : trial_report.subprograms)
      RETURN_IF_ERROR(fingerprint.Take(file.text.data(), file.text.size()));
    return fingerprint.Text();
  };
  ASSIGN_OR_RETURN(const DialectChoice dialect,
                   ChooseDialect(DialectOf(stated), DialectSource(arguments.rewrite), arguments.input, trial));
  options.dialect = dialect.name;
  nc::RewriteReport report;
  const absl::Status status = nc::RewriteFile(arguments.input, arguments.output, compensator, options, &report);
  const reports::Rewrite said = nc::ReportOf(report);
  const std::string report_json = reports::ToJson(said);
  // The report tells also why a program was refused.
  RETURN_IF_ERROR(WriteReport(arguments, report_json, &report_file));
  if (!status.ok()) {
    return WithDialect(dialect, absl::Status(status.code(), absl::StrCat(arguments.input, ": ", status.message(),
                                                                         RefusedText(report))));
  }
  RETURN_IF_ERROR(WriteSubprograms(arguments, report.subprograms));
  context.Print(Json::Document(report_json),
                RewriteReportText(said, arguments.output, dialect.why) + ProfileNote(taken));
  return absl::OkStatus();
}

absl::Status FetchProgram(client::Client& client, ProgramId id, const std::string& path) {
  base::AtomicFile file;
  RETURN_IF_ERROR(file.Open(path));
  RETURN_IF_ERROR(client.GetProgram(id, [&file](const std::string& bytes) { return file.Write(bytes); }).status());
  return file.Commit();
}

absl::StatusOr<records::CompensateParams> ParamsOf(const CompensateArguments& arguments,
                                                   const nc::StatedOptions& stated) {
  records::CompensateParams params;
  ASSIGN_OR_RETURN(params.tool_tip_mm, ToolTip(stated));
  params.machine = MachineId(arguments.machine);
  params.options = stated.options;
  params.without_profile = true;  // the profile is in them
  params.tables_are_off = arguments.tables_off;
  params.time_s = arguments.rewrite.time_s;
  params.temperature_celsius = arguments.rewrite.temperature_celsius;
  if (arguments.calibration != 0) params.calibration = CalibrationId(arguments.calibration);
  return params;
}

struct OnService {
  std::string report;        // JSON
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
  if (!arguments.rewrite.tool_tip.empty()) RETURN_IF_ERROR(ToolTip(arguments.rewrite.tool_tip).status());
  base::AtomicFile report_file;
  RETURN_IF_ERROR(OpenReport(arguments, &report_file));
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::MachineRecord record, client->GetMachine(MachineId(arguments.machine)));
  ASSIGN_OR_RETURN(const machine::Machine machine, machine::MachineFromJson(record.description_json));
  ASSIGN_OR_RETURN(const machine::ProgramProfile profile, machine::ProgramProfileFromJson(record.description_json));
  ASSIGN_OR_RETURN(nc::StatedOptions stated, ToStatedOptions(arguments.rewrite, machine));
  ASSIGN_OR_RETURN(const std::string taken, nc::TakeProfile(profile, machine, &stated));
  ASSIGN_OR_RETURN(records::CompensateParams params, ParamsOf(arguments, stated));
  const DialectTrial trial = [&](const std::string& name) -> absl::StatusOr<std::string> {
    records::CompensateParams trial_params = params;
    trial_params.options.dialect = name;
    Fingerprint fingerprint;
    RETURN_IF_ERROR(
        client
            ->RewriteProgramFile(trial_params, arguments.input,
                                 [&](const std::string& bytes) { return fingerprint.Take(bytes.data(), bytes.size()); })
            .status());
    return fingerprint.Text();
  };
  ASSIGN_OR_RETURN(const DialectChoice dialect,
                   ChooseDialect(DialectOf(stated), DialectSource(arguments.rewrite), arguments.input, trial));
  params.options.dialect = dialect.name;
  const absl::StatusOr<OnService> done =
      arguments.keep ? RewriteAsJob(context, *client, params, arguments) : RewriteInStream(*client, params, arguments);
  if (!done.ok()) return WithDialect(dialect, done.status());
  const OnService& made = *done;
  RETURN_IF_ERROR(WriteReport(arguments, made.report, &report_file));
  ASSIGN_OR_RETURN(const reports::Rewrite report, reports::ReadRewrite(made.report));
  Json json = Json::Document(made.report);
  if (made.job) {
    json["job"] = made.job->number();
    json["program"] = made.program.number();
  }
  context.Print(json, RewriteReportText(report, arguments.output, dialect.why) + ProfileNote(taken));
  return absl::OkStatus();
}

absl::Status Compensate(Context& context, const CompensateArguments& arguments) {
  RETURN_IF_ERROR(CheckPaths(context, arguments));
  if (arguments.errors.empty()) RETURN_IF_ERROR(CheckSubprograms(arguments));
  if (arguments.tables_off && !arguments.errors.empty())
    return absl::InvalidArgumentError(
        "--tables-off is of tables that the service handed out, which --errors does without");
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
  compensate->add_flag("--tables-off", arguments->tables_off,
                       "the control's compensation tables are off or not loaded: needed where one was handed out of a "
                       "calibration of this machine, which would correct twice");
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
