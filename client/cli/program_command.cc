// axiscal program list|get
#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/output_paths.h"
#include "client/cli/positive_number.h"
#include "client/cli/record_output.h"
#include "core/base/files.h"

namespace axiscal::cli {
namespace {

struct ProgramArguments {
  std::string page, output;
  int page_size = 0;
  int64_t id = 0;
};

absl::Status List(Context& context, const ProgramArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const auto page, client->ListPrograms({arguments.page_size, arguments.page}));
  std::vector<std::vector<std::string>> rows = {{"id", "kind", "name", "bytes", "stored (UTC)", "by"}};
  for (const records::ProgramRecord& record : page.rows) {
    rows.push_back({absl::StrCat(record.id.number()), record.kind, record.name, absl::StrCat(record.byte_count),
                    TimeText(record.created_at), record.created_by});
  }
  context.Print(PageJson("programs", page), Table(rows) + PageText(page));
  return absl::OkStatus();
}

absl::Status Get(Context& context, const ProgramArguments& arguments) {
  if (context.server.empty())
    RETURN_IF_ERROR(CheckOutputs({{"the database", context.database}}, {{"--output", arguments.output}}));
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  base::AtomicFile file;
  RETURN_IF_ERROR(file.Open(arguments.output));
  ASSIGN_OR_RETURN(
      const records::ProgramRecord record,
      client->GetProgram(ProgramId(arguments.id), [&file](const std::string& bytes) { return file.Write(bytes); }));
  RETURN_IF_ERROR(file.Commit());
  Json json = ToJson(record);
  json["file"] = arguments.output;
  context.Print(json,
                absl::StrCat("program ", arguments.id, " (", record.byte_count, " bytes) in ", arguments.output, "\n"));
  return absl::OkStatus();
}

}  // namespace

void AddProgramCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<ProgramArguments>();
  CLI::App* program =
      app.add_subcommand("program", "Stored NC programs, and the logs that sessions were made of: list, get");
  program->require_subcommand(1);

  CLI::App* list = program->add_subcommand("list", "List programs, newest first");
  list->add_option("--page-size", arguments->page_size, "programs per page (1 to 1000)")->check(CLI::Range(1, 1000));
  list->add_option("--page", arguments->page, "token of the next page");
  SetAction(list, context, [&context, arguments] { return List(context, *arguments); });

  CLI::App* get = program->add_subcommand("get", "Write a stored program to a file, byte for byte");
  get->add_option("ID", arguments->id, "its number")->required()->check(PositiveNumber());
  get->add_option("-o,--output", arguments->output, "the file")->required();
  SetAction(get, context, [&context, arguments] { return Get(context, *arguments); });
}

}  // namespace axiscal::cli
