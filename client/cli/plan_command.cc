// axiscal plan: what the known measuring tests of a machine can see, which set determines what is asked, and the axis
// table or NC program of one.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/machine_source.h"
#include "client/cli/output_paths.h"
#include "client/cli/plan_certificate.h"
#include "client/cli/toolsetter_plan.h"
#include "core/base/files.h"
#include "core/base/json_limits.h"
#include "core/base/units.h"
#include "core/machine/error_json.h"
#include "core/machine/redundant_facts.h"
#include "core/plan/program.h"
#include "core/plan/state_setups.h"
#include "core/plan/survey.h"
#include "core/session/text.h"

namespace axiscal::cli {
namespace {

struct PlanArguments {
  std::string machine, test, output, tool_tip, ball, model;
  std::vector<std::string> asked, declared, with, travels, beam_at;
  CertificateArguments certificate;
  std::optional<double> bar_mm;
  bool list = false;
  plan::ProgramOptions program;
  ToolSetterPlan tools;
};

absl::StatusOr<std::vector<Eigen::Vector3d>> Point(const std::string& option, const std::string& text) {
  if (text.empty()) return std::vector<Eigen::Vector3d>();
  std::vector<double> numbers;
  constexpr double kMostMm = 1e5;  // as in session files
  const bool are_near = session::ParseNumbers(text, &numbers) && numbers.size() == 3 &&
                        std::all_of(numbers.begin(), numbers.end(), [](double mm) { return std::abs(mm) <= kMostMm; });
  if (!are_near) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%s '%s': expected \"x y z\" in mm within +-%g", option, text, kMostMm));
  }
  return std::vector<Eigen::Vector3d>{{numbers[0], numbers[1], numbers[2]}};
}

absl::StatusOr<plan::Situation> SituationOf(const machine::Machine& machine, const PlanArguments& arguments) {
  plan::Mounted mounted;
  ASSIGN_OR_RETURN(mounted.tips_mm, Point("--tool-tip", arguments.tool_tip));
  for (const Eigen::Vector3d& tip_mm : mounted.tips_mm) {
    const absl::Status side = machine::CheckToolTip(machine, tip_mm);
    if (!side.ok()) return base::Within("--tool-tip", side);
  }
  ASSIGN_OR_RETURN(mounted.balls_mm, Point("--ball", arguments.ball));
  if (arguments.bar_mm) mounted.bars_mm = {*arguments.bar_mm};
  mounted.stylus_radius_mm = arguments.program.probing.stylus_radius_mm;
  mounted.sphere_radius_mm = arguments.program.probing.sphere_radius_mm;
  for (const auto& [option, radius_mm] : {std::make_pair("--stylus-radius", mounted.stylus_radius_mm),
                                          std::make_pair("--sphere-radius", mounted.sphere_radius_mm)}) {
    if (!(radius_mm >= 0.01 && radius_mm <= 100.0))
      return absl::InvalidArgumentError(absl::StrFormat("%s %g: expected 0.01 to 100 mm", option, radius_mm));
  }
  return plan::SituationOfMachine(machine, mounted);
}

// "A -90 0" for an axis of which machine.json states no travel.
absl::Status AddTravel(const std::string& text, machine::Machine* machine) {
  const size_t blank = text.find(' ');
  std::vector<double> limits;
  const bool are_limits = blank != std::string::npos && session::ParseNumbers(text.substr(blank + 1), &limits) &&
                          limits.size() == 2 && limits[0] < limits[1];
  const int at = machine::FindAxis(*machine, text.substr(0, blank));
  if (at >= 0 && machine->axes[at].kind == machine::AxisKind::kLinear) {
    return absl::InvalidArgumentError(absl::StrCat("--travel '", text, "': ", machine->axes[at].name,
                                                   " is linear, expected a rotary axis; the travel of a linear one is "
                                                   "travel_mm of machine.json, [MIN, MAX] in mm"));
  }
  if (!are_limits || at < 0) {
    return absl::InvalidArgumentError(absl::StrCat("--travel '", text,
                                                   "': expected \"AXIS MIN MAX\", a rotary axis of machine ",
                                                   machine->id, " and its limits in deg"));
  }
  machine::Axis& axis = machine->axes[at];
  if (axis.min_position && axis.max_position) {
    return absl::InvalidArgumentError(absl::StrCat("--travel '", text, "': machine ", machine->id,
                                                   " states the travel of ", axis.name, " itself, expected none"));
  }
  axis.min_position = limits[0] * base::kRadPerDeg;
  axis.max_position = limits[1] * base::kRadPerDeg;
  return absl::OkStatus();
}

