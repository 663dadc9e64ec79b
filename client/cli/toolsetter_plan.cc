#include "client/cli/toolsetter_plan.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/context.h"
#include "client/cli/output_paths.h"
#include "core/base/files.h"
#include "core/base/strict_json.h"
#include "core/base/units.h"
#include "core/session/read_session.h"
#include "core/toolsetter/plan.h"

namespace axiscal::cli {
namespace {

using base::kDegPerRad;
using base::kUmPerMm;

struct Arguments {
  std::string file, output, turn, machine, session = "planned";
  int starts = 12, holders = 12, readouts = 3;
  double sigma_um = 1.0;
};

std::string Number(double number) { return absl::StrFormat("%.10g", number); }

// Rods: the session's header with a line per position of the spindle, and a row per readout to be filled in.
absl::StatusOr<std::string> RodTable(const session::Session& session, const toolsetter::RodSession& planned) {
  std::string text;
  for (const session::HeaderEntry& entry : session.header)
    absl::StrAppend(&text, "# ", entry.key, ": ", entry.value, "\n");
  for (const toolsetter::MeasuredRod& rod : planned.rods) {
    if (rod.name == rod.body() || session::FindHeader(session, "rod " + rod.name)) continue;
    const toolsetter::Rod& r = rod.rod;
    absl::StrAppend(&text, "# rod ", rod.name, ":");
    for (const double number : {r.radius_mm, r.fillet_mm, r.face_rad * kDegPerRad, r.azimuth_rad * kDegPerRad,
                                r.length_mm, r.holder_rad * kDegPerRad})
      absl::StrAppend(&text, " ", Number(number));
    text += "\n";
  }
  text += "rod,readout,Z_mm\n";
  for (const toolsetter::MeasuredRod& rod : planned.rods) {
    for (size_t i = 1; i <= rod.readouts_mm.size(); ++i) absl::StrAppend(&text, rod.name, ",", i, ",\n");
  }
  return text;
}

absl::Status PlanRods(Context& context, const Arguments& arguments) {
  ASSIGN_OR_RETURN(const session::Session session, session::ReadSessionFile(arguments.file));
  ASSIGN_OR_RETURN(const toolsetter::RodSession rods, toolsetter::ReadRodSession(session));
  ASSIGN_OR_RETURN(const toolsetter::RodSession planned,
                   toolsetter::PlanRods(rods, arguments.turn, arguments.holders, arguments.readouts));
  ASSIGN_OR_RETURN(const toolsetter::Reference expected, toolsetter::FitReference(planned, {true, true}));
  ASSIGN_OR_RETURN(const std::string table, RodTable(session, planned));
  RETURN_IF_ERROR(base::WriteFileAtomically(arguments.output, table));
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

// A cutter.json has the keys of the session's header.
std::string CurveTable(const Json& cutter, const Arguments& arguments, const toolsetter::CurveSession& planned) {
  std::string text =
      absl::StrCat("# machine: ", arguments.machine, "\n# session: ", arguments.session,
                   "\n# instrument: tool-curve\n# sigma_um: ", Number(arguments.sigma_um), "\n# tool_tip_mm: 0 0 0\n");
  for (const auto& [key, value] : cutter.items()) {
    if (value.is_number()) absl::StrAppend(&text, "# ", key, ": ", value.dump(), "\n");
    if (!value.is_array() || key == "wear_mm") continue;
    absl::StrAppend(&text, "# ", key, ":");
    for (const Json& number : value) absl::StrAppend(&text, " ", number.dump());
    text += "\n";
  }
  text += "start_deg,length_mm\n";
  for (const double start_rad : planned.starts_rad) absl::StrAppend(&text, Number(start_rad * kDegPerRad), ",\n");
  return text;
}

absl::Status PlanStarts(Context& context, const Arguments& arguments) {
  ASSIGN_OR_RETURN(const toolsetter::CutterDescription described, toolsetter::ReadCutterFile(arguments.file));
  if (arguments.machine.empty())
    return absl::InvalidArgumentError("--machine: expected the id for the session's header");
  ASSIGN_OR_RETURN(const std::string cutter, base::ReadFile(arguments.file, base::kMaxJsonBytes));
  if (!(arguments.sigma_um > 0.0 && arguments.sigma_um <= 1000.0))
    return absl::InvalidArgumentError(
        absl::StrFormat("--sigma-um %g: expected above 0 to 1000 um", arguments.sigma_um));
  toolsetter::CurveSession session;
  session.sigma_mm = arguments.sigma_um * base::kMmPerUm;
  session.start_sigma_rad = toolsetter::kUsualStartSigmaDeg * base::kRadPerDeg;
  session.cutter = described.cutter;
  session.run = described.run;
  ASSIGN_OR_RETURN(const toolsetter::CurveSession planned, toolsetter::PlanStarts(session, arguments.starts));
  ASSIGN_OR_RETURN(const toolsetter::WearReport expected, toolsetter::FitWear(planned));
  ASSIGN_OR_RETURN(const Json json_cutter, base::ParseStrictJson(cutter));
  RETURN_IF_ERROR(base::WriteFileAtomically(arguments.output, CurveTable(json_cutter, arguments, planned)));
  const double unseen_um = described.run.feed_per_insert_mm(described.cutter) * kUmPerMm;
  Json inserts = Json::array();
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
                   NumberText(unseen_um), " um more than the insert before is not seen at this feed and speed\n"));
  return absl::OkStatus();
}

absl::Status Plan(Context& context, const Arguments& arguments) {
  RETURN_IF_ERROR(CheckOutputs({{"the file", arguments.file}}, {{"--output", arguments.output}}));
  return arguments.file.ends_with(".json") ? PlanStarts(context, arguments) : PlanRods(context, arguments);
}

}  // namespace

void AddToolSetterPlan(CLI::App& toolsetter, Context& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* plan = toolsetter.add_subcommand(
      "plan", "What to measure in the tool setter: a session to be filled in, and what it will tell");
  plan->add_option("FILE", arguments->file, "a cutter.json, or a tool-setter session whose rods are meant")->required();
  plan->add_option("-o,--output", arguments->output, "FILE.csv: the session without its readings")->required();
  plan->add_option("--starts", arguments->starts, "of a cutter: start angles")->capture_default_str();
  plan->add_option("--machine", arguments->machine, "of a cutter: the machine's id in the header");
  plan->add_option("--session", arguments->session, "of a cutter: the session's name")->capture_default_str();
  plan->add_option("--sigma-um", arguments->sigma_um, "of a cutter: repeatability of a reading, um")
      ->capture_default_str();
  plan->add_option("--turn", arguments->turn, "of rods: this one at several positions of the spindle");
  plan->add_option("--holders", arguments->holders, "of rods: how many positions")->capture_default_str();
  plan->add_option("--readouts", arguments->readouts, "of rods: of each")->capture_default_str();
  plan->footer(
      "Expected are standard uncertainties of length and wear, or of the beam's Z, yaw and pitch, by the stated "
      "repeatability.\n"
      "Examples: axiscal toolsetter plan cutter.json --starts 12 --machine cmx50u -o starts.csv\n"
      "          axiscal toolsetter plan rods.csv --turn rod-2 -o turned.csv");
  SetAction(plan, context, [&context, arguments] { return Plan(context, *arguments); });
}

}  // namespace axiscal::cli
