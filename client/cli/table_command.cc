// axiscal table: compensation tables for controllers, from a stored calibration, or from machine.json and errors.json
// without any database.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "absl/strings/str_join.h"
#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/error_model_source.h"
#include "client/cli/output_paths.h"
#include "client/cli/record_output.h"
#include "client/cli/rewrite_arguments.h"
#include "client/cli/table_arguments.h"
#include "core/base/files.h"
#include "core/compensate/tables/format.h"
#include "core/machine/machine_json.h"
#include "core/reports/table.h"

namespace axiscal::cli {
namespace {

struct TableCommandArguments {
  std::string machine, errors, output, report;
  int64_t calibration = 0;
  bool list = false;
  TableArguments table;
};

std::string ListText(const std::vector<records::TableFormat>& formats) {
  std::string text;
  for (const records::TableFormat& format : formats) {
    absl::StrAppend(&text, format.name, "\n    ", format.title, "\n    ", format.limits, "\n    ", format.values, "\n");
    for (const std::string& what : format.cannot_carry) absl::StrAppend(&text, "    cannot carry ", what, "\n");
  }
  return text;
}

// What the server knows; without one the formats of this program, which need no database.
absl::Status ListFormats(Context& context) {
  if (context.server.empty()) {
    std::vector<records::TableFormat> formats;
    for (const tables::Format& format : tables::Formats()) formats.push_back(records::Summary(format));
    context.Print({{"formats", Json::Document(tables::FormatsJson())}}, ListText(formats));
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const std::vector<records::TableFormat> formats, client->ListTableFormats());
  Json list = Json::Array();
  for (const records::TableFormat& format : formats) {
    list.push_back(
        {{"name", format.name},
         {"title", format.title},
         {"values", format.values},
         {"limits", {{"text", format.limits}, {"max_points", format.max_points ? Json(*format.max_points) : Json()}}},
         {"cannot_carry", format.cannot_carry}});
  }
  context.Print({{"formats", list}}, ListText(formats));
  return absl::OkStatus();
}

std::string JoinedWith(const std::vector<std::string>& words, const std::string& first) {
  return words.empty() ? "" : first + absl::StrJoin(words, " x ");
}

std::string TableReportText(const reports::Table& report, const std::string& output) {
  std::string text = absl::StrCat(output, ": ", report.format, ", ", report.values, "\n");
  std::vector<std::vector<std::string>> rows = {{"", "points", "largest", "left max", "left rms", "unit"}};
  for (const reports::Column& column : report.tables) {
    rows.push_back({column.of + JoinedWith(column.over, " over "), absl::StrJoin(column.points, " x "),
                    NumberText(column.largest), NumberText(column.left_max), NumberText(column.left_rms),
                    column.unit});
  }
  if (rows.size() > 1) absl::StrAppend(&text, Table(rows));
  rows = {{"tool point", "max um", "rms um"}};
  const auto row = [&rows](const std::string& name, const reports::PointSpread& spread) {
    rows.push_back({name, NumberText(spread.max_um), NumberText(spread.rms_um)});
  };
  if (report.along_axes) {
    row("along the axes, before", report.along_axes->before);
    row("along the axes, with the table", report.along_axes->after);
  }
  if (report.within_ranges) {
    row("within the ranges, before", report.within_ranges->before);
    row("within the ranges, with the table", report.within_ranges->after);
  }
  absl::StrAppend(&text, Table(rows));
  for (const std::string& line : report.not_carried) absl::StrAppend(&text, "not carried: ", line, "\n");
  for (const std::string& line : report.notes) absl::StrAppend(&text, "note: ", line, "\n");
  return text;
}

absl::Status CheckPaths(const Context& context, const TableCommandArguments& arguments) {
  std::vector<NamedPath> inputs;
  if (context.server.empty() && arguments.errors.empty()) inputs.push_back({"the database", context.database});
  if (!arguments.errors.empty()) {
    inputs.push_back({"--machine", arguments.machine});
    inputs.push_back({"--errors", arguments.errors});
  }
  return CheckOutputs(inputs, {{"--output", arguments.output}, {"--report", arguments.report}});
}

// What the file says of where its errors come from: printable ASCII.
std::string SourceName(const std::string& path) {
  std::string name = std::filesystem::path(path).filename().string();
  for (char& c : name) {
    if (c < 32 || c > 126 || c == '(' || c == ')') c = '_';
  }
  return name;
}

absl::StatusOr<tables::MadeTable> MakeFromFiles(const TableCommandArguments& arguments) {
  ASSIGN_OR_RETURN(const MachineWithErrors model, ReadModelFiles(arguments.machine, arguments.errors));
  ASSIGN_OR_RETURN(tables::TableRequest request, ToTableRequest(arguments.table, model.machine));
  request.calibration = SourceName(arguments.errors);
  return tables::MakeTable(model.machine, model.errors, request);
}

absl::StatusOr<tables::MadeTable> MakeOnService(Context& context, const TableCommandArguments& arguments) {
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  records::TableParams params;
  params.machine = MachineId(arguments.machine);
  ASSIGN_OR_RETURN(const records::MachineRecord record, client->GetMachine(params.machine));
  ASSIGN_OR_RETURN(const machine::Machine machine, machine::MachineFromJson(record.description_json));
  ASSIGN_OR_RETURN(params.request, ToTableRequest(arguments.table, machine));
  if (arguments.calibration != 0) params.calibration = CalibrationId(arguments.calibration);
  ASSIGN_OR_RETURN(records::MadeTable made, client->MakeTable(params));
  return std::move(made.table);
}

absl::Status MakeFile(Context& context, const TableCommandArguments& arguments) {
  RETURN_IF_ERROR(CheckPaths(context, arguments));
  base::AtomicFile file, report_file;
  RETURN_IF_ERROR(file.Open(arguments.output));
  if (!arguments.report.empty()) RETURN_IF_ERROR(report_file.Open(arguments.report));
  ASSIGN_OR_RETURN(const tables::MadeTable made,
                   arguments.errors.empty() ? MakeOnService(context, arguments) : MakeFromFiles(arguments));
  RETURN_IF_ERROR(file.Write(made.text));
  RETURN_IF_ERROR(file.Commit());
  if (!arguments.report.empty()) {
    RETURN_IF_ERROR(report_file.Write(made.report_json));
    RETURN_IF_ERROR(report_file.Commit());
  }
  ASSIGN_OR_RETURN(const reports::Table report, reports::ReadTable(made.report_json));
  context.Print(Json::Document(made.report_json), TableReportText(report, arguments.output));
  return absl::OkStatus();
}

}  // namespace

void AddTableCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<TableCommandArguments>();
  CLI::App* table = app.add_subcommand("table", "Compensation tables for controllers, checked before they are written");
  CLI::Option* list = table->add_flag("--list", arguments->list, "list the formats with their limits");
  AddModelOptions(*table, arguments->machine, arguments->errors, arguments->calibration);
  AddTableOptions(*table, arguments->table);
  table->add_option("-o,--output", arguments->output, "the table");
  table->add_option("--report", arguments->report, "write the report as JSON");
  // --list stands alone; everything else needs these.
  const std::vector<std::string> required = {"--machine", "--format", "--output"};
  for (const std::string& name : required) table->get_option(name)->required(false);
  table->footer(
      "The file is read back and evaluated on the machine's chain, as the controller interpolates it, before it is "
      "written:\n"
      "the error with and without it is stated, and what the format cannot carry is listed.\n"
      "Examples: axiscal table --list\n"
      "          axiscal table --machine mt --format siemens-cec -o cec.mpf\n"
      "          axiscal table --machine machine.json --errors errors.json --format linuxcnc-comp --axis X --range "
      "X=-300:300 -o x.comp");
  SetAction(table, context, [&context, arguments, table, list, required]() -> absl::Status {
    if (list->count() > 0) return ListFormats(context);
    for (const std::string& name : required) {
      // CLI11 reports usage errors this way.
      if (table->get_option(name)->count() == 0) throw CLI::RequiredError(name);
    }
    return MakeFile(context, *arguments);
  });
}

}  // namespace axiscal::cli
