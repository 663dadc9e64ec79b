// axiscal close-loop: a case folder in, the effects that its model lacks out; no database and no server.
#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/output_paths.h"
#include "client/cli/record_output.h"
#include "core/base/files.h"
#include "core/base/units.h"
#include "core/loop/close_loop.h"
#include "core/loop/pictures.h"
#include "core/machine/error_json.h"
#include "core/session/case.h"

namespace axiscal::cli {
namespace {

using base::kUmPerMm;
using machine::Machine;

struct Arguments {
  std::string folder, report, errors, plot;
  int max_effects = 8;
};

std::string Um(double mm) { return absl::StrFormat("%.3g um", mm * kUmPerMm); }

// "EXX:backlash    -2.92 +- 0.02 um   moves the readings by 0.9 um rms" and what else it could be.
std::string EffectText(const Machine& machine, const loop::Effect& effect) {
  const double factor = machine::AmplitudeFactor(effect.term);
  std::string text =
      absl::StrFormat("  %-24s %10.4g +- %.2g %s, %s rms in the readings\n", machine::NameOf(machine, effect.term),
                      effect.amplitude / factor, effect.amplitude_sigma / factor,
                      machine::AmplitudeUnit(effect.term, machine), Um(effect.rms_mm));
  if (effect.equivalent.empty()) return text;
  constexpr size_t kShown = 5;
  absl::StrAppend(&text, "      these sessions cannot tell it from");
  for (size_t i = 0; i < std::min(kShown, effect.equivalent.size()); ++i) {
    absl::StrAppend(&text, i == 0 ? " " : ", ", machine::NameOf(machine, effect.equivalent[i]));
  }
  if (effect.equivalent.size() > kShown) absl::StrAppend(&text, " and ", effect.equivalent.size() - kShown, " more");
  return text + "\n";
}

std::string UnexplainedText(const Machine& machine, const loop::Unexplained& part) {
  if (part.variable == "t") {
    return absl::StrFormat("  session %s: the artefact or the setup moved between %.6g s and %.6g s\n", part.session,
                           part.from, part.to);
  }
  const int axis = machine::FindAxis(machine, part.variable);
  const bool is_rotary = machine.axes[axis].kind == machine::AxisKind::kRotary;
  const double unit = is_rotary ? base::kDegPerRad : 1.0;
  return absl::StrFormat("  %s from %.6g to %.6g %s: local structure without a name, %s rms\n", part.variable,
                         part.from * unit, part.to * unit, is_rotary ? "deg" : "mm", Um(part.rms_mm));
}

const char* VerdictText(loop::Verdict::Kind verdict) {
  switch (verdict) {
    case loop::Verdict::kAdequate:
      return "the declared model is adequate: nothing significant is left in the readings";
    case loop::Verdict::kExtended:
      return "the model was extended";
    case loop::Verdict::kUnexplained:
      return "there is structure in the readings that has no name";
  }
  return "";
}

std::string ReportText(const Machine& machine, const loop::Report& report) {
  std::string text = absl::StrCat("verdict: ", VerdictText(report.verdict), "\n");
  if (!report.effects.empty()) absl::StrAppend(&text, "effects that the declared model lacked:\n");
  for (const loop::Effect& effect : report.effects) absl::StrAppend(&text, EffectText(machine, effect));
  if (!report.unexplained.empty()) absl::StrAppend(&text, "unexplained:\n");
  for (const loop::Unexplained& part : report.unexplained) absl::StrAppend(&text, UnexplainedText(machine, part));
  for (const std::string& name : report.withdrawn) {
    absl::StrAppend(&text, "withdrawn: ", name, " does not help on the check sessions\n");
  }
  if (!report.fitted.outliers.empty()) {
    absl::StrAppend(&text, report.fitted.outliers.size(),
                    " readings stand out of their series and were set aside (listed in the report)\n");
  }
  if (!report.next_measurement.empty()) absl::StrAppend(&text, "measure next:\n");
  for (const loop::Proposal& proposal : report.next_measurement)
    absl::StrAppend(&text, loop::ProposalText(machine, proposal));
  std::vector<std::vector<std::string>> rows = {{"residual rms, um", "before", "after"}};
  const auto add = [&rows](const char* name, double before_mm, double after_mm) {
    rows.push_back({name, NumberText(before_mm * kUmPerMm), NumberText(after_mm * kUmPerMm)});
  };
  add("fit sessions", report.fit_before.rms_mm, report.fit_after.rms_mm);
  if (report.has_check) add("check sessions", report.check_before.rms_mm, report.check_after.rms_mm);
  return text + Table(rows);
}

absl::Status WritePictures(const std::string& folder, const std::vector<loop::Picture>& pictures) {
  for (const loop::Picture& picture : pictures)
    RETURN_IF_ERROR(base::WriteFileAtomically(absl::StrCat(folder, "/", picture.file), picture.svg));
  return absl::OkStatus();
}

// The folder for pictures, made where it is missing; before any work, so that a bad name costs none.
absl::Status MakeFolder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder))
    return absl::InvalidArgumentError(absl::StrCat("--plot ", folder, ": ", error ? error.message() : "no folder"));
  return absl::OkStatus();
}

