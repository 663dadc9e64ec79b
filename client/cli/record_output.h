// The store's records as JSON documents and as lines of tables.
#ifndef AXISCAL_CLIENT_CLI_RECORD_OUTPUT_H_
#define AXISCAL_CLIENT_CLI_RECORD_OUTPUT_H_

#include <string>
#include <vector>

#include "client/cli/output.h"
#include "client/client.h"
#include "core/reports/fitted.h"

namespace axiscal::cli {

const char* StateName(records::SessionState state);
const char* StateName(records::JobState state);
const char* StateName(records::CalibrationState state);
const char* UnitName(records::EstimateUnit unit);

Json ToJson(const records::MachineRecord& record);
Json ToJson(const records::SessionRecord& record);
Json ToJson(const records::JobRecord& record);
Json ToJson(const records::Estimate& estimate);
// With model and report where the record has them.
Json ToJson(const records::CalibrationRecord& record);
Json ToJson(const records::ProgramRecord& record);
Json ToJson(const records::DriftSeries& series);
Json ToJson(const records::FleetRow& row);
Json ToJson(const records::TokenRecord& token);
Json ToJson(const records::PrincipalRecord& principal);
Json ToJson(const records::MachineAccess& access);
Json ToJson(const client::AuditEntry& entry);
Json ToJson(const records::Mark& mark);
Json ToJson(const records::Event& event);
// What it says, what to do, and what people said to it; some lines.
std::string EventText(const records::Event& event);
Json ToJson(const records::EventChange& change);
// One line: "12 2026-05-12 14:00:00 mt raised event 7 (out-of-tolerance): EX0C is ...".
std::string ChangeText(const records::EventChange& change);
const char* DriftKindName(records::DriftKind kind);
const char* MarkKindName(records::MarkKind kind);
// "mark 3 of mt: collision at 2026-05-12 14:00:00 of all errors, put in by ann: hit the chuck".
std::string MarkText(const records::Mark& mark);
// "cell of machine mt".
std::string GrantText(const records::Grant& grant);
Json GrantsJson(const std::vector<records::Grant>& grants);

// {"NAME": [...], "next_page": "..."}.
template <typename Row>
Json PageJson(const std::string& name, const records::Page<Row>& page) {
  Json rows = Json::Array();
  for (const Row& row : page.rows) rows.push_back(ToJson(row));
  return {{name, rows}, {"next_page", page.next_token}};
}

// "next page: --page TOKEN" under a table, nothing on the last page.
template <typename Row>
std::string PageText(const records::Page<Row>& page) {
  return page.next_token.empty() ? "" : "more: --page " + page.next_token + "\n";
}

// The simulation of a report, one line per error or effect; nothing where nothing was simulated. `with_held`: linear
// propagation is of what is known of held errors too, else of the readings' noise alone.
std::string MonteCarloText(const reports::Fitted& fitted, bool with_held);

// The estimates of a calibration as a table, with the combinations that the data determine, and the rms before and
// after; of a loop also its effects and verdict.
std::string CalibrationText(const records::CalibrationRecord& record);
// Its sessions that do not count any more: "5, 7".
std::string RejectedText(const records::CalibrationRecord& record);

// What whoever approves it should know: structure without a name, a poor fit. Empty when there is nothing.
std::string CautionText(const records::CalibrationRecord& record);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_RECORD_OUTPUT_H_
