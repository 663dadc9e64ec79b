// axiscal predict: what a machine's errors do to the tool at poses, or to the readings of a session.
#include <CLI/CLI.hpp>
#include <memory>

#include "absl/strings/str_join.h"
#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/error_model_source.h"
#include "client/cli/output_paths.h"
#include "client/cli/rewrite_arguments.h"
#include "core/base/files.h"
#include "core/base/units.h"
#include "core/machine/redundant_facts.h"
#include "core/predict/poses.h"
#include "core/predict/readings.h"
#include "core/session/check_machine.h"
#include "core/session/read_session.h"

namespace axiscal::cli {
namespace {

struct PredictArguments {
  std::string poses, session, machine, errors, output, tool_tip;
  int64_t calibration = 0;
};

absl::Status CheckPredictArguments(const Context& context, const PredictArguments& arguments) {
  if (arguments.poses.empty() == arguments.session.empty())
    return absl::InvalidArgumentError("predict: expected either POSES or --instrument SESSION");
  if (!arguments.session.empty() && !arguments.tool_tip.empty())
    return absl::InvalidArgumentError("--tool-tip: the session of --instrument states its own, expected none");
  if (arguments.session.empty() && arguments.tool_tip.empty())
    return absl::InvalidArgumentError("predict: expected --tool-tip with POSES: the error is that of this point");
  std::vector<NamedPath> inputs = {{"POSES", arguments.poses}, {"--instrument", arguments.session}};
  if (context.server.empty()) inputs.push_back({"the database", context.database});
  if (!arguments.errors.empty()) {
    inputs.push_back({"--machine", arguments.machine});
    inputs.push_back({"--errors", arguments.errors});
  }
  return CheckOutputs(inputs, {{"--output", arguments.output}});
}

// How good the prediction is said to be, and what is left out of that.
std::vector<std::string> NotesOf(const MachineWithKnownErrors& known, bool is_tool_point) {
  std::vector<std::string> notes;
  if (known.errors.covariance.is_empty()) {
    notes.push_back("no sigmas: the errors have no covariance");
  } else if (const auto exact = predict::TakenForExact(known.machine, known.errors); !exact.empty()) {
    notes.push_back(absl::StrCat("taken for exact, the covariance does not name them: ", absl::StrJoin(exact, ", ")));
  }
  for (const machine::ErrorTerm& term : known.errors.model.terms) {
    if (is_tool_point && shapes::IsAlongApproach(term.shape))
      notes.push_back(
          absl::StrCat(machine::NameOf(known.machine, term), " acts on touches only and moves no tool point"));
  }
  return notes;
}

std::string NotesText(const std::vector<std::string>& notes) {
  std::string text;
  for (const std::string& note : notes) absl::StrAppend(&text, "note: ", note, "\n");
  return text;
}

absl::Status PredictTool(Context& context, const PredictArguments& arguments, const MachineWithKnownErrors& known) {
  ASSIGN_OR_RETURN(const Eigen::Vector3d tip_mm, ToolTip(arguments.tool_tip));
  RETURN_IF_ERROR(base::Within("--tool-tip", machine::CheckToolTip(known.machine, tip_mm)));
  ProgressBar bar = context.Bar("predicting");
  ASSIGN_OR_RETURN(const predict::PredictedPoses made,
                   predict::PredictPoses(arguments.poses, arguments.output, known.machine, known.errors, tip_mm,
                                         [&bar](double fraction) { bar.Show(fraction, ""); }));
  const std::vector<std::string> notes = NotesOf(known, true);
  Json json = {{"rows", static_cast<int64_t>(made.rows)},
               {"rms_um", made.rms_mm * base::kUmPerMm},
               {"max_um", made.max_mm * base::kUmPerMm},
               {"rms_urad", made.rms_rad * base::kUradPerRad},
               {"max_urad", made.max_rad * base::kUradPerRad},
               {"has_sigma", made.has_sigma},
               {"notes", notes}};
  context.Print(json, absl::StrCat(made.rows, " poses in ", arguments.output, "\n",
                                   Table({{"predicted error", "rms", "max"},
                                          {"tool point, um", NumberText(made.rms_mm * base::kUmPerMm),
                                           NumberText(made.max_mm * base::kUmPerMm)},
                                          {"tilt, urad", NumberText(made.rms_rad * base::kUradPerRad),
                                           NumberText(made.max_rad * base::kUradPerRad)}}),
                                   NotesText(notes)));
  return absl::OkStatus();
}

// A measured session, or a plan, whose readings are empty or missing.
absl::StatusOr<session::Session> SessionOrPlan(const std::string& path) {
  absl::StatusOr<session::Session> measured = session::ReadSessionFile(path);
  if (measured.ok() || absl::IsNotFound(measured.status())) return measured;
  absl::StatusOr<session::Session> plan = session::ReadPlanFile(path);
  return plan.ok() ? plan : measured;
}

absl::Status PredictSession(Context& context, const PredictArguments& arguments, const MachineWithKnownErrors& known) {
  ASSIGN_OR_RETURN(session::Session session, SessionOrPlan(arguments.session));
  ProgressBar bar = context.Bar("predicting");
  auto made = predict::PredictReadings(std::move(session), known.machine, known.errors,
                                       [&bar](double fraction) { bar.Show(fraction, ""); });
  if (!made.ok()) return base::Within(arguments.session, made.status());
  RETURN_IF_ERROR(base::WriteFileAtomically(arguments.output, predict::ToCsv(*made)));
  const std::vector<std::string> notes = NotesOf(known, false);
  context.Print(
      {{"rows", static_cast<int64_t>(made->predicted.rows())}, {"has_sigma", made->sigma.size() > 0}, {"notes", notes}},
      absl::StrCat(made->predicted.rows(), " lines of readings in ", arguments.output, "\n", NotesText(notes)));
  return absl::OkStatus();
}

absl::Status Predict(Context& context, const PredictArguments& arguments) {
  RETURN_IF_ERROR(CheckPredictArguments(context, arguments));
  ASSIGN_OR_RETURN(const MachineWithKnownErrors known,
                   arguments.errors.empty() ? FetchKnown(context, arguments.machine, arguments.calibration)
                                            : ReadKnownFiles(arguments.machine, arguments.errors));
  return arguments.session.empty() ? PredictTool(context, arguments, known) : PredictSession(context, arguments, known);
}

}  // namespace

void AddPredictCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<PredictArguments>();
  CLI::App* predict =
      app.add_subcommand("predict", "What a machine's errors do to the tool at poses, or to a session's readings");
  predict->add_option("POSES", arguments->poses, "axis positions in time order (CSV)");
  predict->add_option("-o,--output", arguments->output, "the predicted errors (CSV), a line per pose")->required();
  AddModelOptions(*predict, arguments->machine, arguments->errors, arguments->calibration);
  predict->add_option("--tool-tip", arguments->tool_tip,
                      "nominal tool point at home (all axes at zero), machine frame, mm: \"0 0 -350\"");
  predict->add_option("--instrument", arguments->session,
                      "a session or plan (CSV): predict its readings instead, with its set-up as stated");
  predict->footer(
      "POSES has a session's axis columns (X_mm, B_deg ...), and t_s and temp_C where an error depends on them; no "
      "readings.\n"
      "Rows stand in time order: they move the axes as those of a session do (backlash, lag ...). The output has\n"
      "ex_um,ey_um,ez_um, the tool point's error in the table's frame, and ea_urad,eb_urad,ec_urad, the tool's tilt: "
      "actual - nominal;\n"
      "then the standard uncertainty of each, where the errors come with a covariance (docs/formats.md, \"Poses\").\n"
      "Examples: axiscal predict --machine machine.json --errors errors.json --tool-tip \"0 0 -350\" poses.csv -o "
      "out.csv\n"
      "          axiscal predict --machine mt --instrument tuesday/check/BX.csv -o readings.csv");
  SetAction(predict, context, [&context, arguments] { return Predict(context, *arguments); });
}

}  // namespace axiscal::cli
