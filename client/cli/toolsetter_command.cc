// axiscal toolsetter: measuring rods and round-insert mills in a laser tool setter, from files without database and
// server, or as a job on a stored session.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/job_wait.h"
#include "client/cli/output_paths.h"
#include "client/cli/record_output.h"
#include "client/cli/session_choice.h"
#include "client/cli/toolsetter_curve.h"
#include "client/cli/toolsetter_plan.h"
#include "client/cli/toolsetter_text.h"
#include "core/base/files.h"
#include "core/base/units.h"
#include "core/session/read_session.h"
#include "core/session/text.h"
#include "core/toolsetter/evaluate.h"

namespace axiscal::cli {
namespace {

struct ToolsetterArguments {
  std::string file, machine, session, report, request_id;
  std::string beam, beam_sigma, rod, rod_sigma;  // numbers as typed
  std::string fit;                               // "yaw,pitch"
  bool no_wait = false;
};

absl::StatusOr<std::vector<double>> Numbers(const std::string& option, const std::string& text, size_t count,
                                            const std::string& expected) {
  std::vector<double> numbers;
  if (session::ParseNumbers(text, &numbers) && numbers.size() == count) return numbers;
  return absl::InvalidArgumentError(absl::StrCat(option, " '", text, "': expected ", expected));
}

// The rods to compute: those of a session file, or the one on the command line; --beam stands in for the file's.
absl::StatusOr<toolsetter::RodSession> RodsOf(const ToolsetterArguments& arguments) {
  using base::kRadPerDeg;
  toolsetter::RodSession rods;
  if (!arguments.file.empty()) {
    if (!arguments.rod.empty()) return absl::InvalidArgumentError("trigger: expected either FILE or --rod");
    ASSIGN_OR_RETURN(const session::Session session, session::ReadSessionFile(arguments.file));
    ASSIGN_OR_RETURN(rods, toolsetter::ReadRodSession(session));
  } else if (arguments.rod.empty() || arguments.beam.empty()) {
    return absl::InvalidArgumentError("trigger: expected a session FILE, or --rod and --beam");
  }
  if (!arguments.beam.empty()) {
    ASSIGN_OR_RETURN(const auto n, Numbers("--beam", arguments.beam, 3, "\"R_l yaw pitch\" in mm and deg"));
    rods.beam = {n[0], n[1] * kRadPerDeg, n[2] * kRadPerDeg};
  }
  if (!arguments.beam_sigma.empty()) {
    ASSIGN_OR_RETURN(const auto n, Numbers("--beam-sigma", arguments.beam_sigma, 3, "\"R_l yaw pitch\" in mm and deg"));
    rods.beam_sigma = {n[0], n[1] * kRadPerDeg, n[2] * kRadPerDeg};
  }
  if (arguments.rod.empty()) return rods;
  toolsetter::MeasuredRod rod;
  rod.name = "rod";
  ASSIGN_OR_RETURN(const auto n, Numbers("--rod", arguments.rod, 6, "\"R_r R_f phi tau L_r theta_th\" in mm and deg"));
  const double face_rad = n[2] == 90.0 ? toolsetter::Rod().face_rad : n[2] * kRadPerDeg;
  rod.rod = {n[0], n[1], face_rad, n[3] * kRadPerDeg, n[4], n[5] * kRadPerDeg};
  if (!arguments.rod_sigma.empty()) {
    ASSIGN_OR_RETURN(const auto s,
                     Numbers("--rod-sigma", arguments.rod_sigma, 5, "\"R_r R_f phi tau L_r\" in mm and deg"));
    rod.sigma = {s[0], s[1], s[2] * kRadPerDeg, s[3] * kRadPerDeg, s[4]};
  }
  rods.rods.push_back(rod);
  return rods;
}

// 1 sigma of Zd from what is stated of beam and rod.
double HeightSigmaMm(const toolsetter::RodSession& session, const toolsetter::MeasuredRod& rod,
                     const toolsetter::Trigger& trigger) {
  const double sigma[toolsetter::kTriggerInputs] = {
      session.beam_sigma.radius_mm, session.beam_sigma.yaw_rad, session.beam_sigma.pitch_rad, rod.sigma.radius_mm,
      rod.sigma.fillet_mm,          rod.sigma.face_rad,         rod.sigma.azimuth_rad};
  double variance = 0.0;
  for (int i = 0; i < toolsetter::kTriggerInputs; ++i) variance += std::pow(trigger.by_input[i] * sigma[i], 2);
  return std::sqrt(variance);
}

absl::Status PrintTriggers(Context& context, const ToolsetterArguments& arguments) {
  ASSIGN_OR_RETURN(const toolsetter::RodSession session, RodsOf(arguments));
  Json rows = Json::Array();
  std::vector<std::vector<std::string>> table = {
      {"rod", "Zd mm", "+- um", "um per 0.1 deg yaw", "um per 0.1 deg pitch"}};
  for (const toolsetter::MeasuredRod& rod : session.rods) {
    auto trigger = toolsetter::TriggerOf(rod.rod, session.beam);
    if (!trigger.ok()) return base::Within(rod.name, trigger.status());
    const double sigma_um = HeightSigmaMm(session, rod, *trigger) * base::kUmPerMm;
    const auto& by = trigger->by_input;
    const double per_deg = base::kUmPerMm * base::kRadPerDeg;
    rows.push_back({{"rod", rod.name},
                    {"trigger_height_mm", trigger->height_mm},
                    {"sigma_um", sigma_um},
                    {"shaded_mm2", trigger->area_mm2},
                    {"closed_form_mm", toolsetter::ClosedFormHeightMm(rod.rod, session.beam)},
                    {"um_per_mm",
                     {{"R_l", by[toolsetter::kBeamRadius] * base::kUmPerMm},
                      {"R_r", by[toolsetter::kRodRadius] * base::kUmPerMm},
                      {"R_f", by[toolsetter::kFillet] * base::kUmPerMm}}},
                    {"um_per_deg",
                     {{"yaw", by[toolsetter::kYaw] * per_deg},
                      {"pitch", by[toolsetter::kPitch] * per_deg},
                      {"phi", by[toolsetter::kFace] * per_deg},
                      {"tau", by[toolsetter::kAzimuth] * per_deg}}}});
    table.push_back({rod.name, absl::StrFormat("%.9f", trigger->height_mm), NumberText(sigma_um),
                     NumberText(by[toolsetter::kYaw] * per_deg * 0.1),
                     NumberText(by[toolsetter::kPitch] * per_deg * 0.1)});
  }
  context.Print({{"rods", rows}}, Table(table));
  return absl::OkStatus();
}

absl::StatusOr<toolsetter::ReferenceOptions> OptionsOf(const ToolsetterArguments& arguments) {
  toolsetter::ReferenceOptions options;
  const std::string& fit = arguments.fit;
  if (fit != "" && fit != "yaw" && fit != "pitch" && fit != "yaw,pitch" && fit != "pitch,yaw")
    return absl::InvalidArgumentError("--fit '" + fit + "': expected yaw, pitch or yaw,pitch");
  options.fit_yaw = fit.find("yaw") != std::string::npos;
  options.fit_pitch = fit.find("pitch") != std::string::npos;
  return options;
}

absl::StatusOr<std::string> ComputeOnService(Context& context, const ToolsetterArguments& arguments,
                                             const toolsetter::ReferenceOptions& options, records::JobRecord* queued) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  records::ToolSetterParams params;
  params.machine = MachineId(arguments.machine);
  ASSIGN_OR_RETURN(const auto sessions, NamedSessions(*client, params.machine, "--session", {arguments.session}));
  params.session = sessions[0];
  params.fit_yaw = options.fit_yaw;
  params.fit_pitch = options.fit_pitch;
  ASSIGN_OR_RETURN(*queued, client->CreateJob(params, arguments.request_id));
  if (arguments.no_wait) return std::string();
  ASSIGN_OR_RETURN(const records::JobRecord done, FollowJob(context, *client, queued->id));
  return done.result;
}

// reference and wear: one file, or one stored session of the kind that the sub-command is for.
template <typename Report>
absl::Status Evaluate(Context& context, const ToolsetterArguments& arguments) {
  if (arguments.file.empty() == arguments.session.empty() || arguments.session.empty() != arguments.machine.empty()) {
    return absl::InvalidArgumentError("toolsetter: expected either a session FILE, or --machine and --session");
  }
  ASSIGN_OR_RETURN(const toolsetter::ReferenceOptions options, OptionsOf(arguments));
  std::vector<NamedPath> inputs = {{"the session", arguments.file}};
  if (!arguments.session.empty() && context.server.empty()) inputs.push_back({"the database", context.database});
  RETURN_IF_ERROR(CheckOutputs(inputs, {{"--report", arguments.report}}));
  std::string json;
  reports::ToolSetter report;
  if (!arguments.file.empty()) {
    ASSIGN_OR_RETURN(const session::Session session, session::ReadSessionFile(arguments.file));
    ASSIGN_OR_RETURN(report, toolsetter::Evaluate(session, options));
    json = reports::ToJson(report);
  } else {
    records::JobRecord job;
    ASSIGN_OR_RETURN(json, ComputeOnService(context, arguments, options, &job));
    if (arguments.no_wait) {
      const std::string number = std::to_string(job.id.number());
      context.Print(ToJson(job), "job " + number + " is queued; follow it with: axiscal jobs watch " + number + "\n");
      return absl::OkStatus();
    }
    ASSIGN_OR_RETURN(report, reports::ReadToolSetter(json));
  }
  const Report* const asked = std::get_if<Report>(&report);
  if (asked == nullptr) {
    return absl::InvalidArgumentError(
        std::is_same_v<Report, reports::BeamReference>
            ? "reference: expected a tool-setter session, this one is a tool-curve: use wear"
            : "wear: expected a tool-curve session, this one is a tool-setter: use reference");
  }
  if (!arguments.report.empty()) RETURN_IF_ERROR(base::WriteFileAtomically(arguments.report, json));
  context.Print(Json::Document(json), ToText(*asked));
  return absl::OkStatus();
}

void AddSources(CLI::App& command, ToolsetterArguments& arguments) {
  command.add_option("FILE", arguments.file, "a session file, without any database");
  command.add_option("--machine", arguments.machine, "the machine of a stored session");
  command.add_option("--session", arguments.session, "the stored session, by number or name");
  command.add_option("--report", arguments.report, "write the report as JSON");
  command.add_option("--request-id", arguments.request_id, "repeat under the same id to get the same job");
  command.add_flag("--no-wait", arguments.no_wait, "print the job and return at once");
}

}  // namespace

void AddToolSetterCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<ToolsetterArguments>();
  CLI::App* toolsetter = app.add_subcommand("toolsetter",
                                            "Laser tool setter: trigger heights of measuring rods, the beam's "
                                            "reference, length and wear of round-insert mills");
  toolsetter->require_subcommand(1);

  CLI::App* trigger = toolsetter->add_subcommand(
      "trigger", "How high a rod's bottom centre stands above the beam's reference point when the trigger fires");
  trigger->add_option("FILE", arguments->file, "a tool-setter session: its beam and rods");
  trigger->add_option("--beam", arguments->beam, "\"R_l yaw pitch\" in mm and deg, instead of the file's");
  trigger->add_option("--beam-sigma", arguments->beam_sigma, "their standard deviations");
  trigger->add_option("--rod", arguments->rod, "\"R_r R_f phi tau L_r theta_th\" in mm and deg, without a file");
  trigger->add_option("--rod-sigma", arguments->rod_sigma, "standard deviations of R_r R_f phi tau L_r");
  trigger->footer(
      "phi is the elevation of the end face's normal: 90 where the face is square to the axis.\n"
      "Examples: axiscal toolsetter trigger rods.csv\n"
      "          axiscal toolsetter trigger --beam \"0.2 0.6241 0.2836\" --rod \"5 0.03 88.041 144.086 179.822 0\"");
  SetAction(trigger, context, [&context, arguments] { return PrintTriggers(context, *arguments); });

  CLI::App* reference =
      toolsetter->add_subcommand("reference", "Z of the beam's reference point from the readouts of several rods");
  AddSources(*reference, *arguments);
  reference->add_option("--fit", arguments->fit, "find the beam's yaw, pitch or both (yaw,pitch) as well");
  reference->footer(
      "Rods that disagree more than their readouts and stated errors explain widen the uncertainty. What the rods "
      "cannot "
      "tell gets no\nnumber.\n"
      "Examples: axiscal toolsetter reference rods.csv\n"
      "          axiscal toolsetter reference --machine cmx50u --session rods-tuesday --fit pitch");
  SetAction(reference, context,
            [&context, arguments] { return Evaluate<reports::BeamReference>(context, *arguments); });

  CLI::App* wear =
      toolsetter->add_subcommand("wear", "Tool length and each insert's wear from readings at several start angles");
  AddSources(*wear, *arguments);
  wear->footer(
      "The exact curve is fitted, phase included. The longest insert counts as unworn; inserts are counted in the "
      "order "
      "in which they\npass the beam. An insert that never fires gets a bound and a feed that would show it.\n"
      "Examples: axiscal toolsetter wear curve.csv\n"
      "          axiscal toolsetter wear --machine cmx50u --session mill-7");
  SetAction(wear, context, [&context, arguments] { return Evaluate<reports::Wear>(context, *arguments); });

  AddToolSetterCurve(*toolsetter, context);
  AddToolSetterPlan(*toolsetter, context);
}

}  // namespace axiscal::cli
