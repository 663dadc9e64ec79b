// axiscal expect
#include <CLI/CLI.hpp>
#include <memory>

#include "absl/strings/numbers.h"
#include "client/cli/commands.h"
#include "client/cli/context.h"
#include "client/cli/drift_limit.h"
#include "client/cli/record_output.h"

namespace axiscal::cli {
namespace {

struct ExpectArguments {
  std::string machine;
  std::vector<std::string> tolerances, sessions;
  std::optional<int> calibration_days;
  bool counts_candidates = false, expects_nothing = false;
};

// "nightly=24".
absl::StatusOr<records::ExpectedSession> ReadExpectedSession(const std::string& text) {
  records::ExpectedSession session;
  const size_t equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0 || !absl::SimpleAtoi(text.substr(equals + 1), &session.every_hours)) {
    return absl::InvalidArgumentError("--session " + text + ": expected NAME=HOURS, as nightly=24");
  }
  session.name = text.substr(0, equals);
  return session;
}

std::string ExpectationsText(const records::ExpectationsRecord& record) {
  const records::Expectations& expected = record.content;
  if (record.etag == 0) return "nothing is expected of machine " + expected.machine.text() + "\n";
  std::string text = absl::StrCat("machine ", expected.machine.text(), ", as ", record.changed_by, " said at ",
                                  TimeText(record.changed_at), " UTC (etag ", record.etag, ")\n");
  for (const records::DriftLimit& limit : expected.tolerances)
    absl::StrAppend(&text, "  ", limit.symbol, " within ", limit.low, " .. ", limit.high, "\n");
  for (const records::ExpectedSession& session : expected.sessions)
    absl::StrAppend(&text, "  session ", session.name, " every ", session.every_hours, " h\n");
  if (expected.calibration_days)
    absl::StrAppend(&text, "  a calibration measured within ", *expected.calibration_days, " days\n");
  if (expected.counts_candidates) text += "  candidates count where nothing was approved\n";
  return text;
}

Json ExpectationsJson(const records::ExpectationsRecord& record) {
  const records::Expectations& expected = record.content;
  Json tolerances = Json::Array(), sessions = Json::Array();
  for (const records::DriftLimit& limit : expected.tolerances)
    tolerances.push_back({{"symbol", limit.symbol}, {"low", limit.low}, {"high", limit.high}});
  for (const records::ExpectedSession& session : expected.sessions)
    sessions.push_back({{"name", session.name}, {"every_hours", session.every_hours}});
  return {{"machine", expected.machine.text()},
          {"tolerances", tolerances},
          {"sessions", sessions},
          {"calibration_days", expected.calibration_days ? Json(*expected.calibration_days) : Json()},
          {"counts_candidates", expected.counts_candidates},
          {"etag", record.etag},
          {"changed_by", record.changed_by},
          {"changed", TimeJson(record.changed_at)}};
}

absl::Status Expect(Context& context, const ExpectArguments& arguments) {
  records::Expectations expected;
  expected.machine = MachineId(arguments.machine);
  for (const std::string& text : arguments.tolerances) {
    ASSIGN_OR_RETURN(const records::DriftLimit limit, ReadDriftLimit("--tolerance", text));
    expected.tolerances.push_back(limit);
  }
  for (const std::string& text : arguments.sessions) {
    ASSIGN_OR_RETURN(const records::ExpectedSession session, ReadExpectedSession(text));
    expected.sessions.push_back(session);
  }
  expected.calibration_days = arguments.calibration_days;
  expected.counts_candidates = arguments.counts_candidates;
  const bool says_something = !expected.tolerances.empty() || !expected.sessions.empty() || expected.calibration_days ||
                              expected.counts_candidates;
  if (says_something && arguments.expects_nothing)
    return absl::InvalidArgumentError("--nothing stands beside what is expected");
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  const bool sets = says_something || arguments.expects_nothing;
  ASSIGN_OR_RETURN(const records::ExpectationsRecord record,
                   sets ? client->SetExpectations(expected) : client->GetExpectations(expected.machine));
  context.Print(ExpectationsJson(record), ExpectationsText(record));
  return absl::OkStatus();
}

}  // namespace

void AddExpectCommand(CLI::App& app, Context& context) {
  auto arguments = std::make_shared<ExpectArguments>();
  CLI::App* expect = app.add_subcommand(
      "expect",
      "What a machine shall hold: tolerances of errors, sessions that come regularly, how old a calibration "
      "may be; without options what was said");
  expect->add_option("--machine", arguments->machine, "the machine")->required();
  expect->add_option("--tolerance", arguments->tolerances,
                     "an error's tolerance, um or urad (EX0C=-20..20); again for more");
  expect->add_option("--session", arguments->sessions,
                     "a session that comes at least every so many hours (nightly=24); again for more");
  expect->add_option("--calibration-days", arguments->calibration_days,
                     "the calibration in use was measured at most so many days ago");
  expect->add_flag("--candidates", arguments->counts_candidates,
                   "count the newest candidate of sessions of which none was ever approved, whoever made it");
  expect->add_flag("--nothing", arguments->expects_nothing, "nothing is expected any more");
  expect->footer(
      "What is said replaces all that was said before.\n"
      "Example: axiscal expect --machine mt --tolerance EX0C=-20..20 --session nightly=24 --calibration-days 90\n"
      "Which events follow: docs/events.md.");
  SetAction(expect, context, [&context, arguments] { return Expect(context, *arguments); });
}

}  // namespace axiscal::cli
