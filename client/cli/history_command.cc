// axiscal history
#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/record_output.h"

namespace axiscal::cli {
namespace {

struct HistoryArguments {
  std::string machine, from, to, page;
  std::vector<std::string> symbols;
  int points = 500, page_size = 0;
  bool fleet = false;
};

absl::Status Drift(Context& context, client::Client& client, const HistoryArguments& arguments) {
  records::DriftQuery query;
  query.machine = MachineId(arguments.machine);
  query.symbols = arguments.symbols;
  query.max_points = arguments.points;
  query.from = base::UtcTime::min();
  query.to = base::UtcTime::max();
  if (!arguments.from.empty()) {
    ASSIGN_OR_RETURN(query.from, ParseTime("--from", arguments.from));
  }
  if (!arguments.to.empty()) {
    ASSIGN_OR_RETURN(query.to, ParseTime("--to", arguments.to));
  }
  ASSIGN_OR_RETURN(const auto series, client.QueryDrift(query));
  Json json = Json::Array();
  std::vector<std::vector<std::string>> rows = {{"error", "when (UTC)", "value", "sigma", "unit", "of", "calibration"}};
  for (const records::DriftSeries& one : series) {
    json.push_back(ToJson(one));
    for (const records::DriftPoint& point : one.points) {
      rows.push_back({one.symbol, TimeText(point.last_at), NumberText(point.mean), NumberText(point.sigma),
                      UnitName(one.unit), absl::StrCat(point.count), absl::StrCat(point.last_calibration.number())});
    }
    if (one.not_identifiable_count > 0) {
      rows.push_back(
          {one.symbol, "", "-", "-", UnitName(one.unit), absl::StrCat(one.not_identifiable_count), "not identifiable"});
    }
  }
  context.Print({{"machine", arguments.machine}, {"series", json}}, Table(rows));
  return absl::OkStatus();
}

absl::Status Fleet(Context& context, client::Client& client, const HistoryArguments& arguments) {
  ASSIGN_OR_RETURN(const auto page, client.LatestFleet(arguments.symbols, {arguments.page_size, arguments.page}));
  std::vector<std::vector<std::string>> rows = {
      {"machine", "error", "value", "sigma", "unit", "when (UTC)", "calibration", "state"}};
  for (const records::FleetRow& machine : page.rows) {
    for (const records::LatestEstimate& latest : machine.latest) {
      rows.push_back({machine.machine.text(), latest.estimate.symbol, NumberText(latest.estimate.value),
                      NumberText(latest.estimate.sigma), UnitName(latest.estimate.unit), TimeText(latest.measured_at),
                      absl::StrCat(latest.calibration.number()), StateName(latest.state)});
    }
  }
  context.Print(PageJson("machines", page), Table(rows) + PageText(page));
  return absl::OkStatus();
}

absl::Status History(Context& context, const HistoryArguments& arguments) {
  if (arguments.fleet == !arguments.machine.empty()) {
    return absl::InvalidArgumentError("history: expected either --machine or --fleet");
  }
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  return arguments.fleet ? Fleet(context, *client, arguments) : Drift(context, *client, arguments);
}

}  // namespace

void AddHistoryCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<HistoryArguments>();
  CLI::App* history = app.add_subcommand("history", "How a machine's errors changed over time");
  history->add_option("--machine", arguments->machine, "the machine");
  history->add_flag("--fleet", arguments->fleet, "the newest errors of every machine instead");
  history->add_option("--symbols", arguments->symbols, "these errors only (EA0B,EX0C)")->delimiter(',');
  history->add_option("--from", arguments->from, "from this UTC time on (2026-05-31 or 2026-05-31T14:03:07)");
  history->add_option("--to", arguments->to, "before this UTC time");
  history
      ->add_option("--points", arguments->points,
                   "at most so many points per error; more are thinned to min, mean and max")
      ->check(CLI::Range(1, 100000));
  history->add_option("--page-size", arguments->page_size, "machines per page with --fleet (1 to 1000)")
      ->check(CLI::Range(1, 1000));
  history->add_option("--page", arguments->page, "token of the next page with --fleet");
  history->footer("Example: axiscal history --machine mt --symbols EA0B,EX0C --from 2026-01-01");
  SetAction(history, context, [&context, arguments] { return History(context, *arguments); });
}

}  // namespace axiscal::cli
