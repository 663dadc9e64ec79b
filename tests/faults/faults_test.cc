// A disk that fails at each of its operations in turn, until a run passes without a failure: sessions, jobs, an
// approval, programs, principals, removal by age, a backup, and the migration of an old file. After each: what was
// acknowledged is there once, what was not is gone or goes on where it was left, and the whole file is looked through.
//
// Then the same work killed at moments that chance chooses, and what puts a file in another's place: restore, compact.
//
// AXISCAL_FAULTS=long looks at every operation for every fault, and at a thousand kills of each work (tests/long); else
// at some of them, spread evenly.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <set>
#include <sstream>

#include "core/base/clock.h"
#include "core/base/sha256.h"
#include "core/base/testing/source_path.h"
#include "server/storage/backup.h"
#include "server/storage/check.h"
#include "server/storage/connection.h"
#include "server/storage/testing/temp_database.h"
#include "tests/faults/testing/fault_vfs.h"

namespace axiscal::storage {
namespace {

using axiscal::testing::ArmFault;
using axiscal::testing::DisarmFault;
using axiscal::testing::Fault;

constexpr int kChunks = 4;
const char kProgram[] = "G01 X1.0000\nG01 X2.0000\n";
const Caller kAnn = {"ann", ""};

bool IsLong() {
  const char* const wanted = std::getenv("AXISCAL_FAULTS");
  return wanted != nullptr && std::string(wanted) == "long";
}

// What was answered with OK, by name.
using Told = std::set<std::string>;
using Tell = std::function<void(const std::string&)>;

NewJob TestJob() {
  NewJob job;
  job.kind = "identify";
  job.machine = MachineId("new");
  job.params = "params";
  job.max_attempts = 1000;
  job.caller = Cell("job");
  return job;
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

std::unique_ptr<Database> OpenAt(const std::string& path) {
  SqliteOptions options;
  options.path = path;
  absl::StatusOr<std::unique_ptr<Database>> database = OpenSqlite(options);
  return database.ok() ? *std::move(database) : nullptr;
}

// Everything that a plant does, each step once however often it runs. Goes on after what fails, as callers do who do
// not know of each other.
void Work(const std::string& path, const Tell& tell) {
  const std::unique_ptr<Database> opened = OpenAt(path);
  if (opened == nullptr) return;
  tell("open");
  Database& database = *opened;
  if (database.CreateMachine(MachineId("new"), "{}", kAnn).ok()) tell("machine");
  if (database.CreatePrincipal("bob", "", kAnn).ok()) tell("principal");
  if (database.ChangeRole("bob", {records::Role::kViewer, {}}, true, kAnn).ok()) tell("role");
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
    if (database.ApproveCalibration(all->rows.back().id, 0, kAnn).ok()) tell("approve");
  }
  if (database.ExpireSessions(std::chrono::hours(1000)).ok()) tell("expire");
  if (const auto made = database.Backup(path + ".copy", nullptr); made.ok()) tell("backup");
}

// A file as it was before; `path` without its ends.
void Clear(const std::string& path, const std::string& dump) {
  for (const char* const end : {"", "-wal", "-shm", "-journal", ".lock", ".copy", ".copy.lock", ".copy.part"})
    std::filesystem::remove(path + end);
  if (dump.empty()) return;
  const std::unique_ptr<Connection> connection = *Connection::Open(path, Access::kWrite);
  DEMAND(connection->Execute(dump).ok());
}

// What was acknowledged is there, once. Empty: all is well.
std::string Lost(Database& database, const Told& told) {
  std::string lost;
  const auto expect = [&](const std::string& step, bool is_there) {
    if (told.contains(step) && !is_there) absl::StrAppend(&lost, step, " ");
  };
  expect("machine", database.GetMachine(MachineId("new")).ok());
  const auto principals = database.ListPrincipals({});
  const bool has_bob = principals.ok() && principals->rows.size() == 1;
  expect("principal", has_bob);
  expect("role", has_bob && principals->rows[0].grants.size() == 1);
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
  expect("approve", database.GetApprovedCalibration(MachineId("new")).ok());
  return lost;
}

struct Sum {
  int64_t moments = 0, faults = 0, lost = 0, damaged = 0;
  int64_t last = 0;  // the first moment that no operation reached
};

// Everything that happens after one fault: restart, look, finish the work, look again.
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
  for (const char* const step : {"open", "finish", "program", "approve", "abort", "role", "expire", "backup"})
    EXPECT_TRUE(all.contains(step)) << what << ": " << step << " fails afterwards";
  const auto report = CheckStoreFile(path);
  ASSERT_TRUE(report.ok()) << what << ": " << report.status();
  if (report->damage_count > 0) ++sum.damaged;
  EXPECT_EQ(report->damage_count, 0) << what << ": " << report->damages[0].resource << ": " << report->damages[0].text;
}

// The work in a process of its own, to which `harm` is done; `prepare` runs in it before. Whether it was killed.
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

// The work with a fault in this process, or, for kKill, in one of its own.
Told WorkWith(const std::string& path, Fault fault, int64_t n, bool* has_come) {
  if (fault == Fault::kKill) {
    return WorkApart(
        path, [&] { ArmFault(fault, n, 0); }, [](pid_t) {}, has_come);
  }
  Told told;
  ArmFault(fault, n, static_cast<uint32_t>(n));
  Work(path, [&](const std::string& step) { told.insert(step); });
  *has_come = DisarmFault();
  return told;
}

const char* NameOf(Fault fault) {
  switch (fault) {
    case Fault::kErrorOnce:
      return "error";
    case Fault::kFullOnce:
      return "disk full";
    case Fault::kTornOnce:
      return "torn write";
    case Fault::kDead:
      return "dead disk";
    case Fault::kPowerLoss:
      return "power loss";
    case Fault::kKill:
      return "kill -9";
    default:
      return "";
  }
}

// In the bounded run, how many moments lie between two that are looked at.
constexpr int64_t kStep = 23;

class Faults : public ::testing::TestWithParam<Fault> {
 protected:
  Faults() {
    axiscal::testing::InstallFaultVfs();
    setenv("TMPDIR", std::filesystem::temp_directory_path().c_str(), 0);
  }
  void Exhaust(const std::string& name, const std::string& dump) {
    const std::string path = folder_.File("axiscal.db");
    const int64_t step = IsLong() ? 1 : kStep;
    Sum sum;
    bool has_come = true;
    for (int64_t n = 1; has_come && !HasFatalFailure(); n += step) {
      Clear(path, dump);
      const Told told = WorkWith(path, GetParam(), n, &has_come);
      ++sum.moments;
      sum.faults += has_come ? 1 : 0;
      sum.last = n;
      LookAfter(path, told, absl::StrCat(NameOf(GetParam()), " at operation ", n, " of ", name), sum);
    }
    EXPECT_GT(sum.faults, 10);
    Print(name, sum, step == 1);
  }

