// axiscal published: what a publication's own formulas make of sessions, beside the exact model, with its errata.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/machine_source.h"
#include "client/cli/session_choice.h"
#include "core/published/comparison.h"
#include "core/session/case.h"

namespace axiscal::cli {
namespace {

struct Arguments {
  std::string source, machine;
  std::vector<std::string> sessions;
  bool list = false;
};

absl::Status List(Context& context) {
  Json sources = Json::array();
  std::string text;
  for (const published::Source& source : published::Sources()) {
    sources.push_back({{"source", source.name}, {"citation", source.citation}, {"needs", source.needs}});
    absl::StrAppend(&text, source.name, ": ", source.citation, "\n  needs ", source.needs, "\n");
  }
  context.Print({{"sources", sources}}, text);
  return absl::OkStatus();
}

// A file of that name, else a stored session.
absl::StatusOr<session::Session> SessionFrom(Context& context, const machine::Machine& machine,
                                             const std::string& file_or_name) {
  if (std::filesystem::exists(file_or_name)) return session::ReadSessionFileOf(file_or_name, machine);
  const bool is_path = file_or_name.find_first_of("/.") != std::string::npos;
  if (is_path) return absl::NotFoundError(file_or_name + ": no such file");
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const std::vector<SessionId> ids,
                   NamedSessions(*client, MachineId(machine.id), "published", {file_or_name}));
  return client->DownloadSession(ids[0]);
}

Json NumberOrNull(double number) { return std::isfinite(number) ? Json(number) : Json(nullptr); }

std::string Cell(double number) {
  if (!std::isfinite(number)) return "-";
  return absl::StrFormat("%.2f", std::abs(number) < 0.005 ? 0.0 : number);  // never -0.00
}

absl::Status Compare(Context& context, const Arguments& arguments) {
  if (arguments.list) return List(context);
  if (arguments.source.empty() || arguments.machine.empty() || arguments.sessions.empty()) {
    return absl::InvalidArgumentError("published: expected --list, or SOURCE, --machine and SESSIONS");
  }
  ASSIGN_OR_RETURN(const published::Source* const source, published::FindSource(arguments.source));
  ASSIGN_OR_RETURN(const machine::Machine machine, MachineFrom(context, arguments.machine));
  std::vector<session::Session> sessions;
  for (const std::string& name : arguments.sessions) {
    ASSIGN_OR_RETURN(sessions.emplace_back(), SessionFrom(context, machine, name));
  }
  ASSIGN_OR_RETURN(const published::Comparison comparison, source->compare(machine, sessions));
  Json rows = Json::array();
  std::vector<std::vector<std::string>> table = {
      {"quantity", "published", "corrected", "exact", "sigma", "unit", "exact is", "erratum or what is missing"}};
  for (const published::Row& row : comparison.rows) {
    rows.push_back({{"quantity", row.quantity},
                    {"formula", row.formula},
                    {"unit", row.unit},
                    {"published", NumberOrNull(row.published)},
                    {"corrected", NumberOrNull(row.corrected)},
                    {"symbol", row.symbol},
                    {"exact", NumberOrNull(row.exact)},
                    {"sigma", NumberOrNull(row.sigma)},
                    {"note", row.note}});
    table.push_back({row.quantity, Cell(row.published), Cell(row.corrected), Cell(row.exact), Cell(row.sigma), row.unit,
                     row.symbol, row.note});
  }
  std::string text = absl::StrCat("by the formulas of ", source->citation, "; for comparison only\n", Table(table));
  for (const std::string& note : comparison.notes) absl::StrAppend(&text, note, "\n");
  context.Print({{"source", source->name}, {"citation", source->citation}, {"rows", rows}, {"notes", comparison.notes}},
                text);
  return absl::OkStatus();
}

}  // namespace

void AddPublishedCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* published = app.add_subcommand(
      "published", "What a publication's own formulas make of sessions, beside the exact model, with its errata");
  published->add_option("SOURCE", arguments->source, "one of --list");
  published->add_option("SESSIONS", arguments->sessions, "session files, or numbers or names of stored sessions");
  published->add_option("--machine", arguments->machine, "the machine, or its machine.json without any database");
  published->add_flag("--list", arguments->list, "the publications whose formulas are known");
  published->footer(
      "For comparison only: no number of it reaches a calibration, a table or a program.\n"
      "Example: axiscal published yao-table-4.5 --machine machine.json eccentricity-B.csv eccentricity-C.csv "
      "eccentricity-C-long.csv");
  SetAction(published, context, [&context, arguments] { return Compare(context, *arguments); });
}

}  // namespace axiscal::cli