absl::Status CheckPaths(const Arguments& arguments, const session::Case& measured) {
  std::vector<NamedPath> inputs = {{"machine.json", arguments.folder + "/machine.json"}};
  for (const auto* files : {&measured.fit_files, &measured.check_files}) {
    for (const std::string& file : *files) inputs.push_back({"session", file});
  }
  return CheckOutputs(inputs, {{"--report", arguments.report}, {"--errors", arguments.errors}});
}

absl::Status CloseLoop(Context& context, const Arguments& arguments) {
  ASSIGN_OR_RETURN(const session::Case measured, session::ReadCase(arguments.folder));
  RETURN_IF_ERROR(CheckPaths(arguments, measured));
  if (!arguments.plot.empty()) RETURN_IF_ERROR(MakeFolder(arguments.plot));
  ASSIGN_OR_RETURN(auto fit, identify::BindSessions(measured.machine, measured.fit));
  ASSIGN_OR_RETURN(auto check, identify::BindSessions(measured.machine, measured.check));
  loop::Options options;
  options.max_effects = arguments.max_effects;
  ProgressBar bar = context.Bar("closing the loop");
  options.progress = [&bar](const identify::Progress& progress) { bar.Show(progress.fraction, progress.detail); };
  ASSIGN_OR_RETURN(const loop::Report report, loop::CloseLoop(measured.machine, fit, check, options));
  const std::string json = loop::ToJson(measured.machine, report);
  if (!arguments.report.empty()) RETURN_IF_ERROR(base::WriteFileAtomically(arguments.report, json));
  if (!arguments.errors.empty()) {
    RETURN_IF_ERROR(
        base::WriteFileAtomically(arguments.errors, machine::WriteErrors(report.fitted.model, measured.machine)));
  }
  if (!arguments.plot.empty())
    RETURN_IF_ERROR(WritePictures(arguments.plot, loop::Pictures(measured.machine, fit, check, report)));
  context.Print(Embedded(json), ReportText(measured.machine, report));
  return absl::OkStatus();
}

}  // namespace

void AddCloseLoopCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("close-loop", "find the effects that a machine's model lacks, in a case folder of sessions");
  command->add_option("case", arguments->folder, "folder with machine.json, fit/*.csv and check/*.csv")->required();
  command->add_option("--report", arguments->report, "write the full report (JSON) to this file");
  command->add_option("--errors", arguments->errors,
                      "write the extended model's errors (errors.json) to this file, for compensate");
  command->add_option(
      "--plot", arguments->plot,
      "write pictures (SVG) into this folder: residuals against each variable and ball-bar traces, before "
      "and after, and the ranking of candidates");
  command->add_option("--max-effects", arguments->max_effects, "stop after this many effects")
      ->check(CLI::Range(1, 50))
      ->capture_default_str();
  command->footer(
      "Examples:\n"
      "  axiscal close-loop tuesday/ --report report.json --plot pictures/\n"
      "  axiscal close-loop tuesday/ --errors errors.json && axiscal compensate --machine tuesday/machine.json "
      "--errors errors.json --tool-tip \"0 0 -350\" in.nc -o out.nc");
  SetAction(command, context, [&context, arguments] { return CloseLoop(context, *arguments); });
}

}  // namespace axiscal::cli
