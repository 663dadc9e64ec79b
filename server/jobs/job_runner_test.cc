#include "server/jobs/job_runner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <future>
#include <thread>

#include "core/base/error_detail.h"
#include "server/storage/sqlite_connection.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::jobs {
namespace {

using records::JobRecord;
using records::JobState;
using storage::Cell;
using storage::JobProduct;
using storage::NewJob;

// Functions under test run on real threads; the tests wait for what they do, never for time.
class JobRunnerTest : public testing::Test {
 protected:
  JobRunnerTest() { options.clock = &database.clock; }

  void StartRunner() {
    runner = std::make_unique<JobRunner>(*database, options);
    for (auto& [kind, job_kind] : kinds) runner->Register(kind, job_kind);
    runner->Start();
  }
  static NewJob Job(const std::string& kind, const std::string& request_id) {
    NewJob job;
    job.kind = kind;
    job.params = "p";
    job.caller = Cell(request_id);
    return job;
  }
  JobRecord Create(const std::string& kind) {
    const absl::StatusOr<JobRecord> record = runner->Create(Job(kind, ""));
    DEMAND(record.ok());
    return *record;
  }
  // The first state that `stop` likes.
  template <typename Predicate>
  JobRecord WaitUntil(JobId id, const Predicate& stop) {
    const auto watch = runner->Watch(id);
    DEMAND(watch.ok());
    while (true) {
      const std::optional<JobRecord> record = (*watch)->Next(std::chrono::minutes(1));
      DEMAND(record.has_value());
      if (stop(*record)) return *record;
    }
  }
  JobRecord WaitForEnd(JobId id) {
    return WaitUntil(id, [](const JobRecord& record) { return IsTerminal(record.state); });
  }
  // Until the lease in the file reaches as far as a beat of this moment makes it.
  void WaitForBeat(JobId id) {
    const auto now = database.clock.SteadyNow().time_since_epoch();
    const auto expected = std::chrono::duration_cast<std::chrono::microseconds>(now + options.lease).count();
    const auto file = storage::SqliteConnection::Open(database.path(), storage::Access::kReadOnly);
    DEMAND(file.ok());
    for (int64_t lease_until = 0; lease_until < expected; std::this_thread::yield()) {
      auto row = (*file)->Ask("SELECT lease_until_steady_us FROM job WHERE id = ?1", id);
      DEMAND(row.ok() && row->Step().ok());
      lease_until = row->Int(0);
    }
  }
  // A kind that runs until it is told to stop, or `released`.
  JobFunction Patient() {
    return [this](const JobRecord& record, JobContext& context) -> absl::StatusOr<JobProduct> {
      context.ReportProgress("wait", 0.5, "running");
      while (!context.cancelled() && !released.load()) std::this_thread::yield();
      if (context.cancelled()) return absl::CancelledError("told to stop");
      return JobProduct{"patience", {}, {}};
    };
  }