// "Z -510", the position of a linear axis over the tool setter's beam.
absl::Status AddBeamAt(const std::string& text, const machine::Machine& machine, plan::SetterOptions* setter) {
  const size_t blank = text.find(' ');
  std::vector<double> position;
  const int axis = machine::FindAxis(machine, text.substr(0, blank));
  const bool is_position = blank != std::string::npos && session::ParseNumbers(text.substr(blank + 1), &position) &&
                           position.size() == 1 && axis >= 0 && machine.axes[axis].kind == machine::AxisKind::kLinear;
  if (!is_position)
    return absl::InvalidArgumentError(absl::StrCat("--beam-at '", text,
                                                   "': expected \"AXIS POSITION\", a linear axis of machine ",
                                                   machine.id, " and its position over the beam in mm"));
  setter->beam_at_mm[text.substr(0, blank)] = position[0];
  return absl::OkStatus();
}

std::string Joined(const std::vector<std::string>& texts, const std::string& between) {
  std::string joined;
  for (const std::string& text : texts) absl::StrAppend(&joined, joined.empty() ? "" : between, text);
  return joined;
}

std::string Minutes(double seconds) { return absl::StrFormat("%.0f min", std::ceil(seconds / 60.0)); }

Json TestJson(const plan::SurveyedTest& test, const plan::Survey& survey) {
  Json determined = Json::Array();
  for (size_t i = 0; i < survey.errors.size(); ++i) {
    if (test.is_determined[i]) determined.push_back(survey.errors[i].name);
  }
  return {{"test", test.test},         {"session", test.session},
          {"text", test.planned.text}, {"readings", test.readings},
          {"seconds", test.seconds},   {"rank", test.rank},
          {"determined", determined},  {"not_separable", test.not_separable}};
}

// `with`: the tests that were asked about; empty: all.
absl::Status List(Context& context, const plan::Survey& survey, const std::vector<std::string>& with) {
  Json tests = Json::Array();
  std::vector<std::vector<std::string>> rows = {{"session", "test", "readings", "takes", "rank"}};
  std::string text;
  for (const plan::SurveyedTest& test : survey.tests) {
    tests.push_back(TestJson(test, survey));
    rows.push_back({test.session, test.test, std::to_string(test.readings), Minutes(test.seconds),
                    absl::StrCat(test.rank, " of ", survey.errors.size())});
    absl::StrAppend(&text, test.session, ": ", test.planned.text, "\n",
                    test.not_separable.empty() ? "" : "  cannot tell: " + Joined(test.not_separable, "; ") + "\n");
  }
  std::vector<std::string> names;
  for (const identify::Estimate& error : survey.errors) names.push_back(error.name);
  Json runnable = Json::Array(), other = Json::Array();
  std::string not_here;
  for (const plan::Test* test : plan::TestsWithoutSession(survey)) {
    if (!with.empty() && std::find(with.begin(), with.end(), test->name) == with.end()) continue;
    other.push_back({{"test", test->name}, {"summary", test->summary}});
    absl::StrAppend(&not_here, "not on this machine as it stands: ", test->name, " (", test->summary, ")\n");
  }
  Json tool_setter = Json::Array();
  for (const toolsetter::PlannableTest& test : toolsetter::PlannableTests()) {
    if (!with.empty() && std::find(with.begin(), with.end(), test.name) == with.end()) continue;
    tool_setter.push_back({{"test", test.name}, {"summary", test.summary}, {"tools", test.file}});
    absl::StrAppend(&not_here, "of tools, not of the machine's errors: ", test.name, " --tools FILE (", test.summary,
                    "; FILE is ", test.file, ")\n");
  }
  context.Print({{"errors", names}, {"tests", tests}, {"not_runnable", other}, {"tool_setter", tool_setter}},
                absl::StrCat("errors: ", Joined(names, ", "), "\n", Table(rows), text, not_here));
  return absl::OkStatus();
}

