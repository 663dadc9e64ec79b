// Several processes on one database of PostgreSQL, each played by a store of its own. Of the run with
// --store=postgresql alone.
#include <gtest/gtest.h>

#include <future>
#include <set>
#include <thread>

#include "core/base/error_detail.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

using std::chrono::seconds;

constexpr seconds kLease(30);

class PostgresShared : public testing::Test {
 protected:
  void SetUp() override {
    if (TestServer::present == nullptr) GTEST_SKIP() << "needs storage_test --store=postgresql";
    a_ = std::make_unique<TempDatabase>();
    b_ = OpenAnother();
  }
  std::unique_ptr<Database> OpenAnother() {
    PostgresOptions options;
    options.url = a_->url();
    options.clock = &clock_;
    absl::StatusOr<std::unique_ptr<Database>> opened = OpenPostgres(options);
    EXPECT_TRUE(opened.ok()) << opened.status();
    return opened.ok() ? *std::move(opened) : nullptr;
  }
  Database& a() { return **a_; }
  Database& b() { return *b_; }
  static NewJob Job(const std::string& request_id) {
    NewJob job;
    job.kind = "identify";
    job.params = "p";
    job.caller = Cell(request_id);
    return job;
  }
  JobRecord ClaimAtA() {
    const auto claimed = a().ClaimJob(kLease);
    DEMAND(claimed.ok() && claimed->has_value());
    return **claimed;
  }

  base::FakeClock clock_;  // of b(), which runs by itself: another machine's
  std::unique_ptr<TempDatabase> a_;
  std::unique_ptr<Database> b_;
};

TEST_F(PostgresShared, WhoeverCopiesItWantsItAlone) {
  EXPECT_EQ(base::ErrorReason(PostgresConnection::Open(a_->url(), Access::kWrite).status()), "STORE_LOCKED");
  a_->Close();
  EXPECT_EQ(base::ErrorReason(PostgresConnection::Open(a_->url(), Access::kWrite).status()), "STORE_LOCKED");
  b_.reset();
  const auto alone = PostgresConnection::Open(a_->url(), Access::kWrite);
  ASSERT_TRUE(alone.ok()) << alone.status();
  PostgresOptions options;
  options.url = a_->url();
  EXPECT_EQ(base::ErrorReason(OpenPostgres(options).status()), "STORE_LOCKED");
}

