// axiscal published: what a publication's own formulas make of sessions, beside the exact model, with its errata.
#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/error_model_source.h"
#include "client/cli/machine_source.h"
#include "client/cli/positive_number.h"
#include "client/cli/record_output.h"
#include "client/cli/rewrite_arguments.h"
#include "client/cli/session_choice.h"
#include "core/base/files.h"
#include "core/base/json_limits.h"
#include "core/published/comparison.h"

namespace axiscal::cli {
namespace {

struct PublishedArguments {
  std::string source, machine, errors;
  std::vector<std::string> inputs;  // sessions, or one program
  int64_t calibration = 0;
  RewriteArguments rewrite;  // of a program
  bool list = false;
};

absl::Status ListPublished(Context& context) {
  Json sources = Json::Array();
  std::string text;
  for (const published::Source& source : published::Sources()) {
    sources.push_back({{"source", source.name}, {"citation", source.citation}, {"needs", source.needs}});
    absl::StrAppend(&text, source.name, ": ", source.citation, "\n  needs ", source.needs, "\n");
  }
  context.Print({{"sources", sources}}, text);
  return absl::OkStatus();
}

Json NumberOrNull(double number) { return std::isfinite(number) ? Json(number) : Json(nullptr); }

std::string Cell(double number) {
  if (!std::isfinite(number)) return "-";
  return absl::StrFormat("%.2f", std::abs(number) < 0.005 ? 0.0 : number);  // never -0.00
}

absl::StatusOr<published::Comparison> OfSessions(Context& context, const published::Source& source,
                                                 const PublishedArguments& arguments) {
  if (!arguments.rewrite.tool_tip.empty() || !arguments.rewrite.unit.empty() || !arguments.errors.empty() ||
      arguments.calibration != 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "published: ", source.name, " is about sessions, expected no --tool-tip, --unit, --errors, --calibration"));
  }
  ASSIGN_OR_RETURN(const machine::Machine machine, MachineFrom(context, arguments.machine));
  std::vector<session::Session> sessions;
  for (const std::string& name : arguments.inputs) {
    ASSIGN_OR_RETURN(sessions.emplace_back(), SessionFrom(context, machine, "published", name));
  }
  return source.compare(machine, sessions);
}

absl::StatusOr<published::Comparison> OfProgram(Context& context, const published::Source& source,
                                                const PublishedArguments& arguments) {
  if (arguments.inputs.size() != 1)
    return absl::InvalidArgumentError(absl::StrCat("published: expected one NC program for ", source.name));
  published::Program program;
  ASSIGN_OR_RETURN(program.tool_tip_mm, ToolTip(arguments.rewrite.tool_tip));
  machine::Machine machine;
  if (arguments.errors.empty()) {
    ASSIGN_OR_RETURN(const MachineWithCalibration from,
                     FetchCalibration(context, arguments.machine, arguments.calibration));
    machine = from.machine;
    ASSIGN_OR_RETURN(program.errors, identify::ReadHeldErrors(from.calibration.content.model_json,
                                                              from.calibration.content.report_json, machine));
  } else {
    ASSIGN_OR_RETURN(machine, MachineFrom(context, arguments.machine));
    ASSIGN_OR_RETURN(const std::string text, base::ReadFile(arguments.errors, base::kMaxJsonBytes));
    auto errors = identify::ReadHeldErrors(text, machine);
    if (!errors.ok()) return base::Within(arguments.errors, errors.status());
    program.errors = *std::move(errors);
  }
  const std::string& path = arguments.inputs[0];
  ASSIGN_OR_RETURN(const nc::ByteReader reader, nc::FileReader(path));
  ASSIGN_OR_RETURN(const nc::StatedOptions stated, ToStatedOptions(arguments.rewrite, machine));
  auto poses = nc::ReadPoses(reader, machine, stated.options, published::kMostPoses);
  if (!poses.ok()) return base::Within(path, poses.status());
  program.poses = *std::move(poses);
  auto comparison = source.compare_program(machine, program);
  if (!comparison.ok()) return base::Within(path, comparison.status());
  return comparison;
}

