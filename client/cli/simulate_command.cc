// axiscal simulate: sessions of a machine whose errors are known, with the truth, as a case folder.
#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <set>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/simulate_history.h"
#include "core/base/files.h"
#include "core/base/json_limits.h"
#include "core/base/units.h"
#include "core/machine/error_json.h"
#include "core/machine/machine_json.h"
#include "core/plan/test.h"
#include "core/session/case.h"
#include "core/session/check_machine.h"
#include "core/session/read_session.h"
#include "core/session/write_session.h"
#include "core/synthetic/scenario.h"

namespace axiscal::cli {
namespace {

constexpr int kBoxPoses = 400;  // as many as tell the rms of a smooth error over a box to some percent

struct SimulateArguments {
  std::string scenario, output, form = "own";
  uint64_t seed = 1;
  bool is_history = false;
  HistoryArguments history;
};

// Names in a scenario count from its folder.
std::string Beside(const std::string& scenario, const std::string& path) {
  return (std::filesystem::path(scenario).parent_path() / path).string();
}

absl::StatusOr<machine::Machine> TrueMachine(const std::string& scenario, const synthetic::PlanSource& source) {
  return machine::ReadMachineFile(
      Beside(scenario, source.machine.empty() ? source.case_folder + "/machine.json" : source.machine));
}

// The same as a session that will have readings: what it lacks is told before anything is drawn.
absl::Status CheckPlan(const session::Session& planned, const machine::Machine& machine) {
  ASSIGN_OR_RETURN(const session::Session whole, synthetic::WithReadingColumns(machine, planned));
  return session::CheckAgainstMachine(whole, machine);
}

absl::StatusOr<std::vector<session::Session>> ReadPlans(const std::vector<std::string>& paths,
                                                        const machine::Machine& machine) {
  std::vector<session::Session> plans;
  for (const std::string& path : paths) {
    ASSIGN_OR_RETURN(session::Session plan, session::ReadPlanFile(path));
    RETURN_IF_ERROR(base::Within(path, CheckPlan(plan, machine)));
    plans.push_back(std::move(plan));
  }
  return plans;
}

// The machine with the travels that only planning needs.
absl::StatusOr<machine::Machine> WithTravels(const machine::Machine& machine, const synthetic::PlanSource& source) {
  machine::Machine travelled = machine;
  for (const auto& [name, limits] : source.travel_deg) {
    const int at = machine::FindAxis(machine, name);
    if (at < 0 || machine.axes[at].kind != machine::AxisKind::kRotary)
      return absl::InvalidArgumentError(
          absl::StrCat("plan.travel_deg: '", name, "', expected a rotary axis of machine ", machine.id));
    if (machine.axes[at].min_position || machine.axes[at].max_position)
      return absl::InvalidArgumentError(absl::StrCat("plan.travel_deg: machine ", machine.id, " states the travel of ",
                                                     name, " itself, expected none"));
    travelled.axes[at].min_position = limits[0] * base::kRadPerDeg;
    travelled.axes[at].max_position = limits[1] * base::kRadPerDeg;
  }
  if (const std::vector<std::string> unknown = plan::TiltingWithoutTravel(travelled); !unknown.empty())
    return absl::InvalidArgumentError(
        absl::StrCat("plan.travel_deg: the travel of ", unknown.front(), " is not stated, expected [min, max] in deg"));
  return travelled;
}

// Two sessions of one test get names of their own.
void NameApart(std::set<std::string>* names, session::Session* session) {
  for (session::HeaderEntry& entry : session->header) {
    if (entry.key != "session") continue;
    const std::string name = entry.value;
    for (int i = 2; !names->insert(entry.value).second; ++i) entry.value = absl::StrCat(name, "-", i);
  }
}

absl::StatusOr<synthetic::PlannedCase> PlanTests(const machine::Machine& machine, const synthetic::PlanSource& source) {
  ASSIGN_OR_RETURN(const machine::Machine travelled, WithTravels(machine, source));
  plan::Mounted mounted;
  if (source.tool_tip_mm) mounted.tips_mm = {*source.tool_tip_mm};
  if (source.table_ball_mm) mounted.balls_mm = {*source.table_ball_mm};
  if (source.bar_mm) mounted.bars_mm = {*source.bar_mm};
  const plan::Situation situation = plan::SituationOfMachine(travelled, mounted);
  synthetic::PlannedCase planned;
  std::set<std::string> names;
  for (const bool is_check : {false, true}) {
    for (const std::string& test : is_check ? source.check_tests : source.tests) {
      std::optional<plan::PlannedSession> found = plan::FindPlanned(situation, test);
      if (!found)
        return absl::NotFoundError(absl::StrCat(is_check ? "plan.check_tests" : "plan.tests", ": '", test,
                                                "' is no session that machine ", machine.id,
                                                " can run; axiscal plan --list shows them"));
      NameApart(&names, &found->session);
      (is_check ? planned.check : planned.fit).push_back(std::move(found->session));
    }
  }
  return planned;
}

absl::StatusOr<synthetic::PlannedCase> PlanOf(const std::string& scenario, const machine::Machine& machine,
                                              const synthetic::PlanSource& source) {
  if (!source.tests.empty()) {
    auto planned = PlanTests(machine, source);
    if (!planned.ok()) return base::Within(scenario, planned.status());
    return planned;
  }
  std::vector<std::string> fit, check;
  if (source.case_folder.empty()) {
    for (const std::string& path : source.fit) fit.push_back(Beside(scenario, path));
    for (const std::string& path : source.check) check.push_back(Beside(scenario, path));
  } else {
    const std::string folder = Beside(scenario, source.case_folder);
    fit = session::SessionFiles(folder + "/fit");
    check = session::SessionFiles(folder + "/check");
    if (fit.empty()) return absl::NotFoundError(folder + "/fit: no session files, expected at least one *.csv");
  }
  synthetic::PlannedCase planned;
  ASSIGN_OR_RETURN(planned.fit, ReadPlans(fit, machine));
  ASSIGN_OR_RETURN(planned.check, ReadPlans(check, machine));
  return planned;
}

struct OutputFile {
  std::string path, content, session;  // `path` in the folder; `session`: its name where it is one
  size_t readings = 0;
};

absl::Status AddSessions(const std::string& folder, const std::vector<session::Session>& sessions,
                         std::vector<OutputFile>* files) {
  for (size_t i = 0; i < sessions.size(); ++i) {
    OutputFile file;
    file.session = session::FindHeader(sessions[i], "session").value_or("");
    std::string name = file.session;
    for (char& c : name) {
      if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '_') c = '-';
    }
    file.path = absl::StrFormat("%s/%02d-%s.csv", folder, i, name);
    file.readings = sessions[i].reading_count();
    auto text = session::WriteSession(sessions[i]);
    if (!text.ok()) return base::Within(absl::StrCat("session '", file.session, "'"), text.status());
    file.content = *std::move(text);
    files->push_back(std::move(file));
  }
  return absl::OkStatus();
}

// A folder of its own: what an earlier run left there would become a part of the case.
absl::Status MakeFolders(const std::string& folder, bool has_check) {
  std::error_code error;
  if (std::filesystem::exists(folder, error) &&
      (!std::filesystem::is_directory(folder, error) || !std::filesystem::is_empty(folder, error)))
    return absl::InvalidArgumentError(folder + ": is there and not empty, expected a new folder");
  std::filesystem::create_directories(folder + "/fit", error);
  if (!error && has_check) std::filesystem::create_directories(folder + "/check", error);
  if (error) return absl::InvalidArgumentError(absl::StrCat(folder, ": ", error.message()));
  return absl::OkStatus();
}

struct Sizes {
  double rms_um = 0.0, max_um = 0.0;
};

Sizes SizesOf(const std::vector<synthetic::ToolPointError>& errors) {
  Sizes sizes;
  for (const synthetic::ToolPointError& error : errors) {
    const double um = base::kUmPerMm * error.shift_mm.norm();
    sizes.rms_um += um * um / static_cast<double>(errors.size());
    sizes.max_um = std::max(sizes.max_um, um);
  }
  sizes.rms_um = std::sqrt(sizes.rms_um);
  return sizes;
}

void Report(Context& context, const SimulateArguments& arguments, const synthetic::SimulatedCase& simulated,
            const std::vector<OutputFile>& files, const Sizes& sizes) {
  Json sessions = Json::Array();
  std::vector<std::vector<std::string>> rows = {{"session", "readings", "file"}};
  for (const OutputFile& file : files) {
    if (file.session.empty()) continue;
    sessions.push_back({{"session", file.session}, {"readings", file.readings}, {"file", file.path}});
    rows.push_back({file.session, absl::StrCat(file.readings), file.path});
  }
  const bool is_all = simulated.truth.is_all_in_errors();
  std::string text =
      absl::StrCat(arguments.output, ": seed ", arguments.seed, ", form ", arguments.form, "\n", Table(rows));
  for (const synthetic::Truth::NamedEffect& effect : simulated.truth.effects) {
    absl::StrAppend(&text, "effect ", effect.name, "\n");
  }
  absl::StrAppend(&text, is_all ? "errors.json holds all that is wrong with the machine\n"
                                : "errors.json cannot hold the effects; truth.csv does\n");
  absl::StrAppendFormat(&text, "truth.csv: tool-point error at %d poses of the box: rms %s um, largest %s um\n",
                        kBoxPoses, NumberText(sizes.rms_um), NumberText(sizes.max_um));
  context.Print({{"folder", arguments.output},
                 {"seed", arguments.seed},
                 {"form", arguments.form},
                 {"sessions", sessions},
                 {"is_all_in_errors", is_all},
                 {"poses", kBoxPoses},
                 {"rms_um", sizes.rms_um},
                 {"max_um", sizes.max_um}},
                text);
}

absl::Status Simulate(Context& context, const SimulateArguments& arguments) {
  if (arguments.is_history) {
    HistoryArguments history = arguments.history;
    history.output = arguments.output;
    history.years.seed = arguments.seed;
    return SimulateHistory(context, history);
  }
  if (arguments.scenario.empty()) return absl::InvalidArgumentError("SCENARIO: missing, expected it or --history");
  ASSIGN_OR_RETURN(const std::string text, base::ReadFile(arguments.scenario, base::kMaxJsonBytes));
  const auto source = synthetic::ReadPlanSource(text);
  if (!source.ok()) return base::Within(arguments.scenario, source.status());
  ASSIGN_OR_RETURN(const machine::Machine machine, TrueMachine(arguments.scenario, *source));
  const auto scenario = synthetic::ReadScenario(text, machine);
  if (!scenario.ok()) return base::Within(arguments.scenario, scenario.status());
  ASSIGN_OR_RETURN(const synthetic::PlannedCase planned, PlanOf(arguments.scenario, machine, *source));
  const synthetic::Form form = arguments.form == "own" ? synthetic::Form::kOwn : synthetic::Form::kIndependent;
  const auto simulated = synthetic::RunScenario(machine, *scenario, planned, form, arguments.seed);
  if (!simulated.ok()) return base::Within(arguments.scenario, simulated.status());

  const synthetic::History poses = synthetic::BoxPoses(*simulated, kBoxPoses, arguments.seed);
  const auto errors = synthetic::ErrorsAlong(simulated->truth, simulated->truth.tip_mm, poses);
  std::vector<OutputFile> files = {
      {"machine.json", machine::MachineToJson(simulated->described), "", 0},
      {"truth.json", synthetic::WriteTruth(*simulated, *scenario, form, arguments.seed), "", 0},
      {"poses.csv", synthetic::WritePoses(simulated->truth, poses), "", 0},
      {"truth.csv", synthetic::WriteTruthTable(errors), "", 0}};
  if (simulated->truth.is_all_in_errors())
    files.push_back({"errors.json", machine::WriteErrors(simulated->truth.errors, machine), "", 0});
  for (const auto& [folder, sessions] :
       {std::pair("fit", &simulated->measured.fit), std::pair("check", &simulated->measured.check)}) {
    const absl::Status added = AddSessions(folder, *sessions, &files);
    if (!added.ok()) return base::Within(arguments.scenario, added);
  }
  RETURN_IF_ERROR(MakeFolders(arguments.output, !simulated->measured.check.empty()));
  for (const OutputFile& file : files)
    RETURN_IF_ERROR(base::WriteFileAtomically(absl::StrCat(arguments.output, "/", file.path), file.content));
  Report(context, arguments, *simulated, files, SizesOf(errors));
  return absl::OkStatus();
}

}  // namespace

void AddSimulateCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* simulate = app.add_subcommand(
      "simulate", "Sessions of a machine whose errors, effects and faults are known, with the truth at any pose");
  CLI::Option* scenario =
      simulate->add_option("SCENARIO", arguments->scenario, "scenario.json (docs/formats.md); not with --history");
  simulate
      ->add_option("-o,--output", arguments->output,
                   "the case folder that is made; new, or empty. With --history: the file")
      ->required();
  simulate->add_option("--seed", arguments->seed, "of all that is drawn; the same seed gives the same bytes")
      ->capture_default_str();
  CLI::Option* form =
      simulate
          ->add_option(
              "--form", arguments->form,
              "own: effects by the formulas that are fitted; independent: by other formulas of the same physics")
          ->check(CLI::IsMember({"own", "independent"}))
          ->capture_default_str();
  CLI::Option* history =
      simulate
          ->add_flag(
              "--history", arguments->is_history,
              "calibrations of many machines over years, with collisions, wear, seasons and bad calibrations, as "
              "one file (docs/formats.md, \"Simulated histories\")")
          ->excludes(scenario)
          ->excludes(form);
  simulate->add_option("--machines", arguments->history.machines, "machines of the history")
      ->needs(history)
      ->capture_default_str();
  simulate->add_option("--years", arguments->history.years.years, "years of the history")
      ->needs(history)
      ->capture_default_str();
  simulate
      ->add_option("--interval-days", arguments->history.years.interval_days, "days from calibration to calibration")
      ->needs(history)
      ->capture_default_str();
  simulate->footer(
      "Needs no database and no server. The folder is a case: axiscal close-loop reads it.\n"
      "Examples: axiscal simulate scenario.json -o tuesday --seed 7\n"
      "          axiscal simulate scenario.json -o hot --form independent && axiscal close-loop hot\n"
      "          axiscal simulate --history -o fleet.jsonl --machines 20 --years 5 --seed 3");
  SetAction(simulate, context, [&context, arguments] { return Simulate(context, *arguments); });
}

}  // namespace axiscal::cli
