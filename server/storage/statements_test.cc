// What the store asks SQLite costs the same however many rows there are: every statement that its calls make is caught
// as it is run, on tables whose rows fit no filter, and its plan and its steps are looked at.
#include <gtest/gtest.h>

#include <map>
#include <regex>

#include "server/storage/sqlite_connection.h"
#include "server/storage/testing/caught_statements.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

constexpr int kRows = 20000;
// A list's page of 50 rows, with what belongs to them, stays far below; a scan takes some steps for each row.
constexpr int kMaxSteps = 2 * kRows;

// Machine "mt" (key 1) and rows of it that no filter of CallAll() fits: complete sessions, succeeded jobs, retired
// calibrations, programs merged into one.
void Fill(const std::string& path) {
  const std::unique_ptr<SqliteConnection> connection = *SqliteConnection::Open(path, Access::kWrite);
  const std::string rows =
      absl::StrCat("WITH RECURSIVE n (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < ", kRows, ") ");
  const char* const fills[] = {
      "INSERT INTO session (machine_id, name, instrument, state, next_seq, reading_count, hash, created_by, "
      "request_id, "
      "body_sha256, created_at_utc_us, last_seen_at_utc_us, closed_at_utc_us) "
      "SELECT 1, 's', 'touch', 2, 0, 0, 'h', 'u', 'r' || i, 'b', i, i, i FROM n",
      "INSERT INTO session_column (session_id, position, name, is_text) SELECT id, 0, 'X_mm', 0 FROM session WHERE "
      "name = 's'",
      "INSERT INTO job (kind, machine_id, params, input_hash, priority, state, attempt, max_attempts, lease_token, "
      "cancel_requested, progress_stage, progress_fraction, progress_detail, result, created_by, request_id, "
      "body_sha256, created_at_utc_us, version) "
      "SELECT 'identify', 1, x'00', 'h' || i, 0, 3, 1, 3, 1, 0, '', 1.0, '', x'00', 'u', 'r' || i, 'b', i, 1 FROM n",
      "INSERT INTO calibration (machine_id, version, machine_revision, state, etag, measured_at_utc_us, model_json, "
      "options_json, report_json, engine_version, rank, created_by, created_at_utc_us, checksum) "
      "SELECT 1, i, 1, 3, 1, i, '', '', '', 'e', 1, 'u', i, 'c' FROM n",
      "INSERT INTO estimate (machine_id, symbol, measured_at_utc_us, calibration_id, position, unit, identifiable, "
      "estimated_um_urad) SELECT 1, 'EX0C', i, id, 0, 1, 1, 1.0 FROM n JOIN calibration AS c ON c.version = i",
      "INSERT INTO estimate_week (machine_id, symbol, week, unit, estimate_count, not_identifiable_count, min_um_urad, "
      "max_um_urad, sum_um_urad) SELECT 1, 'EX0C', i, 1, 1, 0, 1.0, 1.0, 1.0 FROM n",
      "INSERT INTO program (kind, name, state, byte_count, sha256, created_by, body_sha256, created_at_utc_us, "
      "last_seen_at_utc_us) VALUES ('nc', 'O1', 2, 0, 'h', 'u', 'b', 0, 0)",
      "INSERT INTO program (kind, name, state, byte_count, same_as, created_by, request_id, body_sha256, "
      "created_at_utc_us, last_seen_at_utc_us) SELECT 'nc', 'O1', 3, 0, 1, 'u', 'r' || i, 'b', i, i FROM n",
      "INSERT INTO mark (machine_id, at_utc_us, kind, note, created_by, request_id, body_sha256, created_at_utc_us) "
      "SELECT 1, i, 1, '', 'u', 'r' || i, 'b', i FROM n",
      "INSERT INTO event (machine_id, kind, subject, text, advice, raised_at_utc_us, cleared_at_utc_us, cleared_why, "
      "acknowledged_by, acknowledged_note, shelved_by, shelved_note) "
      "SELECT 1, 1, 's' || i, '', '', i, i, '', '', '', '', '' FROM n",
      "INSERT INTO event_change (event_id, what, at_utc_us, by, note) SELECT i, 1, i, '', '' FROM n",
      "INSERT INTO routine (name, scope, scope_name, principal, within_hours, work, budget_json, monte_carlo_seed, "
      "is_enabled, note, after_session_id, etag, created_by, created_at_utc_us, changed_by, changed_at_utc_us, "
      "removed_by, removed_at_utc_us) "
      "SELECT 'r' || i, 3, 'mt', 'u', 1, 1, '', 1, 1, '', 0, 1, 'u', i, 'u', i, 'u', i FROM n",
      "INSERT INTO routine_run (routine_id, routine_etag, machine_id, principal, state, text, began_at_utc_us, "
      "ended_at_utc_us) SELECT i, 1, 1, 'u', 5, '', i, i FROM n",
      "INSERT INTO audit (at_utc_us, principal, action, resource, outcome, detail) SELECT i, 'u', 'a', 'r', 'OK', '' "
      "FROM n",
  };
  for (const char* const fill : fills) {
    const bool is_of_rows = std::string(fill).find("FROM n") != std::string::npos;
    const std::string sql = fill;
    const size_t select = sql.find("SELECT");
    // WITH stands before the SELECT of an INSERT.
    const absl::Status filled =
        connection->Execute(is_of_rows ? sql.substr(0, select) + rows + sql.substr(select) : sql);
    ASSERT_TRUE(filled.ok()) << filled;
  }
}

