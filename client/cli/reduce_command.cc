// axiscal reduce: a controller's log becomes a session file, without any database.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/machine_source.h"
#include "client/cli/output_paths.h"
#include "core/base/files.h"
#include "core/logs/reduce.h"
#include "core/records/log.h"
#include "core/session/read_session.h"
#include "core/session/write_session.h"

namespace axiscal::cli {
namespace {

struct ReduceArguments {
  std::string log, log_template, plan, machine, session, output;
  std::optional<double> start_s;
};

absl::StatusOr<logs::LogTemplate> TemplateOf(const std::string& name) {
  const std::vector<std::string>& known = logs::KnownFormats();
  if (std::find(known.begin(), known.end(), name) != known.end()) return logs::FindFormat(name);
  auto text = base::ReadFile(name, records::kMaxTemplateBytes);
  if (absl::IsNotFound(text.status())) {
    return absl::NotFoundError(absl::StrCat(
        "--template ", name, ": no such file, expected a template or one of dprnt, linuxcnc-probe, sinumerik-write"));
  }
  if (!text.ok()) return text.status();
  return logs::ParseTemplate(*text, name);
}

absl::Status ReduceLog(Context& context, const ReduceArguments& arguments) {
  std::vector<NamedPath> inputs = {{"the log", arguments.log},
                                   {"--template", arguments.log_template},
                                   {"--plan", arguments.plan},
                                   {"--machine", arguments.machine}};
  if (context.server.empty() && !arguments.machine.empty()) inputs.push_back({"the database", context.database});
  RETURN_IF_ERROR(CheckOutputs(inputs, {{"--output", arguments.output}}));
  ASSIGN_OR_RETURN(const logs::LogTemplate log_template, TemplateOf(arguments.log_template));
  std::optional<machine::Machine> machine;
  if (!arguments.machine.empty()) {
    ASSIGN_OR_RETURN(machine, MachineFrom(context, arguments.machine));
  }
  std::optional<session::Session> plan;
  if (!arguments.plan.empty()) {
    ASSIGN_OR_RETURN(plan, session::ReadPlanFile(arguments.plan));
  }
  RETURN_IF_ERROR(base::RequireFile(arguments.log));
  std::ifstream in(arguments.log, std::ios::binary);
  if (!in) return absl::InvalidArgumentError(arguments.log + ": cannot be opened");
  ASSIGN_OR_RETURN(const logs::Reduced reduced, logs::Reduce(in, arguments.log, log_template,
                                                             {.machine = machine ? &*machine : nullptr,
                                                              .plan = plan ? &*plan : nullptr,
                                                              .session = arguments.session,
                                                              .start_s = arguments.start_s}));
  RETURN_IF_ERROR(session::WriteSessionFile(reduced.session, arguments.output));
  const std::string name = session::FindHeader(reduced.session, "session").value_or("");
  const std::string instrument = session::FindHeader(reduced.session, "instrument").value_or("");
  Json cut;
  if (reduced.cut) cut = {{"line", reduced.cut->line}, {"text", reduced.cut->text}};
  std::string text =
      absl::StrCat(arguments.output, ": session ", name, ", ", instrument, ", ", reduced.session.reading_count(),
                   " readings from lines ", reduced.lines.front(), " to ", reduced.lines.back(), "\n");
  for (const std::string& note : reduced.notes) absl::StrAppend(&text, "note: ", note, "\n");
  context.Print({{"session", name},
                 {"instrument", instrument},
                 {"readings", reduced.session.reading_count()},
                 {"file", arguments.output},
                 {"cut_line", cut},
                 {"notes", reduced.notes},
                 {"is_checked_against_machine", machine.has_value()}},
                text);
  return absl::OkStatus();
}

}  // namespace

void AddReduceCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<ReduceArguments>();
  CLI::App* reduce = app.add_subcommand(
      "reduce", "Turn a controller's log (DPRNT, LinuxCNC probe log, any table) into a session file");
  reduce->add_option("LOG", arguments->log, "what the controller wrote")->required();
  reduce
      ->add_option(
          "--template", arguments->log_template,
          "how its lines look: a file (docs/logs.md), or dprnt, linuxcnc-probe or sinumerik-write together with --plan")
      ->required();
  reduce->add_option("-o,--output", arguments->output, "the session file")->required();
  reduce->add_option("--plan", arguments->plan,
                     "the planned session that was run (axiscal plan TEST -o FILE.csv): brings the header and what was "
                     "planned (poses, features, approaches, rods), line by line");
  reduce->add_option(
      "--machine", arguments->machine,
      "the machine, or its machine.json without any database: axes, travel and gates are checked; centres "
      "of a sphere are computed from touches with it");
  reduce->add_option("--session", arguments->session, "name of the session, in place of the template's");
  reduce->add_option("--start-s", arguments->start_s, "t_s of the first reading, where the log has no times");
  reduce->footer(
      "A line that no rule of the template names is refused with its line and column. A cut last line is left out, "
      "reported, and\nkept as header `cut_line`.\n"
      "Template: header lines of the session '# key: value', then rules\n"
      "  format: dprnt | linuxcnc-probe | sinumerik-write        or\n"
      "  line: X{X_mm} Y{Y_mm} Z{Z_mm} B{B_deg}    a reading; {*} is passed over; tagged fields come in any order\n"
      "  skip: TEXT {*}                        a line that says nothing (as often as needed)\n"
      "  count: Number of Points {count}       how many readings follow: reported where they do not\n"
      "  mark: Feature {feature}               what the touches that follow are of (of a tool setter: {rod})\n"
      "  feature: NAME                         or all of one feature\n"
      "  approach: feature | nx ny nz          along the feature's inward normal (needs --machine), or one direction\n"
      "  axis: X SCALE OFFSET                  position = SCALE * logged + OFFSET\n"
      "  seconds: 6                            from reading to reading, where the log has no {t_s}\n"
      "Examples: axiscal reduce probe.log --template ball.txt --machine machine.json -o ball.csv\n"
      "          axiscal reduce probe.log --template dprnt --plan touch-columns-C.csv --session monday -o monday.csv\n"
      "          axiscal reduce probe-results.txt --template linuxcnc-probe --plan plan.csv --machine mill -o "
      "mill.csv");
  SetAction(reduce, context, [&context, arguments] { return ReduceLog(context, *arguments); });
}

}  // namespace axiscal::cli
