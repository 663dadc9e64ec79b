// axiscal machine add|update|list|show|explain
#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/positive_number.h"
#include "client/cli/record_output.h"
#include "client/cli/rewrite_arguments.h"
#include "core/base/files.h"
#include "core/base/json_limits.h"
#include "core/machine/explain.h"
#include "core/machine/machine_json.h"

namespace axiscal::cli {
namespace {

struct MachineArguments {
  RewriteArguments rewrite;
  std::string file, id, page;
  int page_size = 0;
  int64_t revision = 0;
};

// The text of a machine.json that is known to be right.
absl::StatusOr<std::string> ReadDescription(const std::string& path, MachineId* id) {
  ASSIGN_OR_RETURN(const machine::Machine machine, machine::ReadMachineFile(path));
  *id = MachineId(machine.id);
  return base::ReadFile(path, base::kMaxJsonBytes);
}

absl::Status Add(Context& context, const MachineArguments& arguments) {
  MachineId id;
  ASSIGN_OR_RETURN(const std::string description, ReadDescription(arguments.file, &id));
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::MachineRecord record, client->CreateMachine(description));
  context.Print(ToJson(record),
                absl::StrCat("machine ", record.id.text(), " is stored (revision ", record.revision,
                             "); check its signs with: axiscal machine explain ", record.id.text(), "\n"));
  return absl::OkStatus();
}

absl::Status Update(Context& context, const MachineArguments& arguments) {
  MachineId id;
  ASSIGN_OR_RETURN(const std::string description, ReadDescription(arguments.file, &id));
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  const absl::StatusOr<records::MachineRecord> present = client->GetMachine(id);
  // A damaged description is mended by being replaced.
  constexpr int64_t kAnyRevision = 0;
  if (!present.ok() && !absl::IsDataLoss(present.status())) return present.status();
  ASSIGN_OR_RETURN(const records::MachineRecord record,
                   client->UpdateMachine(description, present.ok() ? present->revision : kAnyRevision));
  context.Print(ToJson(record), absl::StrCat("machine ", record.id.text(), " is now revision ", record.revision, "\n"));
  return absl::OkStatus();
}

absl::Status List(Context& context, const MachineArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const auto page, client->ListMachines({arguments.page_size, arguments.page}));
  std::vector<std::vector<std::string>> rows = {{"machine", "revision", "updated (UTC)"}};
  for (const records::MachineRecord& record : page.rows) {
    rows.push_back({record.id.text(), absl::StrCat(record.revision), TimeText(record.updated_at)});
  }
  context.Print(PageJson("machines", page), Table(rows) + PageText(page));
  return absl::OkStatus();
}

absl::Status Show(Context& context, const MachineArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  const MachineId id(arguments.id);
  ASSIGN_OR_RETURN(const records::MachineRecord record, arguments.revision > 0
                                                            ? client->GetMachineRevision(id, arguments.revision)
                                                            : client->GetMachine(id));
  context.Print(ToJson(record), record.description_json + (record.description_json.ends_with('\n') ? "" : "\n"));
  return absl::OkStatus();
}

absl::StatusOr<machine::Machine> LoadMachine(Context& context, const MachineArguments& arguments) {
  if (!arguments.file.empty()) return machine::ReadMachineFile(arguments.file);
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::MachineRecord record, client->GetMachine(MachineId(arguments.id)));
  return machine::MachineFromJson(record.description_json);
}

absl::Status Explain(Context& context, const MachineArguments& arguments) {
  if (arguments.file.empty() == arguments.id.empty()) {
    return absl::InvalidArgumentError("explain: expected either a machine's id or --file machine.json");
  }
  ASSIGN_OR_RETURN(const machine::Machine machine, LoadMachine(context, arguments));
  Json axes = Json::Array();
  for (const machine::AxisMotion& motion : machine::ExplainMotions(machine)) {
    const auto vector = [](const Eigen::Vector3d& v) { return Json(std::vector<double>{v.x(), v.y(), v.z()}); };
    axes.push_back(
        {{"axis", motion.axis},
         {"kind", motion.kind == machine::AxisKind::kLinear ? "linear" : "rotary"},
         {"carries", motion.carries_workpiece ? "workpiece" : "tool"},
         {motion.kind == machine::AxisKind::kLinear ? "tool_moves_to" : "tool_turns_about", vector(motion.tool_motion)},
         {"follows_iso_841", motion.follows_iso_841},
         {"text", machine::ToText(motion)}});
  }
  context.Print({{"machine", machine.id}, {"axes", axes}}, machine::Explain(machine));
  return absl::OkStatus();
}