// "EX0C" or "EX0C=2": an error, and the standard uncertainty that is wanted of it, um or urad.
struct Asked {
  std::vector<std::string> symbols;
  std::vector<double> wanted;  // infinite where none is stated
  bool is_wanted = false;
};

absl::StatusOr<Asked> AskedOf(const std::vector<std::string>& texts) {
  Asked asked;
  for (const std::string& text : texts) {
    const size_t equals = text.find('=');
    std::vector<double> sigma = {INFINITY};
    if (equals != std::string::npos) {
      if (!session::ParseNumbers(text.substr(equals + 1), &sigma) || sigma.size() != 1 || !(sigma[0] > 0.0))
        return absl::InvalidArgumentError(
            absl::StrCat("--for ", text, ": expected ERROR=SIGMA with a standard uncertainty above 0, um or urad"));
      asked.is_wanted = true;
    }
    asked.symbols.push_back(text.substr(0, equals));
    asked.wanted.push_back(sigma[0]);
  }
  return asked;
}

absl::Status Propose(Context& context, const plan::Situation& situation, plan::Survey survey, const Asked& asked_for) {
  ASSIGN_OR_RETURN(const std::vector<int> asked, plan::IndicesOf(survey, asked_for.symbols));
  std::vector<double> wanted;
  for (size_t i = 0; i < asked.size() && asked_for.is_wanted; ++i)
    wanted.push_back(asked_for.wanted[i] * survey.errors[asked[i]].factor);
  if (asked_for.is_wanted) RETURN_IF_ERROR(plan::AddPasses(situation, &survey));
  const plan::Proposal proposal = plan::ProposeTests(survey, asked, wanted);
  Json tests = Json::Array(), errors = Json::Array();
  std::string text;
  for (const int test : proposal.tests) {
    tests.push_back(TestJson(survey.tests[test], survey));
    absl::StrAppend(&text, survey.tests[test].session, ": ", survey.tests[test].planned.text, " (",
                    survey.tests[test].test, ")\n");
  }
  std::vector<std::vector<std::string>> rows = {{"error", "expected +-", ""}};
  for (size_t i = 0; i < asked.size(); ++i) {
    const identify::Estimate& error = survey.errors[asked[i]];
    const bool is_told = std::isfinite(proposal.sigma[i]);
    Json json = {{"symbol", error.name},
                 {"identifiable", is_told},
                 {"sigma", is_told ? Json(proposal.sigma[i] / error.factor) : Json()},
                 {"unit", error.unit}};
    if (asked_for.is_wanted && std::isfinite(proposal.best[i])) json["best"] = proposal.best[i] / error.factor;
    errors.push_back(json);
    const bool is_short = !is_told && asked_for.is_wanted && std::isfinite(proposal.best[i]);
    rows.push_back({error.name,
                    is_told    ? NumberText(proposal.sigma[i] / error.factor)
                    : is_short ? "not within " + NumberText(asked_for.wanted[i]) + ": all known tests together reach " +
                                     NumberText(proposal.best[i] / error.factor)
                               : "no known test tells",
                    error.unit});
  }
  context.Print({{"tests", tests}, {"errors", errors}, {"seconds_with_mounting", proposal.seconds}},
                absl::StrCat(text, Table(rows),
                             proposal.tests.empty() ? "no set of these tests tells any of them beside the other errors "
                                                      "(--list says what each cannot separate, --declare fewer)\n"
                                                    : "takes about " + Minutes(proposal.seconds) + " with mounting\n"));
  return absl::OkStatus();
}

