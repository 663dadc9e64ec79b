#include "server/handlers/diagnose.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/handlers/cells.h"
#include "server/handlers/create_machine.h"
#include "server/handlers/testing/test_core.h"

namespace axiscal::handlers {
namespace {

using records::Finding;
using records::FindingState;
using ::testing::HasSubstr;

// A server with which all is well.
ServerFacts Well() {
  ServerFacts facts;
  facts.now = base::FromUtcUs(int64_t{1'780'000'000} * 1'000'000);
  facts.disk_free_bytes = int64_t{1} << 40;
  facts.database_bytes = 1 << 20;
  facts.certificates = {{"server.crt", facts.now + std::chrono::days(300)},
                        {"ca.crt", facts.now + std::chrono::days(30)}};
  facts.descriptors = 20;
  facts.most_descriptors = 1000;
  facts.backup_folder = "/backup";
  facts.last_backup = facts.now - std::chrono::hours(20);
  facts.queued_jobs = 0;
  records::CellRecord cell;
  cell.report.machine = MachineId("mt");
  cell.report.name = "seven";
  facts.cells = {{cell}};
  return facts;
}

// What is found of `what`, that is not well; nothing where it is.
std::optional<Finding> Bad(const ServerFacts& facts, const std::string& what) {
  for (const Finding& finding : FindingsOf(facts)) {
    if (finding.what == what && finding.state != FindingState::kOk) return finding;
  }
  return std::nullopt;
}

TEST(Findings, OfAServerThatIsWellAreWell) {
  const std::vector<Finding> findings = FindingsOf(Well());
  EXPECT_EQ(findings.size(), 9u);
  for (const Finding& finding : findings) {
    EXPECT_EQ(finding.state, FindingState::kOk) << finding.what << ": " << finding.text;
    EXPECT_EQ(finding.advice, "") << finding.what;
  }
}

TEST(Findings, SayWhatIsNotWellAndWhatToDo) {
  const auto expect = [](const std::function<void(ServerFacts&)>& change, const std::string& what, FindingState state,
                         const std::string& text) {
    ServerFacts facts = Well();
    change(facts);
    const std::optional<Finding> bad = Bad(facts, what);
    ASSERT_TRUE(bad.has_value()) << what;
    EXPECT_EQ(bad->state, state) << what;
    EXPECT_THAT(bad->text, HasSubstr(text));
    EXPECT_NE(bad->advice, "") << what;
    int others = 0;
    for (const Finding& finding : FindingsOf(facts)) others += finding.state != FindingState::kOk ? 1 : 0;
    EXPECT_EQ(others, 1) << what << " alone is not well";
  };
  expect([](auto& f) { f.read = absl::UnavailableError("gone"); }, "database", FindingState::kFailed, "gone");
  expect([](auto& f) { f.write = absl::ResourceExhaustedError("full"); }, "database", FindingState::kFailed, "full");
  expect([](auto& f) { f.disk_free_bytes = 4'999'999'999; }, "disk", FindingState::kWarning, "5.0 GB are free");
  expect([](auto& f) { f.disk_free_bytes = (64 << 20) - 1; }, "disk", FindingState::kFailed, "DISK_LOW");
  expect([](auto& f) { f.disk_free_bytes.reset(); }, "disk", FindingState::kUnknown, "could not be asked for");
  expect([](auto& f) { f.certificates[1].second = f.now + std::chrono::days(13); }, "server's certificates",
         FindingState::kWarning, "ca.crt ends in 13 days");
  expect([](auto& f) { f.certificates[0].second = f.now - std::chrono::hours(1); }, "server's certificates",
         FindingState::kFailed, "server.crt has ended");
  expect([](auto& f) { f.open_files = {"axiscal.db (0644)"}; }, "permissions", FindingState::kWarning, "(0644)");
  expect([](auto& f) { f.descriptors = 601; }, "descriptors", FindingState::kWarning, "601 of 1000");
  expect([](auto& f) { f.backup_folder = ""; }, "last backup", FindingState::kWarning, "no folder");
  expect([](auto& f) { f.backup_problem = "Read-only file system"; }, "last backup", FindingState::kFailed,
         "/backup: Read-only file system");
  expect([](auto& f) { f.last_backup.reset(); }, "last backup", FindingState::kWarning, "holds none");
  expect([](auto& f) { f.last_backup = f.now - std::chrono::hours(49); }, "last backup", FindingState::kWarning,
         "49 hours");
  expect([](auto& f) { f.cells->at(0).silence = std::chrono::minutes(20); }, "cells", FindingState::kWarning,
         "seven of mt (20 min)");
  expect([](auto& f) { f.cells.reset(); }, "cells", FindingState::kUnknown, "could not be asked for");
  expect([](auto& f) { f.cells->at(0).report.problem = "spool full"; }, "files of cells", FindingState::kWarning,
         "seven of mt: spool full");
  expect(
      [](auto& f) {
        f.queued_jobs = 3;
        f.oldest_queued = std::chrono::minutes(31);
      },
      "jobs", FindingState::kWarning, "3 wait, the oldest for 31 min");
  expect([](auto& f) { f.dead_letters = {{"mes", 2}}; }, "webhooks", FindingState::kWarning, "mes (2)");
  expect([](auto& f) { f.is_draining = true; }, "server", FindingState::kWarning, "stopping");
}

// What is PostgreSQL's business is not called well or ill here.
TEST(Findings, OfADatabaseOfAServerAskForNoFile) {
  ServerFacts facts = Well();
  facts.has_file = false;
  facts.disk_free_bytes = facts.database_bytes = std::nullopt;
  facts.backup_folder = "";
  facts.last_backup = std::nullopt;
  for (const Finding& finding : FindingsOf(facts)) {
    EXPECT_NE(finding.state, FindingState::kFailed) << finding.what;
    EXPECT_NE(finding.state, FindingState::kWarning) << finding.what << ": " << finding.text;
    if (finding.what == "last backup") {
      EXPECT_THAT(finding.advice, HasSubstr("pg_dump"));
    }
  }
}

class Doctor : public ::testing::Test, protected TestCore {};

TEST_F(Doctor, TellsWhyNothingCanBeWrittenIntoTheFolderOfBackups) {
  core.limits.database_file = "/no/such/axiscal.db";
  core.limits.backup_folder = "/no/such/folder";
  const auto response = Diagnose(core, call, {});
  ASSERT_TRUE(response.ok()) << response.status();
  std::string text;
  for (const v1::Finding& finding : response->findings()) {
    if (finding.what() == "last backup") text = finding.text();
  }
  EXPECT_EQ(text, "/no/such/folder: No such file or directory");
}

TEST_F(Doctor, LooksAtTheServerThatRuns) {
  v1::CreateMachineRequest create;
  create.set_description_json(kMachineJson);
  ASSERT_TRUE(CreateMachine(core, call, create).ok());
  const auto report =
      ReportCell(core, call, Parse<v1::ReportCellRequest>(R"(report { machine_id: "mt" name: "seven" silent_after_s: 900
                   problem: "2 files were refused" waiting_files: 3 })"));
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_FALSE(report->cell().is_silent());
  const auto response = Diagnose(core, call, {});
  ASSERT_TRUE(response.ok()) << response.status();
  std::map<std::string, std::string> texts;
  for (const v1::Finding& finding : response->findings()) texts[finding.what()] = finding.text();
  EXPECT_THAT(texts["database"], HasSubstr("answers and takes"));
  EXPECT_THAT(texts["cells"], HasSubstr("all 1 are heard"));
  EXPECT_THAT(texts["files of cells"], HasSubstr("seven of mt: 2 files were refused"));
  EXPECT_GT(response->now_utc_us(), 0);
}

TEST_F(Doctor, AReportOfACellIsChecked) {
  const auto refusal = [&](const std::string& report) {
    return FieldOf(ReportCell(core, call, Parse<v1::ReportCellRequest>("report {" + report + "}")).status());
  };
  EXPECT_EQ(refusal(R"(name: "seven" silent_after_s: 900)"), "report.machine_id");
  EXPECT_EQ(refusal(R"(machine_id: "mt" silent_after_s: 900)"), "report.name");
  EXPECT_EQ(refusal(R"(machine_id: "mt" name: "seven" silent_after_s: 59)"), "report.silent_after_s");
  EXPECT_EQ(refusal(R"(machine_id: "mt" name: "seven" silent_after_s: 60 waiting_files: -1)"), "report.waiting_files");
}

TEST_F(Doctor, TheLogLevelIsSetAndInTheAudit) {
  records::LogLevel now = records::LogLevel::kInfo;
  core.log_level = [&](std::optional<records::LogLevel> level) { return now = level.value_or(now); };
  EXPECT_EQ(SetLogLevel(core, call, {})->level(), v1::LOG_LEVEL_INFO);
  EXPECT_TRUE(core.database.ListAudit({})->rows.empty()) << "a question changes nothing";
  const auto set = SetLogLevel(core, call, Parse<v1::SetLogLevelRequest>("level: LOG_LEVEL_DEBUG"));
  ASSERT_TRUE(set.ok()) << set.status();
  EXPECT_EQ(set->former_level(), v1::LOG_LEVEL_INFO);
  EXPECT_EQ(set->level(), v1::LOG_LEVEL_DEBUG);
  EXPECT_EQ(now, records::LogLevel::kDebug);
  EXPECT_EQ(core.database.ListAudit({})->rows.at(0).became, "LOG_LEVEL_DEBUG");
  v1::SetLogLevelRequest unknown;
  unknown.set_level(static_cast<v1::LogLevel>(9));
  EXPECT_EQ(FieldOf(SetLogLevel(core, call, unknown).status()), "level");
}

}  // namespace
}  // namespace axiscal::handlers
