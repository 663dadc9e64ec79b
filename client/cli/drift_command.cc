// axiscal drift
#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/drift_limit.h"
#include "client/cli/record_output.h"

namespace axiscal::cli {
namespace {

struct DriftArguments {
  std::string machine;
  std::vector<std::string> limits;
  bool counts_candidates = false;
};

Json FindingJson(const records::DriftFinding& finding) {
  Json amounts = Json::Array();
  for (const records::DriftAmount& amount : finding.amounts) {
    amounts.push_back(
        {{"symbol", amount.symbol}, {"size", amount.size}, {"sigma", amount.sigma}, {"unit", UnitName(amount.unit)}});
  }
  return {{"kind", DriftKindName(finding.kind)},
          {"text", finding.text},
          {"at", TimeJson(finding.at)},
          {"after", TimeJson(finding.after)},
          {"by", TimeJson(finding.by)},
          {"amounts", amounts},
          {"certainty", NumberJson(finding.certainty)},
          {"is_revision", finding.is_revision},
          {"is_over", finding.is_over}};
}

Json ForecastJson(const records::LimitForecast& forecast) {
  return {{"symbol", forecast.limit.symbol},
          {"low", forecast.limit.low},
          {"high", forecast.limit.high},
          {"text", forecast.text},
          {"probability_now", NumberJson(forecast.probability_now)},
          {"probability_within_year", NumberJson(forecast.probability_within_year)},
          {"earliest", TimeJson(forecast.earliest)},
          {"median", TimeJson(forecast.median)},
          {"latest", TimeJson(forecast.latest)}};
}

std::string DriftText(const records::DriftReport& report) {
  std::string text = absl::StrCat(report.counted.size(), " of ", report.calibrations, " calibrations count\n");
  for (const std::string& left_out : report.left_out) absl::StrAppend(&text, left_out, "\n");
  auto mark = report.marks.begin();
  const auto add_marks_until = [&](base::UtcTime at) {
    for (; mark != report.marks.end() && mark->content.at <= at; ++mark)
      absl::StrAppend(&text, TimeText(mark->content.at).substr(0, 10), "  ", MarkText(*mark));
  };
  for (const records::DriftFinding& finding : report.findings) {
    add_marks_until(finding.at);
    absl::StrAppend(&text, TimeText(finding.at).substr(0, 10), "  ", finding.text, "\n");
  }
  add_marks_until(base::UtcTime::max());
  if (report.findings.empty()) text += "nothing to tell: no step, no wear, no season, scatter as stated\n";
  for (const records::LimitForecast& forecast : report.limits) absl::StrAppend(&text, forecast.text, "\n");
  return text;
}

absl::Status ShowDrift(Context& context, const DriftArguments& arguments) {
  records::DriftSearch search;
  search.machine = MachineId(arguments.machine);
  search.counts_candidates = arguments.counts_candidates;
  for (const std::string& text : arguments.limits) {
    ASSIGN_OR_RETURN(const records::DriftLimit limit, ReadDriftLimit("--limit", text));
    search.limits.push_back(limit);
  }
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::DriftReport report, client->FindDrift(search));
  Json findings = Json::Array(), limits = Json::Array(), counted = Json::Array(), left_out = Json::Array();
  Json marks = Json::Array();
  for (const records::Mark& mark : report.marks) marks.push_back(ToJson(mark));
  for (const records::DriftFinding& finding : report.findings) findings.push_back(FindingJson(finding));
  for (const records::LimitForecast& forecast : report.limits) limits.push_back(ForecastJson(forecast));
  for (const CalibrationId id : report.counted) counted.push_back(id.number());
  for (const std::string& text : report.left_out) left_out.push_back(text);
  context.Print({{"machine", arguments.machine},
                 {"calibrations", report.calibrations},
                 {"counted", counted},
                 {"left_out", left_out},
                 {"findings", findings},
                 {"marks", marks},
                 {"limits", limits}},
                DriftText(report));
  return absl::OkStatus();
}

}  // namespace

void AddDriftCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<DriftArguments>();
  CLI::App* drift = app.add_subcommand(
      "drift",
      "What happened to a machine: collisions, wear, seasons, bad calibrations; when errors leave their limits");
  drift->add_option("--machine", arguments->machine, "the machine")->required();
  drift->add_option("--limit", arguments->limits, "an error's limits, um or urad (EX0C=-20..20); again for more");
  drift->add_flag("--candidates", arguments->counts_candidates,
                  "count the newest candidate of sessions of which none was ever approved, whoever made it");
  drift->footer(
      "Example: axiscal drift --machine mt --limit EX0C=-20..20\nWhat counts, and how often it is right: "
      "docs/drift.md.");
  SetAction(drift, context, [&context, arguments] { return ShowDrift(context, *arguments); });
}

}  // namespace axiscal::cli
