#include "client/cli/toolsetter_plan.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "client/cli/context.h"
#include "client/cli/output_paths.h"
#include "core/base/files.h"
#include "core/base/json_limits.h"
#include "core/base/units.h"
#include "core/session/read_session.h"

namespace axiscal::cli {
namespace {

using base::kDegPerRad;
using base::kUmPerMm;

struct PlannedRods {
  toolsetter::RodSession planned;
  std::string table;
};

absl::StatusOr<PlannedRods> RodsOf(const ToolSetterPlan& arguments) {
  ASSIGN_OR_RETURN(const session::Session session, session::ReadSessionFile(arguments.file));
  ASSIGN_OR_RETURN(const toolsetter::RodSession rods, toolsetter::ReadRodSession(session));
  PlannedRods out;
  ASSIGN_OR_RETURN(out.planned, toolsetter::PlanRods(rods, arguments.turn, arguments.holders, arguments.readouts));
  out.table = toolsetter::ToTable(session, out.planned);
  return out;
}

absl::Status PlanRods(Context& context, const ToolSetterPlan& arguments) {
  ASSIGN_OR_RETURN(const PlannedRods rods, RodsOf(arguments));
  const toolsetter::RodSession& planned = rods.planned;
  ASSIGN_OR_RETURN(const toolsetter::Reference expected, toolsetter::ExpectedOf(planned));
  RETURN_IF_ERROR(base::WriteFileAtomically(arguments.output, rods.table));
  Json json = {
      {"file", arguments.output}, {"kind", "tool-setter"}, {"readouts", planned.rods.size() * arguments.readouts}};
  std::vector<std::vector<std::string>> rows = {{"", "expected +-", ""}};
  for (const auto parameter : {toolsetter::kReferenceZ, toolsetter::kReferenceYaw, toolsetter::kReferencePitch}) {
    const toolsetter::Fitted& fitted = expected.parameters[parameter];
    const bool is_length = parameter == toolsetter::kReferenceZ;
    const double sigma = fitted.sigma * (is_length ? kUmPerMm : kDegPerRad);
    const char* const unit = is_length ? "um" : "deg";
    const std::string name = toolsetter::ParameterName(parameter);
    json["expected"][name] = {{"sigma", fitted.is_identifiable ? Json(sigma) : Json()}, {"unit", unit}};
    rows.push_back({name, fitted.is_identifiable ? NumberText(sigma) : "these rods cannot tell", unit});
  }
  context.Print(json, absl::StrCat(arguments.output, ": ", planned.rods.size(), " rods or positions, ",
                                   arguments.readouts, " readouts each\n", Table(rows),
                                   "(by repeatability and what the header states; a rod's own length error comes on "
                                   "top)\n"));
  return absl::OkStatus();
}

struct PlannedStarts {
  toolsetter::CurveSession planned;
  std::string table;
};

absl::StatusOr<PlannedStarts> StartsOf(const ToolSetterPlan& arguments) {
  ASSIGN_OR_RETURN(const toolsetter::CutterDescription described, toolsetter::ReadCutterFile(arguments.file));
  if (arguments.machine.empty())
    return absl::InvalidArgumentError("--machine: expected the id for the session's header");
  ASSIGN_OR_RETURN(const std::string cutter, base::ReadFile(arguments.file, base::kMaxJsonBytes));
  for (const auto& [option, name] :
       {std::make_pair("--session", &arguments.session), {"--machine", &arguments.machine}}) {
    const bool is_line = std::none_of(name->begin(), name->end(), [](char c) { return c >= 0 && c < ' '; });
    if (name->empty() || !is_line)
      return absl::InvalidArgumentError(absl::StrCat(option, ": expected a name on one line for the session's header"));
  }
  if (!(arguments.sigma_um > 0.0 && arguments.sigma_um <= 1000.0))
    return absl::InvalidArgumentError(
        absl::StrFormat("--sigma-um %g: expected above 0 to 1000 um", arguments.sigma_um));
  toolsetter::CurveSession session;
  session.sigma_mm = arguments.sigma_um * base::kMmPerUm;
  session.start_sigma_rad = toolsetter::kUsualStartSigmaDeg * base::kRadPerDeg;
  session.cutter = described.cutter;
  session.run = described.run;
  PlannedStarts out;
  ASSIGN_OR_RETURN(out.planned, toolsetter::PlanStarts(session, arguments.starts));
  ASSIGN_OR_RETURN(out.table, toolsetter::ToTable(cutter, arguments.machine, arguments.session, out.planned));
  return out;
}

absl::Status PlanStarts(Context& context, const ToolSetterPlan& arguments) {
  ASSIGN_OR_RETURN(const PlannedStarts starts, StartsOf(arguments));
  ASSIGN_OR_RETURN(const toolsetter::WearReport expected, toolsetter::ExpectedOf(starts.planned));
  RETURN_IF_ERROR(base::WriteFileAtomically(arguments.output, starts.table));
  const auto by_unseen = [](const auto& a, const auto& b) { return a.unseen_from_mm < b.unseen_from_mm; };
  const double unseen_um =
      std::min_element(expected.inserts.begin(), expected.inserts.end(), by_unseen)->unseen_from_mm * kUmPerMm;
  Json inserts = Json::Array();
  std::vector<std::vector<std::string>> rows = {{"insert", "wear expected +- um", "readings"}};
  for (size_t k = 0; k < expected.inserts.size(); ++k) {
    const toolsetter::InsertWear& insert = expected.inserts[k];
    const double sigma_um = insert.sigma_mm * kUmPerMm;
    inserts.push_back({{"insert", k + 1},
                       {"sigma_um", insert.is_identifiable ? Json(sigma_um) : Json()},
                       {"readings", insert.readings}});
    rows.push_back({std::to_string(k + 1), insert.is_identifiable ? NumberText(sigma_um) : "not seen",
                    std::to_string(insert.readings)});
  }
  context.Print(
      {{"file", arguments.output},
       {"kind", "tool-curve"},
       {"starts", arguments.starts},
       {"expected", {{"length_sigma_um", expected.length_sigma_mm * kUmPerMm}, {"inserts", inserts}}},
       {"unseen_from_um", unseen_um}},
      absl::StrCat(arguments.output, ": ", arguments.starts, " start angles\nlength expected +- ",
                   NumberText(expected.length_sigma_mm * kUmPerMm), " um\n", Table(rows),
                   "(of unworn inserts; the longest one is what the others are worn against)\nwear from ",
                   NumberText(unseen_um), " um more than the others is not seen at this feed, speed and offset\n"));
  return absl::OkStatus();
}

bool IsCutter(const std::string& file) { return file.ends_with(".json"); }

absl::StatusOr<std::string> TableOf(const ToolSetterPlan& arguments) {
  if (IsCutter(arguments.file)) {
    ASSIGN_OR_RETURN(PlannedStarts starts, StartsOf(arguments));
    return std::move(starts.table);
  }
  ASSIGN_OR_RETURN(PlannedRods rods, RodsOf(arguments));
  return std::move(rods.table);
}

}  // namespace

void AddToolSetterOptions(CLI::App& command, ToolSetterPlan& plan) {
  command.add_option("--starts", plan.starts, "of a cutter: start angles")->capture_default_str();
  command.add_option("--session", plan.session, "of a cutter: the session's name")->capture_default_str();
  command.add_option("--sigma-um", plan.sigma_um, "of a cutter: repeatability of a reading, um")->capture_default_str();
  command.add_option("--turn", plan.turn, "of rods: this one at several positions of the spindle");
  command.add_option("--holders", plan.holders, "of rods: how many positions")->capture_default_str();
  command.add_option("--readouts", plan.readouts, "of rods: of each")->capture_default_str();
}

absl::Status PlanToolSetter(Context& context, const ToolSetterPlan& plan) {
  if (!plan.output.ends_with(".csv"))
    return absl::InvalidArgumentError(absl::StrCat("--output '", plan.output, "': expected FILE.csv, a session"));
  RETURN_IF_ERROR(CheckOutputs({{"the file", plan.file}}, {{"--output", plan.output}}));
  return IsCutter(plan.file) ? PlanStarts(context, plan) : PlanRods(context, plan);
}

absl::Status PlanToolSetterTest(Context& context, const machine::Machine& machine,
                                const toolsetter::PlannableTest& test, const ToolSetterPlan& plan) {
  if (plan.file.empty() || IsCutter(plan.file) != (test.name == "tool-curve"))
    return absl::InvalidArgumentError(
        absl::StrCat("plan: ", test.name, ": --tools '", plan.file, "', expected ", test.file));
  if (!toolsetter::FeedsAlongTool(machine)) {
    return absl::FailedPreconditionError(absl::StrCat("plan: ", test.name, ": machine ", machine.id,
                                                      " has no linear axis along its tool, which a tool setter is fed "
                                                      "onto with"));
  }
  if (!IsCutter(plan.file)) {
    ASSIGN_OR_RETURN(const session::Session session, session::ReadSessionFile(plan.file));
    const std::string of = session::FindHeader(session, "machine").value_or("");
    if (of != machine.id)
      return absl::InvalidArgumentError(
          absl::StrCat(plan.file, ": machine ", of, ", expected rods of machine ", machine.id));
  }
  ToolSetterPlan of_machine = plan;
  of_machine.machine = machine.id;
  if (plan.output.ends_with(".csv")) return PlanToolSetter(context, of_machine);
  RETURN_IF_ERROR(CheckOutputs({{"--tools", plan.file}}, {{"--output", plan.output}}));
  ASSIGN_OR_RETURN(const std::string table, TableOf(of_machine));
  ASSIGN_OR_RETURN(const session::Session session, session::ReadPlanText(table, plan.file));
  ASSIGN_OR_RETURN(const std::string program, plan::ToProgram(machine, session, plan.program));
  RETURN_IF_ERROR(base::WriteFileAtomically(plan.output, program));
  context.Print({{"file", plan.output}, {"kind", "program"}, {"readings", session.reading_count()}},
                absl::StrCat(plan.output, ": ", session.reading_count(),
                             " triggers; write the plan (-o FILE.csv) for "
                             "axiscal reduce too\n"));
  return absl::OkStatus();
}

void AddToolSetterPlan(CLI::App& toolsetter, Context& context) {
  auto arguments = std::make_shared<ToolSetterPlan>();
  CLI::App* plan = toolsetter.add_subcommand(
      "plan", "What to measure in the tool setter: a session to be filled in, and what it will tell");
  plan->add_option("FILE", arguments->file, "a cutter.json, or a tool-setter session whose rods are meant")->required();
  plan->add_option("-o,--output", arguments->output, "FILE.csv: the session without its readings")->required();
  plan->add_option("--machine", arguments->machine, "of a cutter: the machine's id in the header");
  AddToolSetterOptions(*plan, *arguments);
  plan->footer(
      "Expected are standard uncertainties of length and wear, or of the beam's Z, yaw and pitch, by the stated "
      "repeatability.\n"
      "Examples: axiscal toolsetter plan cutter.json --starts 12 --machine cmx50u -o starts.csv\n"
      "          axiscal toolsetter plan rods.csv --turn rod-2 -o turned.csv");
  SetAction(plan, context, [&context, arguments] { return PlanToolSetter(context, *arguments); });
}

}  // namespace axiscal::cli