absl::Status Compare(Context& context, const PublishedArguments& arguments) {
  if (arguments.list) return ListPublished(context);
  if (arguments.source.empty() || arguments.machine.empty() || arguments.inputs.empty()) {
    return absl::InvalidArgumentError("published: expected --list, or SOURCE, --machine and what --list says it needs");
  }
  ASSIGN_OR_RETURN(const published::Source* const source, published::FindSource(arguments.source));
  ASSIGN_OR_RETURN(const published::Comparison comparison, source->compare_program == nullptr
                                                               ? OfSessions(context, *source, arguments)
                                                               : OfProgram(context, *source, arguments));
  Json rows = Json::Array();
  std::vector<std::vector<std::string>> table = {{"quantity", "published", "sigma", "corrected", "exact", "sigma",
                                                  "unit", "exact is", "erratum or what is missing"}};
  for (const published::Row& row : comparison.rows) {
    rows.push_back({{"quantity", row.quantity},
                    {"formula", row.formula},
                    {"unit", row.unit},
                    {"published", NumberOrNull(row.published)},
                    {"published_sigma", NumberOrNull(row.published_sigma)},
                    {"corrected", NumberOrNull(row.corrected)},
                    {"symbol", row.symbol},
                    {"exact", NumberOrNull(row.exact)},
                    {"sigma", NumberOrNull(row.sigma)},
                    {"note", row.note}});
    table.push_back({row.quantity, Cell(row.published), Cell(row.published_sigma), Cell(row.corrected), Cell(row.exact),
                     Cell(row.sigma), row.unit, row.symbol, row.note});
  }
  std::string text = absl::StrCat(
      "by the formulas of ", source->citation,
      "; for comparison only; the first sigma is by the stated sigma of the readings or errors alone\n", Table(table));
  for (const std::string& note : comparison.notes) absl::StrAppend(&text, note, "\n");
  context.Print({{"source", source->name}, {"citation", source->citation}, {"rows", rows}, {"notes", comparison.notes}},
                text);
  return absl::OkStatus();
}

}  // namespace

void AddPublishedCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<PublishedArguments>();
  CLI::App* published = app.add_subcommand(
      "published", "What a publication's own formulas make of sessions, beside the exact model, with its errata");
  published->add_option("SOURCE", arguments->source, "one of --list");
  published->add_option("SESSIONS", arguments->inputs,
                        "session files, or numbers or names of stored sessions; of a compensation the NC program");
  published->add_option("--machine", arguments->machine, "the machine, or its machine.json without any database");
  published->add_option("--tool-tip", arguments->rewrite.tool_tip,
                        "of a compensation: the nominal tool point with all axes at zero, \"X Y Z\" in mm");
  AddUnitOption(*published, arguments->rewrite);
  CLI::Option* calibration = published->add_option("--calibration", arguments->calibration,
                                                   "of a compensation: this one instead of the approved one");
  calibration->check(PositiveNumber());
  published
      ->add_option("--errors", arguments->errors,
                   "of a compensation: errors.json in um and urad, or a calibration as --json prints it: with sigmas")
      ->excludes(calibration);
  published->add_flag("--list", arguments->list, "the publications whose formulas are known");
  published->footer(
      "For comparison only: no number of it reaches a calibration, a table or a program.\n"
      "Examples: axiscal published yao-table-4.5 --machine machine.json eccentricity-B.csv eccentricity-C.csv "
      "eccentricity-C-long.csv\n"
      "          axiscal published yao-compensation --machine machine.json --errors errors.json --tool-tip \"0 0 "
      "-350\" "
      "in.nc");
  SetAction(published, context, [&context, arguments] { return Compare(context, *arguments); });
}

}  // namespace axiscal::cli