absl::Status PutProfile(Context& context, const MachineArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::MachineRecord present, client->GetMachine(MachineId(arguments.id)));
  ASSIGN_OR_RETURN(const machine::Machine machine, machine::MachineFromJson(present.description_json));
  ASSIGN_OR_RETURN(const machine::ProgramProfile profile, ToProfile(arguments.rewrite, machine));
  ASSIGN_OR_RETURN(const std::string description, machine::WithProgramProfile(present.description_json, profile));
  ASSIGN_OR_RETURN(const records::MachineRecord record, client->UpdateMachine(description, present.revision));
  const std::string text = ProfileText(profile);
  context.Print(ToJson(record), absl::StrCat("machine ", record.id.text(), " is now revision ", record.revision, ", ",
                                             text.empty() ? "without a profile\n" : "with the profile\n", text));
  return absl::OkStatus();
}

absl::Status ShowProfile(Context& context, const MachineArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::MachineRecord record, client->GetMachine(MachineId(arguments.id)));
  ASSIGN_OR_RETURN(const machine::ProgramProfile profile, machine::ProgramProfileFromJson(record.description_json));
  const std::string text = ProfileText(profile);
  context.Print({{"machine", arguments.id},
                 {"tool_tip", profile.tool_tip},
                 {"dialect", profile.dialect},
                 {"unit", profile.unit},
                 {"integer_words", profile.integer_words},
                 {"decimals", profile.decimals},
                 {"block_delete", profile.block_delete},
                 {"harmless_m", profile.harmless_m},
                 {"start", profile.start},
                 {"tool_change_keeps", profile.tool_change_keeps},
                 {"offsets", profile.offsets},
                 {"tool_lengths", profile.tool_lengths},
                 {"tool_radii", profile.tool_radii}},
                text.empty() ? absl::StrCat("machine ", arguments.id, " has no profile\n") : text);
  return absl::OkStatus();
}

}  // namespace

void AddMachineCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<MachineArguments>();
  CLI::App* machine = app.add_subcommand("machine", "Describe machines: add, update, list, show, explain");
  machine->require_subcommand(1);

  CLI::App* add = machine->add_subcommand("add", "Store the description of a machine");
  add->add_option("FILE", arguments->file, "its machine.json")->required();
  add->footer("Example: axiscal machine add machine.json");
  SetAction(add, context, [&context, arguments] { return Add(context, *arguments); });

  CLI::App* update = machine->add_subcommand("update", "Store a new revision; former ones stay readable");
  update->add_option("FILE", arguments->file, "its machine.json")->required();
  SetAction(update, context, [&context, arguments] { return Update(context, *arguments); });

  CLI::App* list = machine->add_subcommand("list", "List the machines");
  list->add_option("--page-size", arguments->page_size, "machines per page (1 to 1000)")->check(CLI::Range(1, 1000));
  list->add_option("--page", arguments->page, "token of the next page");
  SetAction(list, context, [&context, arguments] { return List(context, *arguments); });

  CLI::App* show = machine->add_subcommand("show", "Print a machine's description");
  show->add_option("ID", arguments->id, "the machine")->required();
  show->add_option("--revision", arguments->revision, "an earlier revision")->check(PositiveNumber());
  SetAction(show, context, [&context, arguments] { return Show(context, *arguments); });

  CLI::App* explain = machine->add_subcommand(
      "explain", "Say where a positive command of each axis takes the tool, to find a wrong sign");
  explain->add_option("ID", arguments->id, "the machine");
  explain->add_option("--file", arguments->file, "a machine.json instead, without any database");
  explain->footer("Example: axiscal machine explain --file machine.json");
  SetAction(explain, context, [&context, arguments] { return Explain(context, *arguments); });

  CLI::App* profile = machine->add_subcommand(
      "profile", "Options of `compensate` and `verify` that hold for all programs of a machine: put, show");
  profile->require_subcommand(1);
  CLI::App* put = profile->add_subcommand("put", "State them, all anew; without any the profile ends");
  put->add_option("ID", arguments->id, "the machine")->required();
  AddProfileOptions(*put, arguments->rewrite);
  put->footer(
      "They stand in the machine's description (\"programs\"), as a new revision; options of the command line go "
      "before them.\n"
      "Example: axiscal machine profile put mt --dialect haas --unit mm --tool-tip \"0 0 -350\" --offset \"G54 "
      "X=-490\" --tool-table tools.t");
  SetAction(put, context, [&context, arguments] { return PutProfile(context, *arguments); });
  CLI::App* show_profile = profile->add_subcommand("show", "Print them as they would be typed");
  show_profile->add_option("ID", arguments->id, "the machine")->required();
  SetAction(show_profile, context, [&context, arguments] { return ShowProfile(context, *arguments); });
}

}  // namespace axiscal::cli
