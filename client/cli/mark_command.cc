// axiscal mark put|list|withdraw
#include <CLI/CLI.hpp>
#include <memory>

#include "absl/strings/str_join.h"
#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/positive_number.h"
#include "client/cli/record_output.h"

namespace axiscal::cli {
namespace {

struct MarkArguments {
  std::string machine, at, kind, note, page;
  std::vector<std::string> symbols;
  int page_size = 0;
  int64_t id = 0;
};

const std::vector<std::pair<std::string, records::MarkKind>> kMarkKinds = {
    {"collision", records::MarkKind::kCollision},
    {"service", records::MarkKind::kService},
    {"re-fixturing", records::MarkKind::kRefixturing}};

absl::Status Put(Context& context, const MarkArguments& arguments) {
  records::NewMark mark;
  mark.machine = MachineId(arguments.machine);
  mark.at = base::SystemClock().UtcNow();
  if (!arguments.at.empty()) {
    ASSIGN_OR_RETURN(mark.at, ParseTime("--at", arguments.at));
  }
  for (const auto& [name, kind] : kMarkKinds) {
    if (name == arguments.kind) mark.kind = kind;
  }
  mark.symbols = arguments.symbols;
  mark.note = arguments.note;
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::Mark stored, client->PutMark(mark));
  context.Print(ToJson(stored), MarkText(stored));
  return absl::OkStatus();
}

absl::Status List(Context& context, const MarkArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const auto page,
                   client->ListMarks(MachineId(arguments.machine), {arguments.page_size, arguments.page}));
  std::vector<std::vector<std::string>> rows = {{"id", "at (UTC)", "kind", "errors", "by", "withdrawn by", "note"}};
  for (const records::Mark& mark : page.rows) {
    rows.push_back({absl::StrCat(mark.id.number()), TimeText(mark.content.at), MarkKindName(mark.content.kind),
                    mark.content.symbols.empty() ? "all" : absl::StrJoin(mark.content.symbols, " "), mark.created_by,
                    mark.withdrawn_at ? mark.withdrawn_by : "-", mark.content.note});
  }
  context.Print(PageJson("marks", page), Table(rows) + PageText(page));
  return absl::OkStatus();
}

absl::Status Withdraw(Context& context, const MarkArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::Mark mark, client->WithdrawMark(MarkId(arguments.id)));
  context.Print(ToJson(mark), MarkText(mark));
  return absl::OkStatus();
}

}  // namespace

void AddMarkCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<MarkArguments>();
  CLI::App* mark = app.add_subcommand(
      "mark", "Say what has happened to a machine: a collision, a service, a re-fixturing; it ends what drift said");
  mark->require_subcommand(1);

  CLI::App* put = mark->add_subcommand("put", "Put a mark into a machine's history");
  std::vector<std::string> names;
  for (const auto& [name, kind] : kMarkKinds) names.push_back(name);
  put->add_option("--machine", arguments->machine, "the machine")->required();
  put->add_option("--kind", arguments->kind, "what it was")->required()->check(CLI::IsMember(names));
  put->add_option("--at", arguments->at, "when, UTC (2026-05-12 or 2026-05-12T14:00:00); else now");
  put->add_option("--error", arguments->symbols, "an error that it can have moved (EX0C); again for more; else all");
  put->add_option("--note", arguments->note, "in your words");
  put->footer(
      "Example: axiscal mark put --machine mt --kind collision --at 2026-05-12T14:00:00 --note \"hit the chuck\"\n"
      "Calibrations measured until then stand before the mark.");
  SetAction(put, context, [&context, arguments] { return Put(context, *arguments); });

  CLI::App* list = mark->add_subcommand("list", "List a machine's marks, newest first");
  list->add_option("--machine", arguments->machine, "the machine")->required();
  list->add_option("--page-size", arguments->page_size, "marks per page (1 to 1000)")->check(CLI::Range(1, 1000));
  list->add_option("--page", arguments->page, "token of the next page");
  SetAction(list, context, [&context, arguments] { return List(context, *arguments); });

  CLI::App* withdraw = mark->add_subcommand("withdraw", "Withdraw a mark that was a mistake: it counts no more");
  withdraw->add_option("MARK", arguments->id, "its number")->required()->check(PositiveNumber());
  SetAction(withdraw, context, [&context, arguments] { return Withdraw(context, *arguments); });
}

}  // namespace axiscal::cli