  // What puts a file in the place of another: `path` opens afterwards and is whole, as it was or as it was to become.
  void ExhaustReplacement(const std::string& name, const std::function<absl::Status(const std::string& path)>& replace,
                          const std::function<void(const std::string& path, bool is_done)>& look) {
    const std::string path = folder_.File("axiscal.db");
    Sum sum;
    bool has_come = true;
    for (int64_t n = 1; has_come && !HasFatalFailure(); n += IsLong() ? 1 : 17) {
      for (const char* const end :
           {".replaced", ".replaced-wal", ".replaced-shm", ".restoring", ".restoring.part", ".compacting"})
        std::filesystem::remove(path + end);
      Clear(path, "");
      DEMAND(OpenAt(path)->CreateMachine(MachineId("old"), "{}", kAnn).ok());
      const std::string what = absl::StrCat(NameOf(GetParam()), " at operation ", n, " of ", name);
      bool is_done = false;
      if (GetParam() == Fault::kKill) {
        const pid_t child = fork();
        DEMAND(child >= 0);
        if (child == 0) {
          ArmFault(GetParam(), n, 0);
          _exit(replace(path).ok() ? 0 : 1);
        }
        int status = 0;
        DEMAND(waitpid(child, &status, 0) == child);
        has_come = WIFSIGNALED(status);
        is_done = !has_come && WEXITSTATUS(status) == 0;
      } else {
        ArmFault(GetParam(), n, static_cast<uint32_t>(n));
        is_done = replace(path).ok();
        has_come = DisarmFault();
      }
      ++sum.moments;
      sum.faults += has_come ? 1 : 0;
      sum.last = n;
      EXPECT_TRUE(has_come || is_done) << what;
      const auto report = CheckStoreFile(path);
      ASSERT_TRUE(report.ok()) << what << ": " << report.status();
      EXPECT_EQ(report->damage_count, 0) << what << ": " << report->damages[0].text;
      sum.damaged += report->damage_count > 0 ? 1 : 0;
      look(path, is_done);
      std::filesystem::remove(path + ".replaced");
      EXPECT_TRUE(replace(path).ok()) << what << ": it fails afterwards";
    }
    EXPECT_GT(sum.faults, 3);
    Print(name, sum, IsLong());
  }
  static void Print(const std::string& name, const Sum& sum, bool is_each) {
    std::printf("FAULTS %-10s %-9s operations 1 to %4lld%s: %4lld faults, acknowledged and lost %lld, damaged %lld\n",
                NameOf(GetParam()), name.c_str(), static_cast<long long>(sum.last), is_each ? "" : ", some",
                static_cast<long long>(sum.faults), static_cast<long long>(sum.lost),
                static_cast<long long>(sum.damaged));
  }