std::vector<std::string> KnownTests() {
  std::vector<std::string> known = plan::TestNames();
  for (const toolsetter::PlannableTest& test : toolsetter::PlannableTests()) known.push_back(test.name);
  return known;
}

// A session's name, or a test's: then its first session.
absl::Status WriteTest(Context& context, const machine::Machine& machine, const plan::Situation& situation,
                       const PlanArguments& arguments) {
  if (arguments.output.empty()) return absl::InvalidArgumentError("plan: expected -o FILE for " + arguments.test);
  std::vector<NamedPath> inputs = {{"--machine", arguments.machine}};
  if (context.server.empty()) inputs.push_back({"the database", context.database});
  RETURN_IF_ERROR(CheckOutputs(inputs, {{"--output", arguments.output}}));
  std::optional<plan::PlannedSession> chosen = plan::FindPlanned(situation, arguments.test);
  if (!chosen) {
    return absl::NotFoundError(absl::StrCat("plan: '", arguments.test, "' is no test that machine ", machine.id,
                                            " can run, expected a session of --list, or one of ",
                                            Joined(KnownTests(), ", ")));
  }
  RETURN_IF_ERROR(
      base::Within("--setup", plan::StateSetups(machine, arguments.certificate.setups, {&chosen->session})));
  const std::string extension = std::filesystem::path(arguments.output).extension().string();
  std::string content;
  if (extension == ".csv") {
    content = plan::ToTable(chosen->session);
  } else {
    ASSIGN_OR_RETURN(content, plan::ToProgram(machine, chosen->session, arguments.program));
  }
  RETURN_IF_ERROR(base::WriteFileAtomically(arguments.output, content));
  const std::string name = session::FindHeader(chosen->session, "session").value_or("");
  context.Print({{"session", name},
                 {"text", chosen->text},
                 {"readings", chosen->session.reading_count()},
                 {"file", arguments.output},
                 {"kind", extension == ".csv" ? "table" : "program"}},
                absl::StrCat(arguments.output, ": ", name, ", ", chosen->session.reading_count(), " positions; ",
                             chosen->text, "\n"));
  return absl::OkStatus();
}

// Leaves only the tests that were named: the instruments at hand.
absl::Status KeepOnly(const std::vector<std::string>& with, plan::Survey* survey) {
  if (with.empty()) return absl::OkStatus();
  const std::vector<std::string> known = KnownTests();
  for (const std::string& name : with) {
    if (std::find(known.begin(), known.end(), name) == known.end())
      return absl::InvalidArgumentError(
          absl::StrCat("--with: '", name, "' is no test, expected some of ", Joined(known, ", ")));
  }
  std::erase_if(survey->tests, [&](const plan::SurveyedTest& test) {
    return std::find(with.begin(), with.end(), test.test) == with.end();
  });
  return absl::OkStatus();
}