// What one has acknowledged the other reads at once, and an upload goes on there.
TEST_F(PostgresShared, ASessionIsBegunAtOneAndGoesOnAtTheOther) {
  ASSERT_TRUE(a().CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
  const auto session = a().CreateSession(TestSession("r"));
  ASSERT_TRUE(session.ok()) << session.status();
  std::vector<uint32_t> crcs;
  for (int seq = 0; seq < 6; ++seq) {
    const std::vector<session::Column> columns = TestColumns(seq, 10);
    crcs.push_back(session::ChunkCrc32c(columns));
    Database& here = seq % 2 == 0 ? a() : b();
    const auto appended = Append(here, session->id, seq, columns);
    ASSERT_TRUE(appended.ok()) << appended.status();
    // The answer was lost: it is sent again, to the other one.
    const auto again = Append(seq % 2 == 0 ? b() : a(), session->id, seq, columns);
    ASSERT_TRUE(again.ok() && again->duplicate) << again.status();
  }
  EXPECT_EQ(b().CreateSession(TestSession("r"))->id, session->id);
  ASSERT_TRUE(b().FinishSession(session->id, {6, 60, session::SessionHash(crcs)}).ok());
  EXPECT_TRUE(a().ReadSession(session->id).ok());
}

// Numbers are seen in their order, and the chain of the audit holds, however many write at a time.
TEST_F(PostgresShared, WritersOfAllAreSerial) {
  constexpr int kEach = 60;
  std::vector<std::thread> writers;
  for (Database* const database : {&a(), &b(), &a(), &b()}) {
    writers.emplace_back([database] {
      AuditEntry entry;
      entry.principal = "ann";
      entry.action = "x";
      entry.outcome = "OK";
      for (int i = 0; i < kEach; ++i) EXPECT_TRUE(database->AppendAudit(entry).ok());
    });
  }
  // Whoever reads behind the last number that he has seen misses none.
  int64_t last = 0, seen = 0;
  while (seen < 4 * kEach) {
    const auto page = b().ListAudit({}, {1000, ""});
    ASSERT_TRUE(page.ok()) << page.status();
    for (const AuditEntry& entry : page->rows) seen += entry.id > last ? 1 : 0;
    if (!page->rows.empty()) last = page->rows[0].id;
    if (HasFailure()) break;
  }
  for (std::thread& writer : writers) writer.join();
  EXPECT_EQ(last, 4 * kEach);
  EXPECT_EQ(a().CheckAudit()->id, 4 * kEach);
}

TEST_F(PostgresShared, AJobIsClaimedOnce) {
  constexpr int kJobs = 40;
  for (int i = 0; i < kJobs; ++i) ASSERT_TRUE(a().CreateJob(Job(absl::StrCat(i)), 100).ok());
  const auto claim_all = [](Database& database) {
    std::set<int64_t> claimed;
    while (true) {
      const auto job = database.ClaimJob(kLease);
      EXPECT_TRUE(job.ok()) << job.status();
      if (!job.ok() || !job->has_value()) return claimed;
      claimed.insert((*job)->id.number());
    }
  };
  std::future<std::set<int64_t>> at_b = std::async(std::launch::async, [&] { return claim_all(b()); });
  std::set<int64_t> all = claim_all(a());
  const std::set<int64_t> others = at_b.get();
  EXPECT_EQ(all.size() + others.size(), static_cast<size_t>(kJobs));
  all.insert(others.begin(), others.end());
  EXPECT_EQ(all.size(), static_cast<size_t>(kJobs));
}

// Uploads and all else that is written wait for each other; a claim waits for none of them.
TEST_F(PostgresShared, AClaimWaitsForNoOtherWriter) {
  ASSERT_TRUE(b().CreateJob(Job("a"), 10).ok());
  const std::unique_ptr<Connection> outside = a_->Beside();
  // As one that writes has it until it commits.
  ASSERT_TRUE(outside->Execute("BEGIN; SELECT pg_advisory_xact_lock(x'41786977'::bigint)").ok());
  const JobRecord claimed = ClaimAtA();
  ASSERT_TRUE(outside->Execute("COMMIT").ok());
  EXPECT_TRUE(a().SucceedJob(ClaimOf(claimed), {"done", {}, {}}).ok());
}

TEST_F(PostgresShared, WhatAnotherOneIsClaimingIsPassedOver) {
  const JobId first = b().CreateJob(Job("a"), 10)->id, second = b().CreateJob(Job("b"), 10)->id;
  const std::unique_ptr<Connection> outside = a_->Beside();
  ASSERT_TRUE(
      outside->Execute(absl::StrCat("BEGIN; SELECT 1 FROM job WHERE id = ", first.number(), " FOR UPDATE")).ok());
  EXPECT_EQ(ClaimAtA().id, second);
  const auto none = a().ClaimJob(kLease);
  EXPECT_TRUE(none.ok() && !none->has_value()) << none.status();
  ASSERT_TRUE(outside->Execute("ROLLBACK").ok());
  EXPECT_EQ(ClaimAtA().id, first);
}

// A claim does not wait for those who end what waits: they wait for it, and find a job that runs.
TEST_F(PostgresShared, WhoeverEndsAJobThatIsBeingClaimedFindsItRunning) {
  NewJob late = Job("a");
  late.deadline = clock_.UtcNow() + seconds(1);
  const JobId id = b().CreateJob(late, 10)->id;
  clock_.Advance(seconds(2));
  const std::unique_ptr<Connection> outside = a_->Beside(), looks = a_->Beside();
  const auto count_waiting = [&] {
    auto row = looks->Ask("SELECT count(*) FROM pg_locks WHERE NOT granted");
    DEMAND(row.ok() && row->Step().ok());
    return row->Int(0);
  };
  const auto claim_meanwhile = [&](const auto& ends) {
    ASSERT_TRUE(outside
                    ->Execute(absl::StrCat("BEGIN; UPDATE job SET state = 2, owner = 'another', lease_token = 1, "
                                           "lease_until_steady_us = ",
                                           int64_t{1} << 60, " WHERE id = ", id.number()))
                    .ok());
    auto ended = std::async(std::launch::async, ends);
    while (count_waiting() == 0) std::this_thread::yield();
    ASSERT_TRUE(outside->Execute("COMMIT").ok());
    ended.get();
    EXPECT_EQ(a().GetJob(id)->state, JobState::kRunning);
    ASSERT_TRUE(outside->Execute("UPDATE job SET state = 1, owner = NULL, lease_until_steady_us = NULL").ok());
  };
  claim_meanwhile([&] { EXPECT_TRUE(b().RescueJobs()->empty()); });
  claim_meanwhile([&] {
    const auto cancelled = b().CancelJob(id, Cell(""));
    EXPECT_TRUE(cancelled.ok() && cancelled->cancel_requested) << cancelled.status();
  });
  EXPECT_TRUE(a().GetJob(id)->cancel_requested);
}

// One that has begun and says nothing more is taken over when its lease is over and not before, by the time that both
// count together; what it says then is refused.
TEST_F(PostgresShared, AJobIsTakenOverWhenItsLeaseIsOver) {
  ASSERT_TRUE(b().CreateJob(Job("a"), 10).ok());
  const JobRecord late = ClaimAtA();
  EXPECT_TRUE(b().RescueJobs()->empty());  // another process is no dead one
  clock_.Advance(seconds(20));
  a_->clock.Advance(seconds(20));
  ASSERT_TRUE(a().HeartbeatJob(ClaimOf(late), kLease, {"fit", 0.5, ""}).ok());
  EXPECT_EQ(b().GetJob(late.id)->progress.stage, "fit");
  clock_.Advance(seconds(29));
  EXPECT_TRUE(b().RescueJobs()->empty());
  clock_.Advance(seconds(2));
  ASSERT_EQ(b().RescueJobs()->size(), 1u);
  const auto second = b().ClaimJob(kLease);
  ASSERT_TRUE(second.ok() && second->has_value());
  EXPECT_EQ((*second)->attempt, 2);
  // The first one's clock stood still for 31 s. It is told so, and takes nothing away.
  EXPECT_EQ(base::ErrorReason(a().SucceedJob(ClaimOf(late), {"late", {}, {}}).status()), "LEASE_LOST");
  EXPECT_TRUE(a().RescueJobs()->empty());
  EXPECT_TRUE(b().SucceedJob(ClaimOf(**second), {"in time", {}, {}}).ok());
  EXPECT_EQ(a().GetJob(late.id)->result, "in time");
}

// A commit that waits for a standby which is not there waits without an end; a claim does not wait.
TEST_F(PostgresShared, AClaimWaitsForNoDiskAndNoStandby) {
  ASSERT_TRUE(b().CreateJob(Job("a"), 10).ok());
  const std::unique_ptr<Connection> server = a_->Beside();
  const auto set = [&](const std::string& names) {
    EXPECT_TRUE(server->Execute("ALTER SYSTEM SET synchronous_standby_names = '" + names + "'").ok());
    EXPECT_TRUE(server->Execute("SELECT pg_reload_conf()").ok());
    // Known once it is, to connections that are made then.
    for (std::string known = "?"; known != names; std::this_thread::yield()) {
      const auto fresh = a_->Beside();
      Statement row = *fresh->Ask("SELECT CAST(current_setting('synchronous_standby_names') AS TEXT)");
      ASSERT_TRUE(*row.Step());
      known = row.Text(0);
    }
  };
  set("nobody");
  const JobRecord claimed = ClaimAtA();
  set("");
  EXPECT_EQ(b().GetJob(claimed.id)->state, JobState::kRunning);
  EXPECT_TRUE(a().SucceedJob(ClaimOf(claimed), {"done", {}, {}}).ok());
}

TEST_F(PostgresShared, CancelAndVersionsAreSeenAtTheOther) {
  ASSERT_TRUE(b().CreateJob(Job("a"), 10).ok());
  const JobRecord running = ClaimAtA();
  const auto before = a().JobVersions({running.id, JobId(99)});
  ASSERT_TRUE(before.ok()) << before.status();
  ASSERT_EQ(before->size(), 1u);
  ASSERT_TRUE(b().CancelJob(running.id, Cell("")).ok());
  EXPECT_GT((*a().JobVersions({running.id}))[0].second, (*before)[0].second);
  EXPECT_TRUE(a().GetJob(running.id)->cancel_requested);
}

TEST_F(PostgresShared, WordsOfOneAreHeardByTheOther) {
  base::Mutex mutex;
  base::CondVar changed;
  std::vector<News> heard;
  b().Follow([&](const News& news) {
    const base::MutexLock lock(mutex);
    heard.push_back(news);
    changed.NotifyAll();
  });
  const auto wait_for = [&](const auto& is_it) {
    const base::MutexLock lock(mutex);
    while (std::none_of(heard.begin(), heard.end(), is_it)) changed.Wait(mutex);
  };
  // After it listens; what came before may have been missed.
  wait_for([](const News& news) { return news.jobs && news.events; });
  a().TellOthers(MachineId("mt"));
  wait_for([](const News& news) { return news.machine == MachineId("mt"); });
  a().TellOthers(std::nullopt);
  wait_for([](const News& news) { return news.routines; });
  ASSERT_TRUE(a().CreateJob(Job("a"), 10).ok());
  wait_for([](const News& news) { return news.jobs && !news.events; });
  // And after the server was away.
  ASSERT_TRUE(a_->Beside()
                  ->Execute("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE pid <> pg_backend_pid() AND "
                            "datname = current_database()")
                  .ok());
  {
    const base::MutexLock lock(mutex);
    heard.clear();
  }
  wait_for([](const News& news) { return news.jobs && news.events; });
  b().StopFollowing();
}

TEST_F(PostgresShared, OneIsTheCaretakerAtATime) {
  const auto hears_nothing = [](const News&) {};
  EXPECT_FALSE(a().IsCaretaker());
  a().Follow(hears_nothing);
  b().Follow(hears_nothing);
  EXPECT_TRUE(a().IsCaretaker());
  EXPECT_FALSE(b().IsCaretaker());
  // Whoever leaves lets another one in at once.
  a().StopFollowing();
  EXPECT_FALSE(a().IsCaretaker());
  b().StopFollowing();
  b().Follow(hears_nothing);
  EXPECT_TRUE(b().IsCaretaker());
  // One that stands still believes it no longer than it is true.
  clock_.Advance(seconds(11));
  EXPECT_FALSE(b().IsCaretaker());
  a().Follow(hears_nothing);
  a().StopFollowing();
  b().StopFollowing();
}

// A deadlock with somebody outside undoes a group of writes; they are run again, and stand once.
TEST_F(PostgresShared, WhatADeadlockUndidIsDoneAgain) {
  ASSERT_TRUE(a().CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
  const std::unique_ptr<Connection> outside = a_->Beside(), looks = a_->Beside();
  ASSERT_TRUE(outside->Execute("SET deadlock_timeout = '60s'").ok());
  ASSERT_TRUE(outside->Execute("BEGIN; UPDATE given_number SET seq = seq WHERE name = 'audit'").ok());
  auto created = std::async(std::launch::async, [&] { return b().CreatePrincipal("ann", "", Cell("")); });
  const auto count = [&](const std::string& sql) {
    auto row = looks->Ask(sql);
    DEMAND(row.ok() && row->Step().ok());
    return row->Int(0);
  };
  // It waits for the number of its entry in the audit; from here on each waits for the other.
  while (count("SELECT count(*) FROM pg_locks WHERE NOT granted") == 0) std::this_thread::yield();
  ASSERT_TRUE(outside->Execute("LOCK TABLE principal IN ACCESS EXCLUSIVE MODE").ok());
  ASSERT_TRUE(outside->Execute("COMMIT").ok());
  const auto made = created.get();
  EXPECT_TRUE(made.ok()) << made.status();
  EXPECT_EQ(b().ListPrincipals({})->rows.size(), 1u);
  EXPECT_TRUE(a().CheckAudit().ok());
}

}  // namespace
}  // namespace axiscal::storage
