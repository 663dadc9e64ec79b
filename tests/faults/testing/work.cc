#include "tests/faults/testing/work.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/base/clock.h"
#include "core/base/sha256.h"
#include "core/base/testing/source_path.h"
#include "server/storage/check.h"
#include "server/storage/sqlite_connection.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

constexpr int kChunks = 4;
const char kProgram[] = "G01 X1.0000\nG01 X2.0000\n";

NewJob TestJob() {
  NewJob job;
  job.kind = "identify";
  job.machine = MachineId("new");
  job.params = "params";
  job.max_attempts = 1000;
  job.caller = Cell("job");
  return job;
}

NewMark TheMark() {
  return {MachineId("new"), base::FromUtcUs(1'700'000'000'000'000), records::MarkKind::kCollision, {"EA0B"}, "hit"};
}

NewSession TheSession(const std::string& request_id) {
  NewSession session = TestSession(request_id);
  session.machine = MachineId("new");
  return session;
}

SessionTotals Totals() {
  std::vector<uint32_t> crcs;
  for (int seq = 0; seq < kChunks; ++seq) crcs.push_back(session::ChunkCrc32c(TestColumns(seq, 10)));
  return {kChunks, kChunks * 10, session::SessionHash(crcs)};
}

}  // namespace

bool IsLong() {
  const char* const wanted = std::getenv("AXISCAL_FAULTS");
  return wanted != nullptr && std::string(wanted) == "long";
}

std::unique_ptr<Database> OpenAt(const std::string& path, base::Clock& clock) {
  SqliteOptions options;
  options.path = path;
  options.clock = &clock;
  absl::StatusOr<std::unique_ptr<Database>> database = OpenSqlite(options);
  return database.ok() ? *std::move(database) : nullptr;
}

void Work(const std::string& path, const Tell& tell, base::Clock& clock) {
  const std::unique_ptr<Database> opened = OpenAt(path, clock);
  if (opened == nullptr) return;
  tell("open");
  Database& database = *opened;
  if (database.CreateMachine(MachineId("new"), "{}", kAnn).ok()) tell("machine");
  if (database.CreatePrincipal("bob", "", kAnn).ok()) tell("principal");
  if (database.ChangeRole("bob", {records::Role::kViewer, {}}, true, kAnn).ok()) tell("role");
  // Made in a former run it is revoked already, and its name does not come back.
  static_cast<void>(database.CreatePrincipal("eve", "", kAnn));
  if (database.RevokePrincipal("eve", kAnn).ok()) tell("revoke");
  if (database.PutMark(TheMark(), Cell("mark")).ok()) tell("mark");
  SessionId session;
  if (const auto created = database.CreateSession(TheSession("session")); created.ok()) {
    tell("session");
    session = created->id;
    for (int seq = 0; seq < kChunks; ++seq) {
      const auto appended = Append(database, session, seq, TestColumns(seq, 10));
      if (appended.ok()) tell(absl::StrCat("chunk ", seq));
    }
    if (database.FinishSession(session, Totals()).ok()) tell("finish");
  }
  if (const auto left = database.CreateSession(TheSession("left")); left.ok()) {
    static_cast<void>(Append(database, left->id, 0, TestColumns(0, 10)));
    if (database.AbortSession(left->id).ok()) tell("abort");
  }
  if (const auto begun = database.BeginProgram({"nc", "O1", Cell("program")}); begun.ok()) {
    const bool is_there = begun->state == ProgramState::kComplete;
    if (is_there || database.AppendProgram(begun->id, 0, kProgram).ok()) {
      tell("part");
      if (database.FinishProgram(begun->id, sizeof(kProgram) - 1, base::Sha256Hex(kProgram)).ok()) tell("program");
    }
  }
  if (database.CreateJob(TestJob(), 10).ok()) tell("job");
  for (int claims = 0; claims < 5; ++claims) {
    const auto claimed = database.ClaimJob(std::chrono::seconds(30));
    if (!claimed.ok() || !claimed->has_value()) continue;
    const JobClaim claim = ClaimOf(**claimed);
    // An old file has jobs of its own.
    if ((*claimed)->machine != MachineId("new")) {
      static_cast<void>(database.EndJob(claim, JobEnd::kFailed, {absl::StatusCode::kInternal, "OLD", "of before"}, {}));
      continue;
    }
    NewCalibration calibration = TestCalibration(base::FromUtcUs(1'700'000'000'000'000), -101.2);
    calibration.machine = MachineId("new");
    calibration.sessions = {session};
    if (database.SucceedJob(claim, {"result", calibration, {}}).ok()) tell("job done");
  }
  CalibrationFilter of_new;
  of_new.machine = MachineId("new");
  if (const auto all = database.ListCalibrations(of_new, {}); all.ok() && !all->rows.empty()) {
    const CalibrationId id = all->rows.back().id;
    if (database.ApproveCalibration(id, 0, kAnn).ok()) tell("approve");
    if (database.NoteHandedTable(id, "general", kAnn).ok()) tell("table");
  }
  if (database.ExpireSessions(std::chrono::hours(1000)).ok()) tell("expire");
  if (const auto made = database.Backup(path + ".copy", nullptr); made.ok()) tell("backup");
}

std::string OldDump() {
  std::ostringstream dump;
  dump << std::ifstream(base::SourcePath("/tests/migrations/v0001.sql")).rdbuf();
  DEMAND(!dump.str().empty());
  return dump.str();
}

void Clear(const std::string& path, const std::string& dump) {
  for (const char* const end : {"", "-wal", "-shm", "-journal", ".lock", ".copy", ".copy.lock", ".copy.part"})
    std::filesystem::remove(path + end);
  if (dump.empty()) return;
  const std::unique_ptr<SqliteConnection> connection = *SqliteConnection::Open(path, Access::kWrite);
  DEMAND(connection->Execute(dump).ok());
}

namespace {

// What was acknowledged is there, once. Empty: all is well.
std::string Lost(Database& database, const Told& told) {
  std::string lost;
  const auto expect = [&](const std::string& step, bool is_there) {
    if (told.contains(step) && !is_there) absl::StrAppend(&lost, step, " ");
  };
  expect("machine", database.GetMachine(MachineId("new")).ok());
  const auto bob = database.FindHolderOfName("bob");
  expect("principal", bob.ok() && bob->has_value());
  expect("role", bob.ok() && bob->has_value() && (*bob)->grants.size() == 1);
  const auto eve = database.FindHolderOfName("eve");
  expect("revoke", eve.ok() && eve->has_value() && (*eve)->is_revoked);
  const auto marks = database.ListMarks(MachineId("new"), {});
  expect("mark", marks.ok() && marks->rows.size() == 1);
  if (marks.ok() && marks->rows.size() > 1) absl::StrAppend(&lost, "mark twice ");
  if (told.contains("session")) {
    SessionFilter of_new;
    of_new.machine = MachineId("new");
    const auto sessions = database.ListSessions(of_new, {});
    int here = 0;
    SessionRecord session;
    for (const SessionRecord& record : sessions->rows) {
      if (record.state != SessionState::kOpen && record.state != SessionState::kComplete) continue;
      ++here;
      session = record;
    }
    const auto again = database.CreateSession(TheSession("session"));
    expect("session", here >= 1 && again.ok());
    if (again.ok()) {
      for (int seq = 0; seq < kChunks; ++seq) expect(absl::StrCat("chunk ", seq), again->next_seq > seq);
      if (again->reading_count != 10 * again->next_seq) absl::StrAppend(&lost, "readings ");
      if (told.contains("finish")) {
        const auto read = database.ReadSession(again->id);
        expect("finish", read.ok() && read->reading_count() == kChunks * 10);
      }
    }
  }
  const auto programs = database.ListPrograms({"nc"}, {});
  const auto program = database.BeginProgram({"nc", "O1", Cell("program")});
  expect("part", program.ok() && program->byte_count == sizeof(kProgram) - 1);
  expect("program", program.ok() && program->state == ProgramState::kComplete);
  if (told.contains("job")) {
    const auto job = database.CreateJob(TestJob(), 10);
    expect("job", job.ok());
    expect("job done", job.ok() && job->state == JobState::kSucceeded && job->result == "result");
  }
  CalibrationFilter of_new;
  of_new.machine = MachineId("new");
  const auto calibrations = database.ListCalibrations(of_new, {});
  if (calibrations.ok() && calibrations->rows.size() > 1) absl::StrAppend(&lost, "calibration twice ");
  const auto approved = database.GetApprovedCalibration(MachineId("new"));
  expect("approve", approved.ok());
  if (told.contains("table")) {
    const auto tables = database.ListHandedTables(MachineId("new"));
    expect("table", tables.ok() && tables->size() == 1);
  }
  return lost;
}

}  // namespace

void LookAfter(const std::string& path, const Told& told, const std::string& what, Sum& sum) {
  Told all;
  {
    const std::unique_ptr<Database> database = OpenAt(path);
    ASSERT_NE(database, nullptr) << what << ": does not open any more";
    const std::string lost = Lost(*database, told);
    if (!lost.empty()) ++sum.lost;
    EXPECT_EQ(lost, "") << what;
  }
  if (told.contains("backup")) {
    const auto copy = CheckStoreFile(path + ".copy");
    EXPECT_TRUE(copy.ok()) << what << ": " << copy.status();
    if (copy.ok()) {
      EXPECT_EQ(copy->damage_count, 0) << what << ": the backup: " << copy->damages[0].text;
    }
  }
  std::filesystem::remove(path + ".copy");
  Work(path, [&](const std::string& step) { all.insert(step); });
  for (const char* const step :
       {"open", "finish", "program", "approve", "table", "abort", "role", "revoke", "mark", "expire", "backup"})
    EXPECT_TRUE(all.contains(step)) << what << ": " << step << " fails afterwards";
  const auto report = CheckStoreFile(path);
  ASSERT_TRUE(report.ok()) << what << ": " << report.status();
  if (report->damage_count > 0) ++sum.damaged;
  EXPECT_EQ(report->damage_count, 0) << what << ": " << report->damages[0].resource << ": " << report->damages[0].text;
}

Told WorkApart(const std::string& path, const std::function<void()>& prepare, const std::function<void(pid_t)>& harm,
               bool* was_killed) {
  Told told;
  int channel[2];
  DEMAND(pipe(channel) == 0);
  const pid_t child = fork();
  DEMAND(child >= 0);
  if (child == 0) {
    close(channel[0]);
    prepare();
    Work(path, [&](const std::string& step) {
      const std::string line = step + "\n";
      DEMAND(write(channel[1], line.data(), line.size()) == static_cast<ssize_t>(line.size()));
    });
    _exit(0);
  }
  close(channel[1]);
  harm(child);
  std::string text;
  char piece[512];
  for (ssize_t count; (count = read(channel[0], piece, sizeof(piece))) > 0;)
    text.append(piece, static_cast<size_t>(count));
  close(channel[0]);
  int status = 0;
  DEMAND(waitpid(child, &status, 0) == child);
  *was_killed = WIFSIGNALED(status);
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) told.insert(line);
  return told;
}

void PrintRow(const std::string& fault, const std::string& name, const std::string& moments, const Sum& sum) {
  std::printf("FAULTS %-10s %-21s %s: %4lld faults, acknowledged and lost %lld, damaged %lld\n", fault.c_str(),
              name.c_str(), moments.c_str(), static_cast<long long>(sum.faults), static_cast<long long>(sum.lost),
              static_cast<long long>(sum.damaged));
}

}  // namespace axiscal::storage
