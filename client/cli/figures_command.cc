// axiscal figures: positioning, circular deviation, reversal and straightness of measured sessions.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "absl/strings/str_join.h"
#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/machine_source.h"
#include "client/cli/output_paths.h"
#include "client/cli/session_choice.h"
#include "core/base/units.h"
#include "core/figures/eccentricities.h"
#include "core/figures/figures.h"
#include "core/identify/identify.h"
#include "core/session/write_session.h"

namespace axiscal::cli {
namespace {

struct FiguresArguments {
  std::string machine, eccentricities;
  std::vector<std::string> sessions;
};

double InUm(double mm) { return mm * base::kUmPerMm; }

Json DirectionJson(const std::optional<figures::Direction>& direction) {
  if (!direction) return Json();
  Json json = {{"approaches", direction->approaches}, {"mean", InUm(direction->mean_mm)}};
  json["standard_deviation"] = direction->deviation_mm ? Json(InUm(*direction->deviation_mm)) : Json();
  return json;
}

Json TestJson(const figures::MeasuredTest& test) {
  Json values = Json::Array();
  for (const figures::Figure& figure : test.figures)
    values.push_back({{"symbol", figure.symbol},
                      {"text", figure.text},
                      {"value", InUm(figure.value_mm)},
                      {"sigma", InUm(figure.sigma_mm)},
                      {"of_noise", InUm(figure.of_noise_mm)}});
  Json json = {
      {"kind", test.kind}, {"what", test.what}, {"sessions", test.sessions}, {"unit", test.unit}, {"figures", values}};
  if (test.temperature_celsius) json["temperature_celsius"] = *test.temperature_celsius;
  if (test.positioning) {
    Json targets = Json::Array();
    for (const figures::Target& target : test.positioning->targets)
      targets.push_back(
          {{"target", target.target}, {"up", DirectionJson(target.up)}, {"down", DirectionJson(target.down)}});
    json["targets"] = targets;
  }
  json["notes"] = test.notes;
  return json;
}

std::string TestText(const figures::MeasuredTest& test) {
  std::string text = absl::StrCat(test.what, " (", absl::StrJoin(test.sessions, ", "), ")");
  if (test.temperature_celsius) absl::StrAppendFormat(&text, ", at %.1f deg C", *test.temperature_celsius);
  std::vector<std::vector<std::string>> rows = {{"", test.unit, "sigma", "noise alone", ""}};
  for (const figures::Figure& figure : test.figures)
    rows.push_back({figure.symbol, NumberText(InUm(figure.value_mm)), NumberText(InUm(figure.sigma_mm)),
                    NumberText(InUm(figure.of_noise_mm)), figure.text});
  absl::StrAppend(&text, "\n", test.figures.empty() ? "" : Table(rows));
  for (const std::string& note : test.notes) absl::StrAppend(&text, "note: ", note, "\n");
  return text;
}

absl::Status ShowFigures(Context& context, const FiguresArguments& arguments) {
  std::vector<NamedPath> inputs = {{"--machine", arguments.machine}};
  for (const std::string& name : arguments.sessions) inputs.emplace_back("SESSION", name);
  RETURN_IF_ERROR(CheckOutputs(inputs, {{"--eccentricities", arguments.eccentricities}}));
  ASSIGN_OR_RETURN(const machine::Machine machine, MachineFrom(context, arguments.machine));
  std::vector<session::Session> sessions;
  for (const std::string& name : arguments.sessions) {
    ASSIGN_OR_RETURN(sessions.emplace_back(), SessionFrom(context, machine, "figures", name));
  }
  ASSIGN_OR_RETURN(const std::vector<instruments::MeasuringRun> runs, identify::BindSessions(machine, sessions));
  const figures::Figures made = figures::FiguresOf(machine, runs);
  Json tests = Json::Array();
  std::string text;
  for (const figures::MeasuredTest& test : made.tests) {
    tests.push_back(TestJson(test));
    absl::StrAppend(&text, text.empty() ? "" : "\n", TestText(test));
  }
  for (const std::string& left_out : made.left_out) absl::StrAppend(&text, "left out: ", left_out, "\n");
  Json json = {{"tests", tests}, {"left_out", made.left_out}};
  if (!arguments.eccentricities.empty()) {
    ASSIGN_OR_RETURN(const session::Session session,
                     figures::EccentricitySession(machine, sessions,
                                                  std::filesystem::path(arguments.eccentricities).stem().string()));
    RETURN_IF_ERROR(session::WriteSessionFile(session, arguments.eccentricities));
    absl::StrAppend(&text, arguments.eccentricities, ": ", session.reading_count(), " eccentricities of ",
                    sessions.size(), " runs\n");
    json["eccentricities"] = arguments.eccentricities;
  }
  context.Print(json, text);
  if (made.tests.empty()) return absl::InvalidArgumentError("figures: none of these sessions has any");
  return absl::OkStatus();
}

}  // namespace

void AddFiguresCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<FiguresArguments>();
  CLI::App* command = app.add_subcommand(
      "figures", "Positioning (A, R, E, B, M), circular deviation (G, F), reversal, straightness of measured sessions");
  command->add_option("SESSION", arguments->sessions, "session files, or stored sessions by number or name")
      ->required();
  command->add_option("--machine", arguments->machine, "a machine.json or a stored machine")->required();
  command->add_option(
      "--eccentricities", arguments->eccentricities,
      "FILE.csv: of ball-bar runs in which one rotary axis turns, their eccentricities by run and sense as "
      "a session");
  command->footer(
      "Both senses of a circle, and all of a line's approaches, make one test. Formulas, and what is assumed of the\n"
      "standards: docs/figures.md.\n"
      "Example: axiscal figures --machine machine.json circle-XY-ccw.csv circle-XY-cw.csv X-line.csv");
  SetAction(command, context, [&context, arguments] { return ShowFigures(context, *arguments); });
}

}  // namespace axiscal::cli
