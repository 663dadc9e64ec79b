// axiscal compare: which errors of two calibrations differ beyond their uncertainties, and what that does to the tool.
#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>

#include "absl/strings/numbers.h"
#include "absl/strings/str_join.h"
#include "client/cli/box_words.h"
#include "client/cli/commands.h"
#include "client/cli/compare_source.h"
#include "client/cli/context.h"
#include "client/cli/machine_source.h"
#include "client/cli/rewrite_arguments.h"
#include "core/base/units.h"
#include "core/machine/redundant_facts.h"
#include "core/session/text.h"

namespace axiscal::cli {
namespace {

struct CompareArguments {
  std::string first, second, machine, tool_tip;
  std::vector<std::string> box, declared;
  double time_s = 0.0, temperature_celsius = 20.0;
};

absl::StatusOr<machine::Machine> MachineToCompare(Context& context, const CompareArguments& arguments) {
  if (!arguments.machine.empty()) return MachineFrom(context, arguments.machine);
  for (const std::string& name : {arguments.first, arguments.second})
    if (int64_t id = 0; absl::SimpleAtoi(name, &id)) return MachineOfCalibration(context, id);
  return absl::InvalidArgumentError("compare: expected --machine with two files");
}

// The positions that both were measured at; the machine's travel where none are at hand; what --box says goes first.
absl::StatusOr<predict::Box> BoxOf(const machine::Machine& machine, const CompareArguments& arguments,
                                   const Compared& first, const Compared& second, std::string* note) {
  predict::Box box;
  for (const Compared* compared : {&first, &second}) {
    if (!compared->measured) continue;
    if (box.low.empty()) box = *compared->measured;
    for (size_t i = 0; i < box.low.size(); ++i) {
      box.low[i] = std::min(box.low[i], compared->measured->low[i]);
      box.high[i] = std::max(box.high[i], compared->measured->high[i]);
    }
  }
  *note = box.low.empty() ? "the machine's travel" : "the measured positions";
  if (box.low.empty() && arguments.box.size() < machine.axes.size()) {
    auto travel = predict::BoxOfTravel(machine);
    if (!travel.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("compare: ", std::string(travel.status().message()), ": --box \"AXIS MIN MAX\""));
    }
    box = *travel;
  }
  if (box.low.empty()) box.low = box.high = std::vector<double>(machine.axes.size(), 0.0);
  for (const std::string& text : arguments.box) RETURN_IF_ERROR(SetBoxRange(text, machine, &box));
  if (!arguments.box.empty()) *note = "--box";
  return box;
}

const char* WordOf(compare::Verdict verdict) {
  switch (verdict) {
    case compare::Verdict::kAgrees:
      return "agrees";
    case compare::Verdict::kMayDiffer:
      return "may differ";
    case compare::Verdict::kDiffers:
      return "differs";
    case compare::Verdict::kNotDetermined:
      return "not determined";
    case compare::Verdict::kOnlyOne:
      return "only one";
    case compare::Verdict::kNoUncertainty:
      return "no verdict";
  }
  return "";
}

Json DifferencesJson(const std::vector<compare::Difference>& differences, bool has_rms) {
  Json list = Json::Array();
  for (const compare::Difference& one : differences) {
    Json json = {{"name", one.name},
                 {"unit", one.unit},
                 {"first", one.first},
                 {"second", one.second},
                 {"difference", one.difference},
                 {"sigma", one.sigma},
                 {"probability", one.probability},
                 {"verdict", WordOf(one.verdict)}};
    if (!one.reason.empty()) json["reason"] = one.reason;
    if (has_rms) json["tool_point_rms_um"] = one.rms_mm * base::kUmPerMm;
    list.push_back(json);
  }
  return list;
}

Json SizeJson(const machine::Machine& machine, const compare::Size& size) {
  return {{"rms_um", size.rms_mm * base::kUmPerMm},
          {"max_um", size.max_mm * base::kUmPerMm},
          {"max_at", PoseJson(machine, size.where.positions)},
          {"max_difference_um", VectorJson(size.where.difference_mm)},
          {"max_sigma_um", VectorJson(size.where.sigma_mm)},
          {"max_by", size.where.by},
          {"chance_rms_um", size.chance_rms_mm * base::kUmPerMm},
          {"chance_max_um", size.chance_max_mm * base::kUmPerMm}};
}

Json ComparisonJson(const machine::Machine& machine, const CompareArguments& arguments, const compare::Comparison& made,
                    const std::optional<predict::Workspace>& workspace, const std::string& box_from) {
  Json json = {{"first", arguments.first},
               {"second", arguments.second},
               {"errors", DifferencesJson(made.errors, made.tool_point.has_value())},
               {"combinations", DifferencesJson(made.combinations, false)},
               {"not_comparable", made.not_comparable},
               {"joint",
                {{"chi2", made.joint.chi2},
                 {"degrees_of_freedom", made.joint.degrees_of_freedom},
                 {"probability", made.joint.probability}}}};
  if (made.tool_point) {
    json["tool_point"] = {{"box", BoxJson(machine, workspace->box)},
                          {"box_from", box_from},
                          {"poses", made.tool_point->poses},
                          {"as_programmed", SizeJson(machine, made.tool_point->as_programmed)},
                          {"set_anew", SizeJson(machine, made.tool_point->set_anew)},
                          {"tilt_rms_urad", made.tool_point->tilt_rms_rad * base::kUradPerRad},
                          {"tilt_max_urad", made.tool_point->tilt_max_rad * base::kUradPerRad},
                          {"unknown", made.tool_point->unknown}};
  }
  json["notes"] = made.notes;
  return json;
}

std::string NumberCell(double number) { return std::isfinite(number) ? NumberText(number) : "-"; }

std::vector<std::string> DifferenceRow(const compare::Difference& one, bool has_rms) {
  std::vector<std::string> row = {one.name,
                                  NumberCell(one.first),
                                  NumberCell(one.second),
                                  NumberCell(one.difference),
                                  NumberCell(one.sigma),
                                  one.unit,
                                  has_rms ? NumberCell(one.rms_mm * base::kUmPerMm) : "",
                                  WordOf(one.verdict)};
  if (!one.reason.empty()) absl::StrAppend(&row.back(), ": ", one.reason);
  return row;
}

std::string SizeText(const machine::Machine& machine, const std::string& what, const compare::Size& size) {
  const auto um = [](const Eigen::Vector3d& mm) {
    return absl::StrJoin(
        {NumberCell(mm.x() * base::kUmPerMm), NumberCell(mm.y() * base::kUmPerMm), NumberCell(mm.z() * base::kUmPerMm)},
        " ");
  };
  std::string text = absl::StrFormat("%s: %s um rms, %s um at most\n  at %s: (%s) um", what,
                                     NumberCell(size.rms_mm * base::kUmPerMm), NumberCell(size.max_mm * base::kUmPerMm),
                                     PoseText(machine, size.where.positions), um(size.where.difference_mm));
  if (std::isfinite(size.chance_rms_mm)) absl::StrAppend(&text, " +- (", um(size.where.sigma_mm), ")");
  if (!size.where.by.empty()) absl::StrAppend(&text, ", mostly by ", absl::StrJoin(size.where.by, ", "));
  if (std::isfinite(size.chance_rms_mm))
    absl::StrAppend(&text, "\n  the uncertainties alone make up to ", NumberCell(size.chance_rms_mm * base::kUmPerMm),
                    " um rms, ", NumberCell(size.chance_max_mm * base::kUmPerMm), " um at most in 95 of 100 cases: ",
                    size.rms_mm > size.chance_rms_mm ? "this is more" : "this is no more");
  return text + "\n";
}

std::string ComparisonText(const machine::Machine& machine, const CompareArguments& arguments,
                           const compare::Comparison& made, const std::optional<predict::Workspace>& workspace,
                           const std::string& box_from) {
  const bool has_rms = made.tool_point.has_value();
  std::vector<std::vector<std::string>> rows = {
      {"error", "first", "second", "second - first", "sigma", "unit", has_rms ? "tool point um rms" : "", "verdict"}};
  for (const compare::Difference& one : made.errors) rows.push_back(DifferenceRow(one, has_rms));
  for (const compare::Difference& one : made.combinations) rows.push_back(DifferenceRow(one, false));
  std::string text = absl::StrCat("first: ", arguments.first, "\nsecond: ", arguments.second, "\n", Table(rows));
  for (const std::string& direction : made.not_comparable)
    absl::StrAppend(&text, "not known: a difference along ", direction, "\n");
  if (made.joint.degrees_of_freedom > 0)
    absl::StrAppendFormat(&text, "together: chi-square %.4g of %d degrees of freedom; by chance as much in %s cases\n",
                          made.joint.chi2, made.joint.degrees_of_freedom,
                          made.joint.probability >= 0.001
                              ? absl::StrFormat("%.3g of 100", 100.0 * made.joint.probability)
                              : "fewer than 1 of 1000");
  if (made.tool_point) {
    absl::StrAppend(&text, "tool point, second - first, over ", box_from, " (", BoxText(machine, workspace->box), "; ",
                    made.tool_point->poses, " poses):\n");
    absl::StrAppend(&text, SizeText(machine, "as programmed", made.tool_point->as_programmed),
                    SizeText(machine, "with work offset and tool data set anew", made.tool_point->set_anew));
    absl::StrAppend(&text, "tilt of the tool: ", NumberCell(made.tool_point->tilt_rms_rad * base::kUradPerRad),
                    " urad rms, ", NumberCell(made.tool_point->tilt_max_rad * base::kUradPerRad), " urad at most\n");
    for (const std::string& direction : made.tool_point->unknown)
      absl::StrAppend(&text, "in none of these figures, and it moves the tool point there: a difference along ",
                      direction, "\n");
  }
  for (const std::string& note : made.notes) absl::StrAppend(&text, "note: ", note, "\n");
  return text;
}

absl::Status RunCompare(Context& context, const CompareArguments& arguments) {
  ASSIGN_OR_RETURN(const machine::Machine machine, MachineToCompare(context, arguments));
  ASSIGN_OR_RETURN(const Compared first, ReadCompared(context, arguments.first, machine, arguments.declared));
  ASSIGN_OR_RETURN(const Compared second, ReadCompared(context, arguments.second, machine, arguments.declared));
  std::optional<Eigen::Vector3d> tip_mm = first.tip_mm ? first.tip_mm : second.tip_mm;
  if (!arguments.tool_tip.empty()) {
    ASSIGN_OR_RETURN(tip_mm, ToolTip(arguments.tool_tip));
    RETURN_IF_ERROR(base::Within("--tool-tip", machine::CheckToolTip(machine, *tip_mm)));
  } else if (!tip_mm && !arguments.box.empty()) {
    return absl::InvalidArgumentError("--box: expected --tool-tip with it");
  }
  std::optional<predict::Workspace> workspace;
  std::string box_from;
  if (tip_mm) {
    workspace.emplace();
    workspace->tip_mm = *tip_mm;
    workspace->time_s = arguments.time_s;
    workspace->temperature_celsius = arguments.temperature_celsius;
    ASSIGN_OR_RETURN(workspace->box, BoxOf(machine, arguments, first, second, &box_from));
  }
  ASSIGN_OR_RETURN(compare::Comparison made, compare::Compare(machine, first.side, second.side, workspace));
  for (const Compared* compared : {&first, &second})
    made.notes.insert(made.notes.end(), compared->notes.begin(), compared->notes.end());
  if (!workspace) made.notes.push_back("what the differences do at the tool point: --tool-tip \"x y z\"");
  context.Print(ComparisonJson(machine, arguments, made, workspace, box_from),
                ComparisonText(machine, arguments, made, workspace, box_from));
  return absl::OkStatus();
}

}  // namespace

void AddCompareCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* compare = app.add_subcommand(
      "compare", "Which errors of two calibrations differ beyond their uncertainties, and what it does to the tool");
  compare->add_option("A", arguments->first, "the first: a calibration's number, a JSON file, or sessions")->required();
  compare->add_option("B", arguments->second, "the second; differences are B - A")->required();
  compare->add_option("--machine", arguments->machine,
                      "a machine.json or a stored machine (default: that of a calibration by number)");
  compare->add_option("--tool-tip", arguments->tool_tip,
                      "nominal tool point at home, machine frame, mm: \"0 0 -350\" (default: that of the sessions)");
  compare->add_option(
      "--box", arguments->box,
      "range of an axis, mm or deg: \"X -200 300\"; again for more (default: what the sessions covered, "
      "else the travel)");
  compare->add_option("--declare", arguments->declared, "errors to fit to sessions (default: machine.json's)")
      ->delimiter(',');
  compare->add_option("--time", arguments->time_s, "of errors that drift, s of the clock t_s")->capture_default_str();
  compare->add_option("--temperature", arguments->temperature_celsius, "of errors that depend on it, deg C")
      ->capture_default_str();
  compare->footer(
      "A and B each are\n"
      "  12                 a stored calibration\n"
      "  errors.json        identified errors; or what calibration show --json and identify --json print\n"
      "  june/ or BX.csv,CR.csv    session files or folders of them, fitted here (of a case folder: fit/)\n"
      "Judged is what both determined; docs/compare.md says how.\n"
      "Examples: axiscal compare 11 12\n"
      "          axiscal compare --machine machine.json --tool-tip \"0 0 -350\" june.json july.json\n"
      "          axiscal compare --machine machine.json june/ july/ --json");
  SetAction(compare, context, [&context, arguments] { return RunCompare(context, *arguments); });
}

}  // namespace axiscal::cli