  TempDirectory folder_;
};

TEST_P(Faults, OfANewFile) { Exhaust("new file", ""); }

std::string OldDump() {
  std::ostringstream dump;
  dump << std::ifstream(base::SourcePath("/tests/migrations/v0001.sql")).rdbuf();
  DEMAND(!dump.str().empty());
  return dump.str();
}

// The migration may be cut in half.
TEST_P(Faults, OfAnOldFile) { Exhaust("old file", OldDump()); }

TEST_P(Faults, OfARestore) {
  const std::string backup = folder_.File("backup.db");
  DEMAND(OpenAt(backup)->CreateMachine(MachineId("of backup"), "{}", kAnn).ok());
  ExhaustReplacement(
      "restore", [&](const std::string& path) { return RestoreStore(backup, path, false).status(); },
      [](const std::string& path, bool is_done) {
        const std::unique_ptr<Database> database = OpenAt(path);
        ASSERT_NE(database, nullptr);
        const bool is_old = database->GetMachine(MachineId("old")).ok();
        EXPECT_NE(is_old, database->GetMachine(MachineId("of backup")).ok());
        EXPECT_FALSE(is_old && is_done);
      });
}

TEST_P(Faults, OfACompacting) {
  ExhaustReplacement(
      "compact", [](const std::string& path) { return CompactStore(path).status(); },
      [](const std::string& path, bool) { EXPECT_TRUE(OpenAt(path)->GetMachine(MachineId("old")).ok()); });
}

INSTANTIATE_TEST_SUITE_P(OfTheDisk, Faults,
                         ::testing::Values(Fault::kErrorOnce, Fault::kFullOnce, Fault::kTornOnce, Fault::kDead,
                                           Fault::kPowerLoss, Fault::kKill));

// What the store asks of the system itself goes wrong as SQLite's operations do.
TEST(SystemCalls, AreOperationsOfTheDisk) {
  TempDirectory folder;
  const std::string from = folder.File("from"), to = folder.File("to");
  std::ofstream(from) << "x";
  for (const Fault fault : {Fault::kErrorOnce, Fault::kFullOnce}) {
    ArmFault(fault, 1, 0);
    EXPECT_NE(std::rename(from.c_str(), to.c_str()), 0);
    EXPECT_EQ(errno, fault == Fault::kFullOnce ? ENOSPC : EIO);
    EXPECT_TRUE(DisarmFault());
  }
  EXPECT_EQ(std::rename(from.c_str(), to.c_str()), 0);
  EXPECT_TRUE(std::filesystem::exists(to));
}

// kill -9 at moments that chance chooses, of a file that is new and of one whose migration may be cut in half.
TEST(KilledAtAnyMoment, WhatWasAcknowledgedIsThereOnce) {
  axiscal::testing::InstallFaultVfs();
  TempDirectory folder;
  const std::string path = folder.File("axiscal.db");
  const int kills = IsLong() ? 1000 : 20;
  std::mt19937 random(11);
  for (const bool is_old : {false, true}) {
    const std::string dump = is_old ? OldDump() : "";
    // How long it takes, so that the moments are spread over all of it; no check goes by it.
    Clear(path, dump);
    const base::SteadyTime start = base::SystemClock().SteadyNow();
    Work(path, [](const std::string&) {});
    const auto whole_us =
        std::chrono::duration_cast<std::chrono::microseconds>(base::SystemClock().SteadyNow() - start).count();
    Sum sum;
    int64_t steps = 0;
    for (int kill_number = 0; kill_number < kills && !::testing::Test::HasFatalFailure(); ++kill_number) {
      Clear(path, dump);
      const auto after_us = static_cast<useconds_t>(random() % static_cast<uint64_t>(whole_us));
      bool was_killed = false;
      const Told told = WorkApart(
          path, [] {},
          [&](pid_t child) {
            usleep(after_us);
            kill(child, SIGKILL);
          },
          &was_killed);
      sum.faults += was_killed ? 1 : 0;
      steps += static_cast<int64_t>(told.size());
      LookAfter(path, told, absl::StrCat("killed after ", after_us, " us, ", told.size(), " steps"), sum);
    }
    std::printf(
        "FAULTS kill -9    %-9s at %d moments by chance: %4lld killed, %lld acknowledged steps, lost %lld, "
        "damaged %lld\n",
        is_old ? "old file" : "new file", kills, static_cast<long long>(sum.faults), static_cast<long long>(steps),
        static_cast<long long>(sum.lost), static_cast<long long>(sum.damaged));
  }
}

}  // namespace
}  // namespace axiscal::storage
