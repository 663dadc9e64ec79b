// axiscal cells, cells forget
#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/record_output.h"

namespace axiscal::cli {
namespace {

struct CellsArguments {
  std::string machine, page, name;
  int page_size = 0;
};

std::string StateOf(const records::CellRecord& cell) {
  if (cell.is_silent()) return "silent";
  return cell.report.problem.empty() ? "well" : "wants a person";
}

Json JsonOf(const records::CellRecord& cell) {
  const records::CellReport& report = cell.report;
  return {{"machine", report.machine.text()},
          {"name", report.name},
          {"state", StateOf(cell)},
          {"problem", report.problem},
          {"reported", TimeJson(cell.reported_at)},
          {"reported_by", cell.reported_by},
          {"silence_s", static_cast<double>(cell.silence.count()) / 1e6},
          {"silent_after_s", static_cast<int64_t>(report.silent_after.count())},
          {"version", report.version},
          {"waiting_files", report.waiting_files},
          {"waiting_bytes", report.waiting_bytes},
          {"quarantined_files", report.quarantined_files},
          {"quarantined_bytes", report.quarantined_bytes},
          {"max_bytes", report.max_bytes}};
}

absl::Status List(Context& context, const CellsArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  std::optional<MachineId> machine;
  if (!arguments.machine.empty()) machine = MachineId(arguments.machine);
  ASSIGN_OR_RETURN(const auto page, client->ListCells(machine, {arguments.page_size, arguments.page}));
  Json cells = Json::Array();
  std::vector<std::vector<std::string>> rows = {
      {"machine", "cell", "", "heard", "waiting", "quarantined", "version", "problem"}};
  for (const records::CellRecord& cell : page.rows) {
    cells.push_back(JsonOf(cell));
    rows.push_back({cell.report.machine.text(), cell.report.name, StateOf(cell), TimeText(cell.reported_at),
                    absl::StrCat(cell.report.waiting_files), absl::StrCat(cell.report.quarantined_files),
                    cell.report.version, cell.report.problem});
  }
  context.Print({{"cells", cells}, {"next_page", page.next_token}},
                (page.rows.empty() ? "no cells\n" : Table(rows)) + PageText(page));
  return absl::OkStatus();
}

absl::Status Forget(Context& context, const CellsArguments& arguments) {
  if (arguments.machine.empty()) return absl::InvalidArgumentError("cells forget: --machine is missing");
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  RETURN_IF_ERROR(client->ForgetCell(MachineId(arguments.machine), arguments.name));
  context.Print({{"machine", arguments.machine}, {"name", arguments.name}, {"state", "forgotten"}},
                "nobody waits for cell " + arguments.name + " of " + arguments.machine + " any more\n");
  return absl::OkStatus();
}

}  // namespace

void AddCellsCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<CellsArguments>();
  CLI::App* cells = app.add_subcommand("cells",
                                       "The PCs beside machines that bring their files (docs/cell.md): how "
                                       "they stand, and which say nothing any more");
  cells->require_subcommand(0, 1);
  cells->add_option("--machine", arguments->machine, "of this machine only");
  cells->add_option("--page-size", arguments->page_size, "cells per page (1 to 1000)")->check(CLI::Range(1, 1000));
  cells->add_option("--page", arguments->page, "token of the next page");
  cells->footer("Examples:\n  axiscal cells\n  axiscal cells forget cell-7 --machine mt");
  SetAction(cells, context, [&context, cells, arguments] {
    return cells->get_subcommands().empty() ? List(context, *arguments) : context.status;
  });
  CLI::App* forget = cells->add_subcommand("forget", "A cell that is no longer there: its events are cleared");
  forget->add_option("NAME", arguments->name, "the cell's name")->required();
  SetAction(forget, context, [&context, arguments] { return Forget(context, *arguments); });
}

}  // namespace axiscal::cli
