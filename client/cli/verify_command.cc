// axiscal verify: an original and its compensated program through the machine model.
#include <CLI/CLI.hpp>
#include <fstream>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/dialect_choice.h"
#include "client/cli/error_model_source.h"
#include "client/cli/line_ranges.h"
#include "client/cli/output_paths.h"
#include "client/cli/record_output.h"
#include "client/cli/rewrite_arguments.h"
#include "core/base/files.h"
#include "core/base/json_limits.h"
#include "core/base/units.h"
#include "core/nc/mark.h"
#include "core/nc/verify.h"

namespace axiscal::cli {
namespace {

struct VerifyArguments {
  std::string original, compensated, machine, errors, report, subprograms_out;
  int64_t calibration = 0;
  RewriteArguments rewrite;
};

std::vector<std::string> Row(const std::string& name, const nc::Spread& spread) {
  return {name, NumberText(spread.max_mm * base::kUmPerMm), NumberText(spread.rms_mm() * base::kUmPerMm)};
}

std::vector<std::string> AngleRow(const std::string& name, const nc::AngleSpread& spread) {
  return {name, NumberText(spread.max_rad * base::kUradPerRad), NumberText(spread.rms_rad() * base::kUradPerRad)};
}

std::string ReportText(const nc::VerifyReport& report, bool with_directions) {
  std::string text = absl::StrCat(report.moves, " moves compared");
  if (report.moves_unknown > 0)
    absl::StrAppend(&text, ", ", report.moves_unknown, " not evaluated: an axis position is unknown");
  if (report.blocks_unsupported > 0)
    absl::StrAppend(&text, ", ", report.blocks_unsupported, " blocks not evaluated: no moves to positions");
  absl::StrAppend(&text, "\n",
                  Table({{"tool-point error", "max um", "rms um"},
                         Row("at ends of moves, original", report.end_before),
                         Row("at ends of moves, compensated", report.end_after),
                         Row("inside moves, original", report.path_before),
                         Row("inside moves, compensated", report.path_after)}));
  if (with_directions) {
    absl::StrAppend(&text, Table({{"tool direction error", "max urad", "rms urad"},
                                  AngleRow("at ends of moves, original", report.end_tilt_before),
                                  AngleRow("at ends of moves, compensated", report.end_tilt_after),
                                  AngleRow("inside moves, original", report.path_tilt_before),
                                  AngleRow("inside moves, compensated", report.path_tilt_after)}));
  }
  absl::StrAppend(&text, LineRangesText("not judged", report.not_judged.listed, report.not_judged.count));
  if (report.worst_line > 0) absl::StrAppend(&text, "largest after compensation: line ", report.worst_line, "\n");
  return text;
}

// The machine that the program was corrected for, from its head.
absl::Status CheckMachine(const std::string& path, const std::string& machine) {
  RETURN_IF_ERROR(base::RequireFile(path));
  std::string head(size_t{1} << 18, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<size_t>(file.gcount()));
  const std::string marked = nc::MarkedMachine(head);
  if (marked.empty() || marked == machine) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(path, ": was corrected for machine ", marked, ", and --machine is ",
                                                    machine, ": on another machine its words are wrong"));
}

absl::Status Verify(Context& context, const VerifyArguments& arguments) {
  std::vector<NamedPath> inputs = {{"the original", arguments.original},
                                   {"the compensated program", arguments.compensated}};
  if (context.server.empty()) inputs.push_back({"the database", context.database});
  if (!arguments.errors.empty()) {
    inputs.push_back({"--machine", arguments.machine});
    inputs.push_back({"--errors", arguments.errors});
  }
  RETURN_IF_ERROR(CheckOutputs(inputs, {{"--report", arguments.report}}));
  nc::VerifyOptions options;
  if (!arguments.rewrite.tool_tip.empty()) RETURN_IF_ERROR(ToolTip(arguments.rewrite.tool_tip).status());
  ASSIGN_OR_RETURN(const MachineWithErrors model, arguments.errors.empty()
                                                      ? FetchModel(context, arguments.machine, arguments.calibration)
                                                      : ReadModelFiles(arguments.machine, arguments.errors));
  // The profile of now, not of when the calibration was made.
  std::string description;
  if (arguments.errors.empty()) {
    ASSIGN_OR_RETURN(client::Client * client, context.Connect());
    ASSIGN_OR_RETURN(const records::MachineRecord record, client->GetMachine(MachineId(arguments.machine)));
    description = record.description_json;
  } else {
    ASSIGN_OR_RETURN(description, base::ReadFile(arguments.machine, base::kMaxJsonBytes));
  }
  ASSIGN_OR_RETURN(const machine::ProgramProfile profile, machine::ProgramProfileFromJson(description));
  ASSIGN_OR_RETURN(nc::StatedOptions stated, ToStatedOptions(arguments.rewrite, model.machine));
  RETURN_IF_ERROR(nc::TakeProfile(profile, model.machine, &stated).status());
  ASSIGN_OR_RETURN(options.tool_tip_mm, ToolTip(stated));
  RETURN_IF_ERROR(CheckMachine(arguments.compensated, model.machine.id));
  options.reading = stated.options;
  ASSIGN_OR_RETURN(options.compensated_subprograms, ReadSubprograms("--subprograms-out", arguments.subprograms_out));
  options.time_s = arguments.rewrite.time_s.value_or(options.time_s);
  options.temperature_celsius = arguments.rewrite.temperature_celsius.value_or(options.temperature_celsius);
  const auto verify = [&](const std::string& name) {
    nc::VerifyOptions in = options;
    in.reading.dialect = name;
    return nc::VerifyFiles(arguments.original, arguments.compensated, model.machine, model.errors, in);
  };
  const DialectTrial trial = [&](const std::string& name) -> absl::StatusOr<std::string> {
    ASSIGN_OR_RETURN(const nc::VerifyReport found, verify(name));
    return nc::ToJson(found);
  };
  ASSIGN_OR_RETURN(const DialectChoice dialect,
                   ChooseDialect(stated.open.dialect ? "" : stated.options.dialect,
                                 arguments.rewrite.dialect.empty() ? "the machine's profile" : "--dialect",
                                 arguments.original, trial));
  const absl::StatusOr<nc::VerifyReport> verified = verify(dialect.name);
  if (!verified.ok()) return WithDialect(dialect, verified.status());
  const nc::VerifyReport& report = *verified;
  const std::string report_json = nc::ToJson(report);
  if (!arguments.report.empty()) RETURN_IF_ERROR(base::WriteFileAtomically(arguments.report, report_json));
  context.Print(Json::Document(report_json),
                ReportText(report, arguments.rewrite.orientation) + "dialect: " + dialect.why + "\n");
  if (report.blocks_passed == 0) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("not all is judged: ", report.blocks_passed, report.blocks_passed == 1 ? " block is" : " blocks are",
                   " passed as they are, see the lines above; the rest is as reported"));
}

}  // namespace

void AddVerifyCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<VerifyArguments>();
  CLI::App* verify =
      app.add_subcommand("verify", "Run a program and its compensated form through the machine model and compare");
  verify->add_option("ORIGINAL", arguments->original, "the program as it was")->required();
  verify->add_option("COMPENSATED", arguments->compensated, "the program as it was rewritten")->required();
  AddModelOptions(*verify, arguments->machine, arguments->errors, arguments->calibration);
  verify->add_option("--report", arguments->report, "write the report as JSON");
  AddRewriteOptions(*verify, arguments->rewrite);
  verify->add_option("--subprograms-out", arguments->subprograms_out,
                     "the folder of the rewritten subprograms; --subprograms: of those as they were");
  verify->footer(
      "Independent of how the correction was computed: both programs are read and every move is evaluated on the chain "
      "with the\n"
      "machine's errors. Give the options that compensate was given. What was passed as it is (--on-unsupported pass) "
      "is not judged:\n"
      "its lines are listed, and the exit code is 5.\n"
      "Example: axiscal verify --machine mt --tool-tip \"0 0 -350\" in.nc out.nc");
  SetAction(verify, context, [&context, arguments] { return Verify(context, *arguments); });
}

}  // namespace axiscal::cli