absl::Status Plan(Context& context, const PlanArguments& arguments) {
  const bool is_certified = !arguments.certificate.sessions.empty();
  const int ways = (arguments.list ? 1 : 0) + (arguments.asked.empty() ? 0 : 1) + (arguments.test.empty() ? 0 : 1) +
                   (is_certified ? 1 : 0);
  if (ways != 1)
    return absl::InvalidArgumentError("plan: expected one of --list, --for ERRORS, --certify PLANS and TEST -o FILE");
  if (!is_certified && !(arguments.certificate.box.empty() && arguments.model.empty()))
    return absl::InvalidArgumentError("--box, --model: expected --certify with it");
  if (!arguments.model.empty() && !arguments.declared.empty())
    return absl::InvalidArgumentError("--model and --declare: expected one of them");
  if (!arguments.with.empty() && !arguments.test.empty())
    return absl::InvalidArgumentError("--with: expected --list or --for with it");
  ASSIGN_OR_RETURN(machine::Machine machine, MachineFrom(context, arguments.machine));
  if (const toolsetter::PlannableTest* const test = toolsetter::FindPlannable(arguments.test)) {
    ToolSetterPlan tools = arguments.tools;
    tools.output = arguments.output;
    tools.program = arguments.program;
    for (const std::string& text : arguments.beam_at) RETURN_IF_ERROR(AddBeamAt(text, machine, &tools.program.setter));
    return PlanToolSetterTest(context, machine, *test, tools);
  }
  if (!arguments.tools.file.empty())
    return absl::InvalidArgumentError("--tools: expected tool-setter or tool-curve with it");
  for (const std::string& travel : arguments.travels) RETURN_IF_ERROR(AddTravel(travel, &machine));
  ASSIGN_OR_RETURN(const plan::Situation situation, SituationOf(machine, arguments));
  if (const std::vector<std::string> unknown = plan::TiltingWithoutTravel(machine); !unknown.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "machine ", machine.id, ": the travel of ", Joined(unknown, ", "),
        " is not stated, and an axis that tilts does not go round: expected travel_deg in machine.json, or --travel \"",
        unknown.front(), " MIN MAX\" (deg)"));
  }
  if (!arguments.test.empty()) return WriteTest(context, machine, situation, arguments);
  ASSIGN_OR_RETURN(const Asked asked, AskedOf(arguments.asked));
  ASSIGN_OR_RETURN(machine::ErrorModel model, plan::ErrorsToJudge(machine, arguments.declared, asked.symbols));
  if (is_certified) {
    if (!arguments.model.empty()) {
      ASSIGN_OR_RETURN(const std::string text, base::ReadFile(arguments.model, base::kMaxJsonBytes));
      auto errors = machine::ReadErrors(text, machine);
      if (!errors.ok()) return base::Within(arguments.model, errors.status());
      model = *std::move(errors);
      for (machine::ErrorTerm& term : model.terms) term.amplitude.fill(0.0);
    }
    return PrintCertificate(context, situation, model, arguments.certificate);
  }
  auto survey = plan::SurveyTests(situation, model, arguments.certificate.setups);
  if (!survey.ok()) return base::Within("plan", survey.status());
  RETURN_IF_ERROR(KeepOnly(arguments.with, &*survey));
  return arguments.list ? List(context, *survey, arguments.with)
                        : Propose(context, situation, *std::move(survey), asked);
}

}  // namespace

void AddPlanCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<PlanArguments>();
  CLI::App* plan = app.add_subcommand(
      "plan", "Measuring tests: what each can see, which set tells the errors that are asked for, and their programs");
  plan->add_option("TEST", arguments->test, "a session of --list, or a test's name for its first session");
  plan->add_option("--machine", arguments->machine, "the machine, or its machine.json without any database")
      ->required();
  plan->add_flag("--list", arguments->list,
                 "the tests that this machine can run, with rank, time and what they cannot tell");
  plan->add_option("--for", arguments->asked,
                   "propose the tests that determine these errors in the least time; EX0C=2: to a standard uncertainty "
                   "of 2 um (urad), with tests in several passes where that pays")
      ->delimiter(',');
  plan->add_option(
          "--certify", arguments->certificate.sessions,
          "what these plans (files, sessions of --list) reach together: uncertainties, the tool point over the "
          "box, what they do not show")
      ->delimiter(',');
  plan->add_option("--setup", arguments->certificate.setups,
                   "\"OFFSET SIGMA\" in um (urad), what is known of a set-up: \"artefact_x 2\", \"ball_z 5\"; "
                   "repeatable; written into plans")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  plan->add_option("--box", arguments->certificate.box,
                   "of --certify: range of an axis, mm or deg: \"X -200 300\"; repeatable (default: the travel that "
                   "machine.json states, else what the plans cover)")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  plan->add_option(
      "--model", arguments->model,
      "of --certify: an errors.json whose errors, of any shape, count as unknown; its numbers are not used");
  plan->add_option("--with", arguments->with,
                   "of --list and --for: only these tests, those whose instrument is at hand")
      ->delimiter(',');
  plan->add_option("--declare", arguments->declared,
                   "errors that count as unknown, instead of the machine's declared ones")
      ->delimiter(',');
  plan->add_option("-o,--output", arguments->output,
                   "FILE.csv: the axis table, a session without readings, the plan for axiscal reduce; else the NC "
                   "program");
  plan->add_option("--dialect", arguments->program.dialect, "of the program: " + Joined(plan::ProgramDialects(), ", "))
      ->capture_default_str();
  plan->add_option("--feed", arguments->program.feed_mm_min, "mm/min between poses at rest")->capture_default_str();
  plan->add_option("--dwell", arguments->program.dwell_s, "seconds at rest before a reading")->capture_default_str();
  plan->add_option("--sphere-radius", arguments->program.probing.sphere_radius_mm, "of a sphere that is probed, mm")
      ->capture_default_str();
  plan->add_option("--stylus-radius", arguments->program.probing.stylus_radius_mm, "of the touch probe, mm")
      ->capture_default_str();
  plan->add_option("--tool-tip", arguments->tool_tip, "\"x y z\": the tool point at home, machine frame, mm");
  plan->add_option("--ball", arguments->ball, "\"x y z\": the table ball at home, machine frame, mm");
  plan->add_option("--travel", arguments->travels,
                   "\"AXIS MIN MAX\" in deg, of a rotary axis whose travel machine.json does not state; repeatable")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  plan->add_option("--bar", arguments->bar_mm, "length of the ball bar, mm")->check(CLI::Range(10.0, 5000.0));
  plan->add_option("--tools", arguments->tools.file,
                   "of tool-setter a session whose rods are meant, of tool-curve a cutter.json");
  plan->add_option(
          "--beam-at", arguments->beam_at,
          "of a tool setter's program: \"AXIS POSITION\" in mm of every linear axis, where the spindle's reference "
          "point (a mill's lowest point) stands in the beam; repeatable")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  plan->add_option("--setter-feed", arguments->program.setter.feed_mm_min, "of a rod onto the beam, mm/min")
      ->capture_default_str();
  AddToolSetterOptions(*plan, arguments->tools);
  plan->footer(
      "A machine that declares no errors is judged by all location errors of its axes.\n"
      "An axis that tilts (a head, a table that is tipped) needs its travel_deg in machine.json, or --travel.\n"
      "Examples: axiscal plan --machine machine.json --list --tool-tip \"0 0 -350\" --travel \"B -30 120\"\n"
      "          axiscal plan --machine mt --for EX0C,EB0C --tool-tip \"0 0 -350\"\n"
      "          axiscal plan --machine mt --for EX0C,EB0C --with touch-columns,touch-sphere --ball \"0 0 60\"\n"
      "          axiscal plan --machine mt touch-columns --ball \"0 0 60\" --stylus-radius 3 --dialect fanuc -o "
      "probe.nc\n"
      "          axiscal plan --machine mt --for EX0C=2,EB0C=5 --tool-tip \"0 0 -350\"\n"
      "          axiscal plan --machine mt --certify touch-blocks --setup \"artefact_x 2\" --ball \"0 0 60\"\n"
      "          axiscal plan --machine mt tool-curve --tools cutter.json --starts 12 -o starts.csv\n"
      "          axiscal plan --machine mt CR-350 --tool-tip \"0 0 -350\" --dialect mazak -o CR.nc");
  SetAction(plan, context, [&context, arguments] { return Plan(context, *arguments); });
}

}  // namespace axiscal::cli