// Every call of Database, every filter of every list.
void CallAll(TempDatabase& database, SessionId stored) {
  const MachineId mt("mt");
  for (const std::optional<MachineId>& machine : {std::optional<MachineId>(), std::optional<MachineId>(mt)}) {
    for (const PageRequest& page : {PageRequest{}, PageRequest{1, ""}}) {
      ASSERT_TRUE(database->ListSessions({machine, {}}, page).ok());
      ASSERT_TRUE(database->ListJobs({machine, {}, ""}, page).ok());
      ASSERT_TRUE(database->ListJobs({machine, {}, "none"}, page).ok());
      ASSERT_TRUE(database->ListCalibrations({machine, {}}, page).ok());
    }
    for (const int state : {1, 2, 3, 4}) {
      ASSERT_TRUE(database->ListSessions({machine, static_cast<SessionState>(state)}, {}).ok());
      ASSERT_TRUE(database->ListCalibrations({machine, static_cast<CalibrationState>(std::min(state, 3))}, {}).ok());
    }
    for (const int state : {1, 2, 3, 4, 5, 6})
      ASSERT_TRUE(database->ListJobs({machine, static_cast<JobState>(state), ""}, {}).ok());
  }
  // Held to more than machine and state.
  const TimeSpan span = {base::FromUtcUs(0), base::FromUtcUs(1)};
  for (const std::optional<MachineId>& machine : {std::optional<MachineId>(), std::optional<MachineId>(mt)}) {
    ASSERT_TRUE(database->ListSessions({machine, {}, span, "none", "none"}, {}).ok());
    ASSERT_TRUE(database->ListSessions({machine, SessionState::kOpen, {}, "", "s"}, {}).ok());
    ASSERT_TRUE(database->ListSessions({machine, {}, {}, "", "", "none"}, {}).ok());
    ASSERT_TRUE(database->ListSessions({machine, SessionState::kComplete, {{}, span.to}}, {}).ok());
    ASSERT_TRUE(database->ListJobs({machine, {}, "", span, "none"}, {}).ok());
    ASSERT_TRUE(database->ListJobs({machine, JobState::kSucceeded, "", {}, "none"}, {}).ok());
    ASSERT_TRUE(database->ListCalibrations({machine, {}, span, stored}, {}).ok());
    ASSERT_TRUE(database->ListCalibrations({machine, CalibrationState::kRetired, {}, stored}, {}).ok());
  }
  ASSERT_TRUE(database->AnnotateSession(stored, "note", {"warm"}, 0, Cell("")).ok());
  ASSERT_TRUE(database->RejectSession(stored, true, "why", Cell("")).ok());
  ASSERT_TRUE(database->RejectSession(stored, false, "why", Cell("")).ok());
  EXPECT_FALSE(database->GetApprovedByPerson(mt).ok());
  ASSERT_TRUE(database->GetFormerOf(CalibrationId(1)).ok());
  ASSERT_TRUE(database->ListDecisions(CalibrationId(1), 20).ok());
  for (const std::string kind : {"", "nc", "none"}) ASSERT_TRUE(database->ListPrograms({kind}, {}).ok());
  ASSERT_TRUE(database->ListMachines({}).ok());
  ASSERT_TRUE(database->ListAudit({}).ok());
  for (const AuditFilter& filter : {AuditFilter{{}, {}, "none", ""}, AuditFilter{{}, {}, "", "none"},
                                    AuditFilter{base::FromUtcUs(1'000'000), base::FromUtcUs(2'000'000), "", ""}})
    ASSERT_TRUE(database->ListAudit(filter, {}).ok());
  ASSERT_TRUE(database->LatestFleet({}, {}).ok());
  ASSERT_TRUE(database->ListCare({}, {}).ok());
  ASSERT_TRUE(database->LatestFleet({"EX0C"}, {}).ok());
  ASSERT_TRUE(database->QueryDrift({mt, {"EX0C"}, UtcTime(), base::FromUtcUs(10), 5}).ok());
  ASSERT_TRUE(database->QueryDrift({mt, {"EX0C"}, UtcTime(), base::FromUtcUs(1'000'000'000), 50}).ok());

  // What a principal of one machine sees.
  const Visible some = {false, {{records::Scope::Kind::kMachine, "mt"}, {records::Scope::Kind::kGroup, "g"}}, "u"};
  for (const PageRequest& page : {PageRequest{}, PageRequest{1, ""}}) {
    ASSERT_TRUE(database->ListSessions({}, page, some).ok());
    ASSERT_TRUE(database->ListSessions({{}, SessionState::kOpen}, page, some).ok());
    ASSERT_TRUE(database->ListJobs({}, page, some).ok());
    ASSERT_TRUE(database->ListJobs({{}, JobState::kFailed, ""}, page, some).ok());
    ASSERT_TRUE(database->ListCalibrations({}, page, some).ok());
    ASSERT_TRUE(database->ListCalibrations({{}, CalibrationState::kCandidate}, page, some).ok());
    ASSERT_TRUE(database->ListSessions({{}, {}, span, "none"}, page, some).ok());
    ASSERT_TRUE(database->ListJobs({{}, {}, "", span, "none"}, page, some).ok());
    ASSERT_TRUE(database->ListCalibrations({{}, {}, span, stored}, page, some).ok());
    ASSERT_TRUE(database->ListPrograms({""}, page, some).ok());
    ASSERT_TRUE(database->ListPrograms({"none"}, page, some).ok());
    ASSERT_TRUE(database->ListMachines(page, some).ok());
    ASSERT_TRUE(database->LatestFleet({}, page, some).ok());
    ASSERT_TRUE(database->ListCare(page, some).ok());
  }
  ASSERT_TRUE(database->SetExpectations({mt, {{"EX0C", -1, 1}}, 90, {{"CR", 24}}, false}, 0, Cell("")).ok());
  ASSERT_TRUE(database->GetExpectations(mt).ok());
  EventContent content;
  content.kind = EventKind::kWear;
  content.amounts = {{"EX0C", EstimateUnit::kUm, 1.0, 0.1}};
  const StandingFinding finding{DriftKind::kStep, UtcTime(), "jumped"};
  ASSERT_EQ(*database->ChangeEvents(
                {.machine = mt, .raised = {content}, .looked_at = 1, .looked_by = "1", .findings = {finding}}),
            1);
  const EventId event = database->ListEvents({{}, true}, {}, {})->rows.at(0).id;
  ASSERT_EQ(*database->ChangeEvents({.machine = mt, .updated = {{event, content}}}), 1);
  for (const bool is_open_only : {false, true}) {
    ASSERT_TRUE(database->ListEvents({{}, is_open_only}, {}, {}).ok());
    ASSERT_TRUE(database->ListEvents({mt, is_open_only}, {}, {}).ok());
    const Visible one{false, {{records::Scope::Kind::kMachine, "mt"}}, "ann"};
    ASSERT_TRUE(database->ListEvents({{}, is_open_only}, {}, one).ok());
    ASSERT_TRUE(database->ReadEventChanges(0, {}, one).ok());
  }
  ASSERT_TRUE(database->GetEvent(event).ok());
  ASSERT_TRUE(database->StandingEvents(mt).ok());
  ASSERT_TRUE(database->ShelveEvent(event, database.clock.UtcNow() + std::chrono::hours(1), "", Cell("")).ok());
  database.clock.Advance(std::chrono::hours(1));
  ASSERT_EQ(*database->BringBackEvents(), 1);
  ASSERT_TRUE(database->AcknowledgeEvent(event, "", Cell("")).ok());
  ASSERT_EQ(*database->ChangeEvents({.machine = mt, .cleared = {{event, "over"}}}), 1);
  ASSERT_TRUE(database->LastEventChange().ok());
  ASSERT_TRUE(database->GetLookStand(mt).ok());
  ASSERT_TRUE(database->MachinesToLookAt("1").ok());
  ASSERT_TRUE(database->NewestSession(mt, "CR").ok());
  ASSERT_TRUE(database->WhereBelongs({ResourceKind::kEvent, "", event.number()}, "ann").ok());
  const NewMark mark{mt, database.clock.UtcNow(), records::MarkKind::kService, {"EX0C"}, ""};
  ASSERT_TRUE(database->PutMark(mark, Cell("m")).ok());
  const auto put = database->PutMark(mark, Cell("m"));
  ASSERT_TRUE(put.ok()) << put.status();
  ASSERT_TRUE(database->ListMarks(mt, {}).ok());
  ASSERT_TRUE(database->NoteHandedTable(CalibrationId(1), "general", Cell("")).ok());
  ASSERT_TRUE(database->ListHandedTables(mt).ok());
  CellReport report;
  report.machine = mt;
  report.name = "seven";
  ASSERT_TRUE(database->ReportCell(report, Cell("")).ok());
  for (const std::optional<MachineId>& machine : {std::optional<MachineId>(), std::optional<MachineId>(mt)}) {
    ASSERT_TRUE(database->ListCells(machine, {}, {}).ok());
    ASSERT_TRUE(database->ListCells(machine, {}, {false, {{records::Scope::Kind::kMachine, "mt"}}, "ann"}).ok());
  }
  ASSERT_TRUE(database->SumCells().ok());
  ASSERT_TRUE(database->MachinesWithEvents(5).ok());
  ASSERT_TRUE(database->ForgetCell(mt, "seven", Cell("")).ok());
  ASSERT_TRUE(database->WithdrawMark(put->id, Cell("")).ok());
  ASSERT_TRUE(database->WhereBelongs({ResourceKind::kMark, "", put->id.number()}, "ann").ok());
  ASSERT_TRUE(database->CreatePrincipal("ann", "", Cell("")).ok());
  ASSERT_TRUE(database->ChangeRole("ann", {records::Role::kViewer, {}}, true, Cell("")).ok());
  ASSERT_TRUE(database->ChangeGroup("g", mt, true, Cell("")).ok());
  ASSERT_TRUE(database->SetFourEyes(mt, true, Cell("")).ok());
  const auto token = database->CreateToken({"ann", "hash", "", {}}, Cell(""));
  ASSERT_TRUE(token.ok()) << token.status();
  ASSERT_TRUE(database->TouchToken(token->id).ok());
  ASSERT_TRUE(database->FindHolderOfToken("hash").ok());
  ASSERT_TRUE(database->FindHolderOfName("ann").ok());
  for (const ResourceKind kind :
       {ResourceKind::kSession, ResourceKind::kJob, ResourceKind::kCalibration, ResourceKind::kProgram})
    ASSERT_TRUE(database->WhereBelongs({kind, "", 1}, "ann").ok());
  ASSERT_TRUE(database->WhereBelongs({ResourceKind::kMachine, "mt", 0}, "ann").ok());
  ASSERT_TRUE(database->ListPrincipals({}).ok());
  Routine routine;
  routine.name = "nightly";
  routine.scope = {records::Scope::Kind::kGroup, "g"};
  routine.principal = "ann";
  routine.sessions = {"CR"};
  const auto declared = database->PutRoutine(routine, 0, Cell(""));
  ASSERT_TRUE(declared.ok()) << declared.status();
  routine.note = "again";
  ASSERT_EQ(database->PutRoutine(routine, 0, Cell(""))->etag, 2);
  ASSERT_EQ(database->MachinesWithRoutines()->size(), 1u);
  const RoutineRecord present = database->RoutinesOf(mt)->at(0);
  ASSERT_TRUE(database->NewSessionFor(present.id, mt, "s").ok());
  const auto run = database->BeginRun(present, mt, {stored}, {});
  ASSERT_TRUE(run.ok()) << run.status();
  ASSERT_EQ(database->MachinesWithRoutines()->size(), 1u);
  ASSERT_EQ(database->NewestRuns(mt)->size(), 1u);
  ASSERT_TRUE(database->ChangeRun({run->id, RunState::kFailed, {}, {}, "why"}).ok());
  ASSERT_TRUE(database->RetryRoutine("nightly", mt, Cell("")).ok());
  for (const RunFilter& filter : {RunFilter{}, RunFilter{mt, ""}, RunFilter{{}, "nightly"}, RunFilter{mt, "nightly"}}) {
    ASSERT_TRUE(database->ListRuns(filter, {}, {}).ok());
    ASSERT_TRUE(database->ListRuns(filter, {}, some).ok());
  }
  ASSERT_TRUE(database->StopRoutine("nightly", mt, true, "", Cell("")).ok());
  ASSERT_EQ(database->ListRoutines({})->size(), 1u);
  ASSERT_EQ(database->ListRoutines(some)->size(), 1u);
  ASSERT_TRUE(database->StopRoutine("nightly", mt, false, "", Cell("")).ok());
  ASSERT_TRUE(database->RemoveRoutine("nightly", 0, Cell("")).ok());
  Webhook webhook;
  webhook.name = "mes";
  webhook.scope = {records::Scope::Kind::kGroup, "g"};
  ASSERT_TRUE(database->PutWebhook(webhook, {"whsec_", false}, 0, Cell("")).ok());
  webhook.note = "again";
  const auto hook = database->PutWebhook(webhook, {"whsec_", true}, 0, Cell(""));
  ASSERT_TRUE(hook.ok()) << hook.status();
  WebhookStep step;
  step.webhook = hook->id;
  step.etag = hook->etag;
  step.from = step.to = hook->after_change;
  step.dead = {1, 4, "HTTP 500"};
  ASSERT_TRUE(*database->StepWebhook(step));
  ASSERT_EQ(database->ListDeadLetters("mes", {})->rows.size(), 1u);
  ASSERT_EQ(*database->ResendDeadLetters("mes", 1, Cell("")), 1);
  ASSERT_EQ(*database->ResendDeadLetters("mes", {}, Cell("")), 1);
  ASSERT_TRUE((*database->WantedLetter(hook->id)).has_value());
  ASSERT_TRUE(*database->EndWantedLetter(hook->id, 1, "HTTP 500"));
  ASSERT_TRUE(*database->EndWantedLetter(hook->id, 1, ""));
  ASSERT_EQ(database->ListWebhooks()->size(), 1u);
  ASSERT_TRUE(database->GetWebhook("mes").ok());
  ASSERT_TRUE(database->RemoveWebhook("mes", 0, Cell("")).ok());
  ASSERT_TRUE(database->ListMachineAccess({}).ok());
  ASSERT_TRUE(database->RevokeToken(token->id, Cell("")).ok());
  ASSERT_TRUE(database->RevokePrincipal("ann", Cell("")).ok());

  ASSERT_TRUE(database->UpdateMachine(mt, 0, "{ }", Cell("")).ok());
  ASSERT_TRUE(database->GetMachineRevision(mt, 1).ok());
  ASSERT_TRUE(database->ReadSession(stored).ok());
  const SessionId open = database->CreateSession(TestSession("open"))->id;
  ASSERT_TRUE(database->CreateSession(TestSession("open")).ok());
  ASSERT_TRUE(Append(*database, open, 0, TestColumns(0, 10)).ok());
  ASSERT_TRUE(Append(*database, open, 0, TestColumns(0, 10)).ok());
  ASSERT_TRUE(database->AbortSession(open).ok());
  ASSERT_TRUE(database->CreateSession(TestSession("left")).ok());
  ASSERT_TRUE(database->BeginProgram({"nc", "O2", Cell("left")}).ok());
  database.clock.Advance(std::chrono::hours(2));
  ASSERT_EQ(*database->ExpireSessions(std::chrono::hours(1)), 1);
  ASSERT_EQ(*database->ExpirePrograms(std::chrono::hours(1)), 1);
  ASSERT_EQ(*database->ExpireAudit(std::chrono::hours(24)), 0);
  ASSERT_EQ(*database->ExpireReadings(std::chrono::hours(24)), 0);

  const ProgramId program = database->BeginProgram({"nc", "O1", Cell("p")})->id;
  ASSERT_TRUE(database->AppendProgram(program, 0, "G01").ok());
  ASSERT_TRUE(database->AppendProgram(program, 0, "G01").ok());
  ASSERT_TRUE(database->FinishProgram(program, 3, "").ok());
  ASSERT_TRUE(database->ReadProgram(program, 0, [](const std::string&) { return absl::OkStatus(); }).ok());

  NewJob job;
  job.kind = "identify";
  job.machine = mt;
  for (const char* id : {"a", "b", "c", "d"}) {
    job.caller = Cell(id);
    ASSERT_TRUE(database->CreateJob(job, 10).ok());
  }
  const std::chrono::seconds lease(30);
  JobRecord running = **database->ClaimJob(lease);
  ASSERT_TRUE(database->HeartbeatJob(ClaimOf(running), lease, {"fit", 0.5, ""}).ok());
  NewCalibration calibration = TestCalibration(database.clock.UtcNow(), 1.0);
  calibration.sessions = {stored};
  const auto done = database->SucceedJob(ClaimOf(running), {"report", calibration, {program}});
  ASSERT_TRUE(done.ok()) << done.status();
  ASSERT_TRUE(database->GetJob(done->id).ok());
  running = **database->ClaimJob(lease);
  const JobError error = {absl::StatusCode::kInternal, "WHY", "because"};
  ASSERT_TRUE(database->EndJob(ClaimOf(running), JobEnd::kFailed, error, {}).ok());
  ASSERT_TRUE(database->RequeueJob(running.id, 10, Cell("")).ok());
  ASSERT_TRUE(database->CancelJob(running.id, Cell("")).ok());
  ASSERT_TRUE((*database->ClaimJob(lease)).has_value());
  ASSERT_TRUE(database->CancelJob(JobId(done->id.number() + 2), Cell("")).ok());
  database.clock.Advance(std::chrono::minutes(1));
  ASSERT_TRUE(database->RescueJobs().ok());
  ASSERT_TRUE(database->NextJobWait().ok());

  const CalibrationId second = database->CreateCalibration(calibration)->id;
  ASSERT_TRUE(database->ApproveCalibration(*done->calibration, 0, Cell("")).ok());
  database.clock.Advance(std::chrono::seconds(1));
  ASSERT_TRUE(database->ApproveCalibration(second, 0, Cell("")).ok());
  ASSERT_TRUE(database->GetApprovedCalibration(mt).ok());
  ASSERT_EQ(*database->GetFormerOf(second), done->calibration);
  ASSERT_TRUE(database->RetireCalibration(second, 0, Cell("")).ok());
  ASSERT_TRUE(database->DeleteMachine(mt, 0, Cell("")).ok());
}

class Statements : public testing::Test {
 protected:
  void SetUp() override {
    stored = StoreSession(*database, 1);
    database.Close();
    ASSERT_NO_FATAL_FAILURE(Fill(database.path()));
    CaughtStatements caught;
    database.Open();
    ASSERT_NO_FATAL_FAILURE(CallAll(database, stored));
    database.Close();
    steps = caught.most_steps();
    ASSERT_GT(steps.size(), 60u);
  }

  TempDatabase database;
  SessionId stored;
  std::map<std::string, int> steps;  // by statement
};

TEST_F(Statements, TakeFewStepsWhateverFitsTheirFilter) {
  for (const auto& [sql, count] : steps) EXPECT_LT(count, kMaxSteps) << sql;
}

TEST_F(Statements, ScanNoTableThatGrows) {
  // What may be read whole: one row; the schema; the ids of a page; what is open, waits or runs (few, and they leave);
  // what has no checksum yet; sub-queries, which have names; who has jobs that
  // wait, and the errors of a machine, each once; what is expected of each machine, which is looked at now
  // and then; routines and webhooks, of which there are 128 and 16 at most; cells, 16 of a machine at most, each with
  // one row.
  const std::regex allowed(
      "SCAN (up_time|expectation|sqlite_master|json_each VIRTUAL TABLE INDEX 1:|CONSTANT "
      "ROW|\\(subquery.*|point|who|w|known|spool|stamp|.* USING "
      "(COVERING "
      ")?INDEX "
      "(session_open|program_open|routine_name|webhook_name|cell_name|run_open_of_machine|event_open|event_shelved|"
      "event_look_"
      "due|job_waiting|"
      "job_running|job_unsealed|"
      "calibration_unsealed|machine_revision_unsealed)."
      "*)");
  // What may be sorted: cells; the machines that have open events.
  const std::regex sorted("FROM cell AS c |AS events FROM event AS e INDEXED BY event_open_of_machine ");
  const std::unique_ptr<SqliteConnection> connection = *SqliteConnection::Open(database.path(), Access::kWrite);
  for (const auto& [sql, count] : steps) {
    if (std::regex_search(sql, std::regex("^(PRAGMA|BEGIN|COMMIT|ROLLBACK|SAVEPOINT|RELEASE|--)"))) continue;
    auto plan = connection->Ask("EXPLAIN QUERY PLAN " + sql);
    ASSERT_TRUE(plan.ok()) << sql << ": " << plan.status();
    while (*plan->Step()) {
      const std::string detail = plan->Text(3);
      EXPECT_TRUE(!detail.starts_with("SCAN") || std::regex_match(detail, allowed)) << detail << "\n  of " << sql;
      EXPECT_TRUE(detail.find("USE TEMP B-TREE") == std::string::npos || std::regex_search(sql, sorted))
          << detail << "\n  of " << sql;
    }
  }
}

}  // namespace
}  // namespace axiscal::storage
