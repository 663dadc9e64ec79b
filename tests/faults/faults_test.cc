// A disk that fails at each of its operations in turn, until a run passes without a failure: sessions, jobs, an
// approval, programs, principals, marks, tables, removal by age, a backup, and the migration of an old file. After
// each: what was acknowledged is there once, what was not is gone or goes on where it was left, and the whole file is
// looked through.
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
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/base/clock.h"
#include "server/storage/backup.h"
#include "server/storage/check.h"
#include "server/storage/testing/temp_database.h"
#include "tests/faults/testing/fault_vfs.h"
#include "tests/faults/testing/work.h"

namespace axiscal::storage {
namespace {

using axiscal::testing::ArmFault;
using axiscal::testing::DisarmFault;
using axiscal::testing::Fault;

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
      return "full once";
    case Fault::kTornOnce:
      return "torn write";
    case Fault::kDead:
      return "dead disk";
    case Fault::kPowerLoss:
      return "power loss";
    case Fault::kStaysFull:
      return "full disk";
    case Fault::kQuota:
      return "quota";
    case Fault::kReadOnly:
      return "read-only";
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

  // What makes a file or puts one in the place of another: `path` as `prepare` has left it, then `replace` with a
  // fault. `look` says what may be there then; afterwards `replace` works.
  struct Replacement {
    std::string name;
    std::function<void(const std::string& path)> prepare;
    std::function<absl::Status(const std::string& path)> replace;
    std::function<void(const std::string& path, bool is_done, const std::string& what)> look;
    int64_t step = 17;  // of the bounded run, as kStep
  };
  void Exhaust(const Replacement& replacement) {
    const std::string path = folder_.File("axiscal.db");
    Sum sum;
    bool has_come = true;
    for (int64_t n = 1; has_come && !HasFatalFailure(); n += IsLong() ? 1 : replacement.step) {
      ClearAll(path);
      replacement.prepare(path);
      const std::string what = absl::StrCat(NameOf(GetParam()), " at operation ", n, " of ", replacement.name);
      bool is_done = false;
      if (GetParam() == Fault::kKill) {
        const pid_t child = fork();
        DEMAND(child >= 0);
        if (child == 0) {
          ArmFault(GetParam(), n, 0);
          _exit(replacement.replace(path).ok() ? 0 : 1);
        }
        int status = 0;
        DEMAND(waitpid(child, &status, 0) == child);
        has_come = WIFSIGNALED(status);
        is_done = !has_come && WEXITSTATUS(status) == 0;
      } else {
        ArmFault(GetParam(), n, static_cast<uint32_t>(n));
        is_done = replacement.replace(path).ok();
        has_come = DisarmFault();
      }
      ++sum.moments;
      sum.faults += has_come ? 1 : 0;
      sum.last = n;
      EXPECT_TRUE(has_come || is_done) << what;
      const bool failed_before = HasFailure();
      replacement.look(path, is_done, what);
      sum.lost += HasFailure() && !failed_before ? 1 : 0;
      std::filesystem::remove(path + ".replaced");
      std::filesystem::remove(path + ".copy");
      const absl::Status again = replacement.replace(path);
      EXPECT_TRUE(again.ok()) << what << ": it fails afterwards: " << again;
    }
    EXPECT_GT(sum.faults, 3);
    Print(replacement.name, sum, IsLong());
  }
  static void ClearAll(const std::string& path) {
    Clear(path, "");
    for (const char* const end : {".replaced", ".replaced-journal", ".replaced-wal", ".restoring", ".restoring.part",
                                  ".restoring-journal", ".compacting"})
      std::filesystem::remove(path + end);
  }
  static void ExpectWhole(const std::string& path, const std::string& what) {
    const auto report = CheckStoreFile(path);
    ASSERT_TRUE(report.ok()) << what << ": " << report.status();
    EXPECT_EQ(report->damage_count, 0) << what << ": " << report->damages[0].text;
  }
  static void Print(const std::string& name, const Sum& sum, bool is_each) {
    PrintRow(NameOf(GetParam()), name, absl::StrFormat("operations 1 to %4d%s", sum.last, is_each ? "" : ", some"),
             sum);
  }

