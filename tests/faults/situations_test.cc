// What befalls a file beside a disk that fails: a clock that jumps, two servers, a newer schema. A line of the table
// each, as of the faults.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "absl/strings/str_cat.h"
#include "core/base/clock.h"
#include "core/base/error_detail.h"
#include "core/base/mutex.h"
#include "server/storage/backup.h"
#include "server/storage/check.h"
#include "server/storage/sqlite_connection.h"
#include "server/storage/testing/temp_database.h"
#include "tests/faults/testing/work.h"

namespace axiscal::storage {
namespace {

// Each look at the wall clock is at another moment between 1970 and 2100; steady time goes on.
class JumpingClock final : public base::Clock {
 public:
  explicit JumpingClock(uint32_t seed) : random_(seed) {}
  base::UtcTime UtcNow() const override {
    const base::MutexLock lock(mutex_);
    return base::FromUtcUs(static_cast<int64_t>(random_() % 4'102'444'800'000'000u));
  }
  base::SteadyTime SteadyNow() const override { return base::SystemClock().SteadyNow(); }
  void WaitUntil(base::CondVar& changed, base::Mutex& mutex, base::SteadyTime deadline) override
      AXISCAL_REQUIRES(mutex) {
    base::SystemClock().WaitUntil(changed, mutex, deadline);
  }

 private:
  mutable base::Mutex mutex_;
  mutable std::mt19937_64 random_ AXISCAL_GUARDED_BY(mutex_);
};

std::string BytesOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class Situations : public ::testing::TestWithParam<bool> {
 protected:
  std::string dump() const { return GetParam() ? OldDump() : ""; }
  std::string name() const { return GetParam() ? "old file" : "new file"; }
  const std::string& path() const { return path_; }

 private:
  TempDirectory folder_;
  const std::string path_ = folder_.File("axiscal.db");
};

TEST_P(Situations, AClockThatJumps) {
  Sum sum;
  const int runs = IsLong() ? 200 : 10;
  for (int run = 0; run < runs && !HasFatalFailure(); ++run) {
    Clear(path(), dump());
    JumpingClock clock(static_cast<uint32_t>(run));
    Told told;
    Work(
        path(), [&](const std::string& step) { told.insert(step); }, clock);
    const std::string what = absl::StrCat("jump ", run, " of ", name());
    // A job may wait for a moment that the clock does not come to; what is uploaded does not.
    for (const char* const step : {"open", "machine", "role", "finish", "program", "job", "expire", "backup"})
      EXPECT_TRUE(told.contains(step)) << what << ": " << step;
    ++sum.faults;
    LookAfter(path(), told, what, sum);
  }
  PrintRow("clock", name(), absl::StrCat("jumps at each look, ", runs, " runs"), sum);
}

// What a second process gets that opens, restores, compacts or looks through the file: 0 where all are refused because
// a server has it.
int SecondServer(const std::string& path) {
  const pid_t child = fork();
  DEMAND(child >= 0);
  if (child == 0) {
    SqliteOptions options;
    options.path = path;
    const auto is_refused = [](const absl::Status& status) { return base::ErrorReason(status) == "STORE_LOCKED"; };
    if (!is_refused(OpenSqlite(options).status())) _exit(1);
    if (!is_refused(CheckStoreFile(path).status())) _exit(2);
    if (!is_refused(CompactStore(path).status())) _exit(3);
    if (!is_refused(RestoreStore(path + ".other", path, true).status())) _exit(4);
    _exit(0);
  }
  int status = 0;
  DEMAND(waitpid(child, &status, 0) == child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST_P(Situations, TwoServers) {
  Sum sum;
  DEMAND(OpenAt(path() + ".other") != nullptr);
  Clear(path(), dump());
  Told told;
  Work(path(), [&](const std::string& step) {
    told.insert(step);
    EXPECT_EQ(SecondServer(path()), 0) << "after " << step;
    ++sum.faults;
  });
  EXPECT_TRUE(told.contains("backup"));
  LookAfter(path(), told, "two servers on " + name(), sum);
  PrintRow("two servers", name(), "a second one after each step", sum);
}

TEST_P(Situations, ANewerSchema) {
  Sum sum;
  Clear(path(), dump());
  Told told;
  Work(path(), [&](const std::string& step) { told.insert(step); });
  const auto set_version = [&](int version) {
    const std::unique_ptr<SqliteConnection> connection = *SqliteConnection::Open(path(), Access::kWrite);
    DEMAND(connection->Execute(absl::StrCat("PRAGMA user_version = ", version)).ok());
  };
  const int present = OpenAt(path())->schema_version();
  set_version(present + 1);
  const std::string before = BytesOf(path());
  SqliteOptions options;
  options.path = path();
  EXPECT_EQ(base::ErrorReason(OpenSqlite(options).status()), "SCHEMA_NEWER");
  EXPECT_EQ(base::ErrorReason(CheckStoreFile(path()).status()), "SCHEMA_NEWER");
  EXPECT_EQ(base::ErrorReason(CompactStore(path()).status()), "SCHEMA_NEWER");
  EXPECT_TRUE(BytesOf(path()) == before) << "a newer file was written to";
  sum.faults = 3;
  set_version(present);
  LookAfter(path(), told, "newer schema of " + name(), sum);
  PrintRow("newer", name(), "a schema of a later version", sum);
}

INSTANTIATE_TEST_SUITE_P(OfTheFile, Situations, ::testing::Bool());

}  // namespace
}  // namespace axiscal::storage