  storage::TempDatabase database;
  JobRunnerOptions options;
  std::map<std::string, JobKind> kinds;
  std::atomic<bool> released = false;
  std::unique_ptr<JobRunner> runner;
};

TEST_F(JobRunnerTest, RunsAJobAndKeepsItsResult) {
  kinds["echo"].run = [](const JobRecord& record, JobContext& context) -> absl::StatusOr<JobProduct> {
    context.ReportProgress("echo", 0.3, "half way");
    return JobProduct{record.params + "!", {}, {}};
  };
  StartRunner();
  const JobRecord job = Create("echo");
  const JobRecord ended = WaitForEnd(job.id);
  EXPECT_EQ(ended.state, JobState::kSucceeded);
  EXPECT_EQ(ended.result, "p!");
  EXPECT_EQ(ended.attempt, 1);
  EXPECT_EQ(database->GetJob(job.id)->state, JobState::kSucceeded);
}

TEST_F(JobRunnerTest, EveryStartAndEndOfAnAttemptIsTold) {
  base::Mutex mutex;
  std::map<int64_t, std::vector<std::string>> told;
  options.first_backoff = std::chrono::milliseconds(0);
  options.tell = [&](const JobEvent& event) {
    const bool is_start = event.what == JobEvent::What::kStarted;
    EXPECT_EQ(event.took.has_value(), !is_start);
    const base::MutexLock lock(mutex);
    told[event.job.id.number()].push_back(
        absl::StrCat(is_start ? "start" : event.outcome, " ", event.job.kind, " ", event.job.attempt));
  };
  kinds["good"].run = [](const JobRecord&, JobContext&) { return JobProduct{}; };
  kinds["bad"].run = [](const JobRecord&, JobContext&) -> absl::StatusOr<JobProduct> {
    return base::Error(absl::StatusCode::kInvalidArgument, "no", {"FIELD_INVALID", {}});
  };
  kinds["poison"].run = [](const JobRecord&, JobContext&) -> absl::StatusOr<JobProduct> {
    return absl::UnavailableError("never there");
  };
  StartRunner();
  const JobId good = Create("good").id, bad = Create("bad").id;
  NewJob twice = Job("poison", "");
  twice.max_attempts = 2;
  const JobId poison = runner->Create(twice)->id;
  for (const JobId id : {good, bad, poison}) WaitForEnd(id);
  runner->Drain(std::chrono::hours(1));  // an end is told after it is stored, which is what WaitForEnd() sees
  const base::MutexLock lock(mutex);
  using Events = std::vector<std::string>;
  EXPECT_EQ(told[good.number()], (Events{"start good 1", "SUCCEEDED good 1"}));
  EXPECT_EQ(told[bad.number()], (Events{"start bad 1", "FAILED bad 1"}));
  EXPECT_EQ(told[poison.number()], (Events{"start poison 1", "RETRY poison 1", "start poison 2", "DEAD poison 2"}));
}

TEST_F(JobRunnerTest, AnAttemptBeginsAfterTheEndOfTheFormerIsToldAndIsKept) {
  base::Mutex mutex;
  std::vector<std::string> told;
  const auto has_begun_again = [&] {
    const base::MutexLock lock(mutex);
    return std::find(told.begin(), told.end(), "start 2") != told.end();
  };
  options.first_backoff = std::chrono::milliseconds(0);
  options.tell = [&](const JobEvent& event) {
    if (event.job.kind != "second") return;
    if (event.outcome == "RETRY") {
      // The job may be claimed as far as the store is concerned, and the runner has reason to look: time for what must
      // not happen.
      Create("other");
      constexpr int kLooks = 200;
      for (int i = 0; i < kLooks && !has_begun_again(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    const base::MutexLock lock(mutex);
    told.push_back(absl::StrCat(event.outcome.empty() ? "start" : event.outcome, " ", event.job.attempt));
  };
  kinds["other"].run = [](const JobRecord&, JobContext&) { return JobProduct{}; };
  kinds["second"].run = [patient = Patient()](const JobRecord& record,
                                              JobContext& context) -> absl::StatusOr<JobProduct> {
    if (record.attempt == 1) return absl::UnavailableError("not yet");
    return patient(record, context);
  };
  StartRunner();
  const JobId job = Create("second").id;
  WaitUntil(job, [](const JobRecord& record) { return record.progress.stage == "wait"; });
  while (!has_begun_again()) std::this_thread::yield();
  // The second attempt is not taken for the first one, which has ended: it can be cancelled.
  ASSERT_TRUE(runner->Cancel(job, Cell("")).ok());
  EXPECT_EQ(WaitForEnd(job).state, JobState::kCancelled);
  runner->Drain(std::chrono::hours(1));
  const base::MutexLock lock(mutex);
  EXPECT_EQ(told, (std::vector<std::string>{"start 1", "RETRY 1", "start 2", "CANCELLED 2"}));
}

TEST_F(JobRunnerTest, RunsManyJobsOnceEach) {
  std::atomic<int> runs = 0;
  kinds["count"].run = [&](const JobRecord&, JobContext&) -> absl::StatusOr<JobProduct> {
    ++runs;
    return JobProduct{};
  };
  StartRunner();
  std::vector<JobId> ids;
  for (int i = 0; i < 50; ++i) ids.push_back(Create("count").id);
  for (const JobId id : ids) EXPECT_EQ(WaitForEnd(id).state, JobState::kSucceeded);
  EXPECT_EQ(runs, 50);
}

TEST_F(JobRunnerTest, TheSameRequestIsTheSameJob) {
  kinds["count"].run = [&](const JobRecord&, JobContext&) -> absl::StatusOr<JobProduct> { return JobProduct{}; };
  StartRunner();
  const auto first = runner->Create(Job("count", "r1"));
  EXPECT_EQ(runner->Create(Job("count", "r1"))->id, first->id);
  EXPECT_EQ(base::ErrorReason(runner->Create(Job("none", "r2")).status()), "JOB_KIND_UNKNOWN");
}

TEST_F(JobRunnerTest, AFullQueueRefuses) {
  options.workers = 1;
  options.max_queued = 2;
  kinds["patient"].run = Patient();
  StartRunner();
  const JobRecord running = Create("patient");
  WaitUntil(running.id, [](const JobRecord& record) { return record.state == JobState::kRunning; });
  const JobRecord waiting = Create("patient");
  Create("patient");
  const absl::Status full = runner->Create(Job("patient", "")).status();
  EXPECT_TRUE(absl::IsResourceExhausted(full)) << full;
  EXPECT_EQ(base::ErrorReason(full), "QUEUE_FULL");
  EXPECT_EQ(runner->Cancel(waiting.id, Cell(""))->state, JobState::kCancelled);
  EXPECT_TRUE(runner->Create(Job("patient", "")).ok());
}

TEST_F(JobRunnerTest, CancelReachesTheRunningFunction) {
  kinds["patient"].run = Patient();
  StartRunner();
  const JobRecord job = Create("patient");
  const JobRecord seen = WaitUntil(job.id, [](const JobRecord& record) { return record.progress.stage == "wait"; });
  EXPECT_EQ(seen.progress.fraction, 0.5);
  EXPECT_EQ(runner->Get(job.id)->progress.detail, "running");
  ASSERT_TRUE(runner->Cancel(job.id, Cell("")).ok());
  const JobRecord ended = WaitForEnd(job.id);
  EXPECT_EQ(ended.state, JobState::kCancelled);
  EXPECT_EQ(ended.error->reason, "CANCELLED");
  const auto again = runner->Requeue(job.id, Cell(""));
  ASSERT_TRUE(again.ok()) << again.status();
  released = true;
  EXPECT_EQ(WaitForEnd(job.id).state, JobState::kSucceeded);
}

TEST_F(JobRunnerTest, TheTimeLimitReachesTheRunningFunction) {
  kinds["patient"] = {Patient(), std::chrono::seconds(20)};
  StartRunner();
  const JobRecord job = Create("patient");
  WaitUntil(job.id, [](const JobRecord& record) { return record.progress.stage == "wait"; });
  database.clock.Advance(std::chrono::seconds(21));
  const JobRecord ended = WaitForEnd(job.id);
  EXPECT_EQ(ended.state, JobState::kFailed);
  EXPECT_EQ(ended.error->reason, "DEADLINE");
}

TEST_F(JobRunnerTest, TheJobsOwnDeadlineReachesTheRunningFunction) {
  kinds["patient"] = {Patient(), std::chrono::hours(1)};
  StartRunner();
  NewJob asked = Job("patient", "");
  asked.deadline = database.clock.UtcNow() + std::chrono::seconds(20);
  const absl::StatusOr<JobRecord> job = runner->Create(asked);
  ASSERT_TRUE(job.ok()) << job.status();
  WaitUntil(job->id, [](const JobRecord& record) { return record.progress.stage == "wait"; });
  database.clock.Advance(std::chrono::seconds(21));
  const JobRecord ended = WaitForEnd(job->id);
  EXPECT_EQ(ended.state, JobState::kFailed);
  EXPECT_EQ(ended.error->reason, "JOB_TOO_LATE");
  EXPECT_EQ(ended.error->code, absl::StatusCode::kDeadlineExceeded);
}

TEST_F(JobRunnerTest, PassingTroubleIsTriedAgainAndAPoisonedJobDies) {
  std::atomic<int> runs = 0;
  kinds["poison"].run = [&](const JobRecord&, JobContext&) -> absl::StatusOr<JobProduct> {
    ++runs;
    return absl::UnavailableError("no answer");
  };
  StartRunner();
  const JobRecord job = Create("poison");
  for (const int attempt : {1, 2}) {
    WaitUntil(job.id,
              [&](const JobRecord& record) { return record.state == JobState::kQueued && record.attempt == attempt; });
    database.clock.Advance(attempt * std::chrono::seconds(21));
  }
  const JobRecord ended = WaitForEnd(job.id);
  EXPECT_EQ(ended.state, JobState::kDead);
  EXPECT_EQ(ended.error->message, "no answer");
  EXPECT_EQ(runs, 3);
}

// A job whose first outcome the store does not take. Tells all that is told of it.
class LostOutcome : public JobRunnerTest {
 protected:
  // `keep_out` is called by the first attempt, `let_in` when its outcome was lost, and then `later` is over.
  void Run(const std::string& keep_out, const std::string& let_in, std::chrono::milliseconds later) {
    const std::unique_ptr<storage::Connection> beside = database.Beside();
    std::atomic<int> runs = 0, ends = 0;
    kinds["echo"].run = [&](const JobRecord& record, JobContext&) -> absl::StatusOr<JobProduct> {
      if (++runs == 1) {
        EXPECT_TRUE(beside->Execute(keep_out).ok());
      }
      return JobProduct{record.params, {}, {}};
    };
    base::Mutex mutex;
    options.tell = [&](const JobEvent& event) {
      const base::MutexLock lock(mutex);
      told.push_back(event.what == JobEvent::What::kStarted ? "start" : event.outcome);
      ends += event.what == JobEvent::What::kEnded;
    };
    StartRunner();
    const JobId job = Create("echo").id;
    while (ends == 0) std::this_thread::yield();
    EXPECT_TRUE(beside->Execute(let_in).ok());
    database.clock.Advance(later);
    ended = WaitForEnd(job);
    runner->Drain(std::chrono::hours(1));
    EXPECT_EQ(runs, 2);
  }

  JobRecord ended;
  std::vector<std::string> told;
};

// It is found at the next beat, long before the lease is over, and the attempt is not counted.
TEST_F(LostOutcome, WhileTheStoreIsAwayDoesNotCount) {
  Run("BEGIN IMMEDIATE", "ROLLBACK", options.heartbeat);
  EXPECT_EQ(ended.state, JobState::kSucceeded);
  EXPECT_EQ(ended.attempt, 1);
  EXPECT_EQ(told, (std::vector<std::string>{"start", "STORE_BUSY", "PARKED", "start", "SUCCEEDED"}));
}

// What the store refuses for what it is would be refused again: such attempts are used up.
TEST_F(LostOutcome, ThatTheStoreRefusesCounts) {
  Run("CREATE TRIGGER takes_no_end BEFORE UPDATE OF state ON job WHEN NEW.state > 2 BEGIN SELECT RAISE(ABORT, 'no'); "
      "END",
      "DROP TRIGGER takes_no_end", options.lease + options.heartbeat);
  EXPECT_EQ(ended.state, JobState::kSucceeded);
  EXPECT_EQ(ended.attempt, 2);
  EXPECT_EQ(told, (std::vector<std::string>{"start", "STORE_BUG", "RETRY", "start", "SUCCEEDED"}));
}

TEST_F(JobRunnerTest, WhatWouldFailAgainIsNotTriedAgain) {
  kinds["bad"].run = [](const JobRecord&, JobContext&) -> absl::StatusOr<JobProduct> {
    return base::Error(absl::StatusCode::kFailedPrecondition, "EX0B - EX0C", {"RANK_DEFICIENT", {}});
  };
  kinds["throws"].run = [](const JobRecord&, JobContext&) -> absl::StatusOr<JobProduct> { throw std::bad_alloc(); };
  StartRunner();
  const JobRecord ended = WaitForEnd(Create("bad").id);
  EXPECT_EQ(ended.state, JobState::kFailed);
  EXPECT_EQ(ended.attempt, 1);
  EXPECT_EQ(ended.error->reason, "RANK_DEFICIENT");
  EXPECT_EQ(WaitForEnd(Create("throws").id).error->reason, "JOB_EXCEPTION");
}

TEST_F(JobRunnerTest, HeartbeatsKeepALongJob) {
  kinds["patient"] = {Patient(), std::chrono::hours(1)};
  StartRunner();
  const JobRecord job = Create("patient");
  WaitUntil(job.id, [](const JobRecord& record) { return record.progress.stage == "wait"; });
  for (int i = 0; i < 20; ++i) {
    database.clock.Advance(std::chrono::seconds(6));
    WaitForBeat(job.id);
  }
  released = true;
  const JobRecord ended = WaitForEnd(job.id);
  EXPECT_EQ(ended.state, JobState::kSucceeded);
  EXPECT_EQ(ended.attempt, 1);
}

TEST_F(JobRunnerTest, DrainParksWhatRunsAndTheNextRunnerFinishesIt) {
  kinds["patient"].run = Patient();
  StartRunner();
  const JobRecord job = Create("patient");
  const auto watch = runner->Watch(job.id);
  WaitUntil(job.id, [](const JobRecord& record) { return record.progress.stage == "wait"; });
  runner->Drain(std::chrono::milliseconds(0));
  const JobRecord parked = *database->GetJob(job.id);
  EXPECT_EQ(parked.state, JobState::kQueued);
  EXPECT_EQ(parked.attempt, 0);
  EXPECT_EQ(base::ErrorReason(runner->Create(Job("patient", "")).status()), "DRAINING");
  while ((*watch)->Next(std::chrono::minutes(1)).has_value()) continue;
  EXPECT_TRUE((*watch)->done());

  released = true;
  StartRunner();
  EXPECT_EQ(WaitForEnd(job.id).result, "patience");
}

TEST_F(JobRunnerTest, DrainLetsThingsFinishThatCan) {
  kinds["patient"].run = Patient();
  StartRunner();
  const JobRecord job = Create("patient");
  WaitUntil(job.id, [](const JobRecord& record) { return record.state == JobState::kRunning; });
  std::thread drain([&] { runner->Drain(std::chrono::hours(1)); });
  released = true;
  drain.join();
  EXPECT_EQ(database->GetJob(job.id)->state, JobState::kSucceeded);
}

}  // namespace
}  // namespace axiscal::jobs