  TempDirectory folder_;
};

TEST_P(Faults, OfANewFile) { Exhaust("new file", ""); }

// The migration may be cut in half.
TEST_P(Faults, OfAnOldFile) { Exhaust("old file", OldDump()); }

void MakeOld(const std::string& path) { DEMAND(OpenAt(path)->CreateMachine(MachineId("old"), "{}", kAnn).ok()); }

// As a crash leaves it: what was acknowledged last stands in the log beside it alone.
void MakeCrashed(const std::string& path) {
  const std::string made = path + ".made";
  Clear(made, "");
  const std::unique_ptr<Database> database = OpenAt(made);
  DEMAND(database->CreateMachine(MachineId("old"), "{}", kAnn).ok());
  for (const char* const end : {"", "-wal"}) std::filesystem::copy_file(made + end, path + end);
  DEMAND(std::filesystem::file_size(path + "-wal") > 0);
}

std::string MakeBackup(const std::string& path) {
  DEMAND(OpenAt(path)->CreateMachine(MachineId("of backup"), "{}", kAnn).ok());
  return path;
}

// What was there before, whole, or the backup.
void ExpectOldOrBackup(const std::string& path, bool is_done, const std::string& what) {
  const std::unique_ptr<Database> database = OpenAt(path);
  ASSERT_NE(database, nullptr) << what;
  const bool is_old = database->GetMachine(MachineId("old")).ok();
  EXPECT_NE(is_old, database->GetMachine(MachineId("of backup")).ok()) << what;
  EXPECT_FALSE(is_old && is_done) << what;
}

TEST_P(Faults, OfARestore) {
  const std::string backup = MakeBackup(folder_.File("backup.db"));
  Exhaust({"restore", MakeOld, [&](const std::string& path) { return RestoreStore(backup, path, false).status(); },
           [&](const std::string& path, bool is_done, const std::string& what) {
             ExpectOldOrBackup(path, is_done, what);
             ExpectWhole(path, what);
           }});
}

TEST_P(Faults, OfARestoreOverWhatACrashHasLeft) {
  const std::string backup = MakeBackup(folder_.File("backup.db"));
  Exhaust({"restore over a log", MakeCrashed,
           [&](const std::string& path) { return RestoreStore(backup, path, false).status(); },
           [&](const std::string& path, bool is_done, const std::string& what) {
             ExpectOldOrBackup(path, is_done, what);
             ExpectWhole(path, what);
           }});
}

// Nothing is there, or the backup: never part of it.
TEST_P(Faults, OfARestoreToWhereNothingIs) {
  const std::string backup = MakeBackup(folder_.File("backup.db"));
  Exhaust({"restore of a new file", [](const std::string&) {},
           [&](const std::string& path) { return RestoreStore(backup, path, false).status(); },
           [&](const std::string& path, bool is_done, const std::string& what) {
             const bool is_there = std::filesystem::exists(path) && std::filesystem::file_size(path) > 0;
             EXPECT_TRUE(is_there || !is_done) << what;
             if (!is_there) return;
             EXPECT_TRUE(OpenAt(path)->GetMachine(MachineId("of backup")).ok()) << what;
             ExpectWhole(path, what);
           }});
}

// The copy is whole where it has its name; the database is as it was.
TEST_P(Faults, OfABackup) {
  Exhaust({"backup", MakeOld,
           [](const std::string& path) {
             const std::unique_ptr<Database> database = OpenAt(path);
             if (database == nullptr) return absl::UnavailableError("does not open");
             return database->Backup(path + ".copy", nullptr).status();
           },
           [&](const std::string& path, bool is_done, const std::string& what) {
             EXPECT_TRUE(OpenAt(path)->GetMachine(MachineId("old")).ok()) << what;
             ExpectWhole(path, what);
             EXPECT_TRUE(std::filesystem::exists(path + ".copy") || !is_done) << what;
             if (!std::filesystem::exists(path + ".copy")) return;
             EXPECT_TRUE(OpenAt(path + ".copy")->GetMachine(MachineId("old")).ok()) << what;
             ExpectWhole(path + ".copy", what);
           }});
}

TEST_P(Faults, OfACompacting) {
  Exhaust({"compact", MakeOld, [](const std::string& path) { return CompactStore(path).status(); },
           [&](const std::string& path, bool, const std::string& what) {
             EXPECT_TRUE(OpenAt(path)->GetMachine(MachineId("old")).ok()) << what;
             ExpectWhole(path, what);
           }});
}

// A database that was hardly begun is replaced, with what stands beside it: nothing of that is taken for the backup's.
TEST_P(Faults, OfAFirstStartOverWhichABackupIsRestored) {
  const std::string backup = MakeBackup(folder_.File("backup.db"));
  Exhaust({"first start", [](const std::string&) {},
           [](const std::string& path) {
             return OpenAt(path) == nullptr ? absl::UnavailableError("does not open") : absl::OkStatus();
           },
           [&](const std::string& path, bool, const std::string& what) {
             const auto restored = RestoreStore(backup, path, false);
             ASSERT_TRUE(restored.ok()) << what << ": " << restored.status();
             EXPECT_TRUE(OpenAt(path)->GetMachine(MachineId("of backup")).ok()) << what;
             ExpectWhole(path, what);
           },
           97});
}

INSTANTIATE_TEST_SUITE_P(OfTheDisk, Faults,
                         ::testing::Values(Fault::kErrorOnce, Fault::kFullOnce, Fault::kTornOnce, Fault::kDead,
                                           Fault::kPowerLoss, Fault::kStaysFull, Fault::kQuota, Fault::kReadOnly,
                                           Fault::kKill));

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
    // How long it takes, so that the moments are spread over all of it; no check goes by it. Where the machine has
    // become so busy that nothing was acknowledged before any kill, they are spread over twice as much.
    Clear(path, dump);
    const base::SteadyTime start = base::SystemClock().SteadyNow();
    Work(path, [](const std::string&) {});
    auto whole_us =
        std::chrono::duration_cast<std::chrono::microseconds>(base::SystemClock().SteadyNow() - start).count();
    Sum sum;
    int64_t steps = 0;
    constexpr int kMostRounds = 6;
    for (int kill_number = 0; kill_number < kills || (steps == 0 && kill_number < kMostRounds * kills); ++kill_number) {
      if (::testing::Test::HasFatalFailure()) return;
      if (kill_number > 0 && kill_number % kills == 0) whole_us *= 2;
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
    EXPECT_GT(steps, 0);
    PrintRow("kill -9", is_old ? "old file" : "new file",
             absl::StrCat("at moments by chance, ", steps, " acknowledged steps"), sum);
  }
}

}  // namespace
}  // namespace axiscal::storage
