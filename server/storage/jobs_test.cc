#include "server/storage/jobs.h"

#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "server/storage/job_owner.h"
#include "server/storage/page_token.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

using std::chrono::seconds;

constexpr seconds kLease(30);

class Jobs : public testing::Test {
 protected:
  static NewJob Job(const std::string& request_id, int priority = 0) {
    NewJob job;
    job.kind = "identify";
    job.params = std::string("\0\x01", 2);
    job.priority = priority;
    job.caller = Cell(request_id);
    return job;
  }
  JobRecord Claim() {
    const auto claimed = database->ClaimJob(kLease);
    DEMAND(claimed.ok() && claimed->has_value());
    return **claimed;
  }
  static JobError Error() { return {absl::StatusCode::kUnavailable, "WHY", "because"}; }

  TempDatabase database;
};

TEST_F(Jobs, CreateIsIdempotentByRequestId) {
  const auto job = database->CreateJob(Job("r1"), 10);
  ASSERT_TRUE(job.ok()) << job.status();
  EXPECT_EQ(job->state, JobState::kQueued);
  EXPECT_EQ(job->params, Job("").params);
  EXPECT_EQ(database->CreateJob(Job("r1"), 10)->id, job->id);
  EXPECT_EQ(base::ErrorReason(database->CreateJob(Job("r1", 5), 10).status()), "REQUEST_ID_REUSED");
}

TEST_F(Jobs, TheQueueIsBoundedButKnownRequestsAreAnswered) {
  ASSERT_TRUE(database->CreateJob(Job("r1"), 1).ok());
  EXPECT_EQ(base::ErrorReason(database->CreateJob(Job("r2"), 1).status()), "QUEUE_FULL");
  EXPECT_TRUE(database->CreateJob(Job("r1"), 1).ok());
}

TEST_F(Jobs, AreClaimedByPriorityThenAge) {
  const JobId old = database->CreateJob(Job("a"), 10)->id;
  const JobId young = database->CreateJob(Job("b"), 10)->id;
  const JobId urgent = database->CreateJob(Job("c", 1), 10)->id;
  EXPECT_EQ(Claim().id, urgent);
  EXPECT_EQ(Claim().id, old);
  EXPECT_EQ(Claim().id, young);
  EXPECT_FALSE(database->ClaimJob(kLease)->has_value());
  EXPECT_FALSE(database->NextJobWait()->has_value());
}

// Whom nobody waits for any more: a waiting job fails at its deadline, and one that is claimed late is not run.
TEST_F(Jobs, FailBehindTheirDeadline) {
  const auto due_in = [&](const std::string& id, std::chrono::minutes minutes) {
    NewJob job = Job(id);
    job.deadline = database.clock.UtcNow() + minutes;
    return database->CreateJob(job, 10);
  };
  EXPECT_EQ(base::ErrorReason(due_in("late", std::chrono::minutes(0)).status()), "JOB_INVALID");
  const JobId soon = due_in("a", std::chrono::minutes(1))->id, later = due_in("b", std::chrono::minutes(10))->id;
  EXPECT_EQ(database->GetJob(later)->deadline, database.clock.UtcNow() + std::chrono::minutes(10));
  database.clock.Advance(std::chrono::minutes(2));
  const auto rescued = database->RescueJobs();
  ASSERT_TRUE(rescued.ok()) << rescued.status();
  ASSERT_EQ(rescued->size(), 1u);
  const JobRecord late = *database->GetJob(soon);
  EXPECT_EQ((*rescued)[0].id, soon);
  EXPECT_EQ(late.state, JobState::kFailed);
  EXPECT_EQ(late.error->reason, "JOB_TOO_LATE");
  EXPECT_EQ(late.error->code, absl::StatusCode::kDeadlineExceeded);
  EXPECT_EQ(base::ErrorReason(database->RequeueJob(soon, 10, Cell("")).status()), "JOB_TOO_LATE");
  database.clock.Advance(std::chrono::minutes(20));
  EXPECT_FALSE(database->ClaimJob(kLease)->has_value());
  EXPECT_EQ(database->GetJob(later)->error->reason, "JOB_TOO_LATE");
  // The deadline is part of what is asked.
  NewJob other = Job("a");
  EXPECT_EQ(base::ErrorReason(database->CreateJob(other, 10).status()), "REQUEST_ID_REUSED");
}

TEST_F(Jobs, AreCountedWithTheOldestThatWaits) {
  EXPECT_EQ(database->CountJobs()->queued, 0);
  EXPECT_FALSE(database->CountJobs()->oldest_queued.has_value());
  const auto first = database->CreateJob(Job("a"), 10), second = database->CreateJob(Job("b"), 10);
  ASSERT_TRUE(first.ok() && second.ok());
  ASSERT_TRUE(database->ClaimJob(seconds(30))->has_value());  // the older one
  const auto queue = database->CountJobs();
  ASSERT_TRUE(queue.ok());
  EXPECT_EQ(queue->queued, 1);
  EXPECT_EQ(queue->running, 1);
  EXPECT_EQ(queue->oldest_queued, second->created_at);
}

TEST_F(Jobs, SuccessStoresTheCalibrationWithIt) {
  const SessionId session = StoreSession(*database, 1);
  ASSERT_TRUE(database->CreateJob(Job("a"), 10).ok());
  const JobRecord running = Claim();
  EXPECT_EQ(running.attempt, 1);
  JobProduct product = {"result", TestCalibration(database.clock.UtcNow(), -101.2), {}};
  product.calibration->sessions = {session};
  const auto done = database->SucceedJob(ClaimOf(running), product);
  ASSERT_TRUE(done.ok()) << done.status();
  EXPECT_EQ(done->state, JobState::kSucceeded);
  EXPECT_EQ(done->result, "result");
  ASSERT_TRUE(done->calibration.has_value());
  EXPECT_EQ(database->GetCalibration(*done->calibration)->job, running.id);
  EXPECT_EQ(base::ErrorReason(database->SucceedJob(ClaimOf(running), product).status()), "LEASE_LOST");
  EXPECT_EQ(database->ListCalibrations({}, {})->rows.size(), 1u);
}

TEST_F(Jobs, ARefusedProductStoresNothingOfIt) {
  const SessionId session = StoreSession(*database, 1);
  ASSERT_TRUE(database->CreateJob(Job("a"), 10).ok());
  const JobRecord running = Claim();
  JobProduct product = {"result", TestCalibration(database.clock.UtcNow(), 1.0), {ProgramId(77)}};
  product.calibration->sessions = {session};
  EXPECT_EQ(base::ErrorReason(database->SucceedJob(ClaimOf(running), product).status()), "PROGRAM_NOT_COMPLETE");
  EXPECT_TRUE(database->ListCalibrations({}, {})->rows.empty());
  EXPECT_EQ(database->GetJob(running.id)->state, JobState::kRunning);
}

TEST_F(Jobs, OfOnePrincipalAndOfOneMachineAreBounded) {
  StoreSession(*database, 1);
  const auto create = [&](const std::string& who, const std::string& id, const std::optional<MachineId>& machine) {
    NewJob job = Job(id);
    job.caller = {who, id};
    job.machine = machine;
    return database->CreateJob(job, {100, 2, 3}).status();
  };
  const MachineId mt("mt");
  ASSERT_TRUE(create("eve", "a", mt).ok());
  ASSERT_TRUE(create("eve", "b", std::nullopt).ok());
  Claim();  // what runs counts as well
  const absl::Status of_eve = create("eve", "c", std::nullopt);
  EXPECT_EQ(base::ErrorReason(of_eve), "QUEUE_FULL");
  EXPECT_EQ(of_eve.message(), "2 jobs of eve wait or run, at most 2 may");
  EXPECT_TRUE(create("eve", "a", mt).ok()) << "a repeat makes none";
  ASSERT_TRUE(create("bob", "a", mt).ok());
  ASSERT_TRUE(create("local:ann", "a", mt).ok());
  EXPECT_EQ(create("joe", "a", mt).message(), "3 jobs of machine mt wait or run, at most 3 may");
  EXPECT_TRUE(create("local:ann", "b", std::nullopt).ok());
  EXPECT_TRUE(create("local:ann", "c", std::nullopt).ok());
  EXPECT_TRUE(create("local:ann", "d", std::nullopt).ok());
}

// A queue that one has filled lets others through.
TEST_F(Jobs, WhoeverWaitsHasHisTurn) {
  const auto create = [&](const std::string& who, const std::string& id, int priority) {
    NewJob job = Job(id);
    job.caller = {who, id};
    job.priority = priority;
    DEMAND(database->CreateJob(job, 100).ok());
  };
  for (const char* const id : {"a", "b", "c", "d"}) create("eve", id, 0);
  create("bob", "a", 0);
  create("bob", "b", 0);
  create("joe", "a", 0);
  std::string turns;
  for (int i = 0; i < 7; ++i) {
    const JobRecord job = Claim();
    absl::StrAppend(&turns, job.created_by, " ");
    ASSERT_TRUE(database->SucceedJob(ClaimOf(job), {"done", {}, {}}).ok());
  }
  EXPECT_EQ(turns, "eve bob joe eve bob eve eve ");
  // While one of hers runs, others come first; what is urgent comes before all.
  create("eve", "e", 0);
  create("eve", "f", 0);
  create("eve", "g", 1);
  create("joe", "b", 0);
  EXPECT_EQ(Claim().priority, 1);
  EXPECT_EQ(Claim().created_by, "joe");
  EXPECT_EQ(Claim().created_by, "eve");
}

// Revoked while the job runs, or while it waits.
TEST_F(Jobs, OfAPrincipalThatWasRevokedLeaveNothing) {
  const SessionId session = StoreSession(*database, 1);
  ASSERT_TRUE(database->CreatePrincipal("cell", "", Cell("")).ok());
  ASSERT_TRUE(database->CreateJob(Job("a"), 10).ok());
  const JobId waiting = database->CreateJob(Job("b"), 10)->id;
  const JobRecord running = Claim();
  ASSERT_TRUE(database->RevokePrincipal("cell", {"ann", ""}).ok());
  JobProduct product = {"result", TestCalibration(database.clock.UtcNow(), 1.0), {}};
  product.calibration->sessions = {session};
  const absl::Status refused = database->SucceedJob(ClaimOf(running), product).status();
  EXPECT_EQ(base::ErrorReason(refused), "PRINCIPAL_REVOKED");
  EXPECT_TRUE(absl::IsPermissionDenied(refused)) << refused;
  EXPECT_TRUE(database->ListCalibrations({}, {})->rows.empty());
  EXPECT_FALSE(database->ClaimJob(kLease)->has_value());
  EXPECT_EQ(database->GetJob(waiting)->state, JobState::kFailed);
  EXPECT_EQ(database->GetJob(waiting)->error->reason, "PRINCIPAL_REVOKED");
}

TEST_F(Jobs, ALateWorkerIsRefused) {
  ASSERT_TRUE(database->CreateJob(Job("a"), 10).ok());
  const JobRecord late = Claim();
  database.clock.Advance(seconds(31));
  ASSERT_EQ(database->RescueJobs()->size(), 1u);
  const JobRecord second = Claim();
  EXPECT_EQ(second.attempt, 2);
  EXPECT_EQ(base::ErrorReason(database->HeartbeatJob(ClaimOf(late), kLease, {}).status()), "LEASE_LOST");
  EXPECT_EQ(base::ErrorReason(database->EndJob(ClaimOf(late), JobEnd::kFailed, Error(), seconds(0)).status()),
            "LEASE_LOST");
  EXPECT_EQ(base::ErrorReason(database->SucceedJob(ClaimOf(late), {"late", {}, {}}).status()), "LEASE_LOST");
  EXPECT_TRUE(database->SucceedJob(ClaimOf(second), {"in time", {}, {}}).ok());
  EXPECT_EQ(database->GetJob(late.id)->result, "in time");
}

TEST_F(Jobs, AWallClockThatJumpsTakesNoJobAway) {
  ASSERT_TRUE(database->CreateJob(Job("a"), 10).ok());
  const JobRecord running = Claim();
  database.clock.SetUtc(database.clock.UtcNow() + std::chrono::hours(10));
  EXPECT_TRUE(database->RescueJobs()->empty());
  EXPECT_TRUE(database->HeartbeatJob(ClaimOf(running), kLease, {"fit", 0.5, "x"}).ok());
  EXPECT_EQ(database->GetJob(running.id)->progress.stage, "fit");
}

TEST_F(Jobs, AHeartbeatProlongsTheLease) {
  ASSERT_TRUE(database->CreateJob(Job("a"), 10).ok());
  const JobRecord running = Claim();
  database.clock.Advance(seconds(20));
  ASSERT_TRUE(database->HeartbeatJob(ClaimOf(running), kLease, {}).ok());
  database.clock.Advance(seconds(20));
  EXPECT_TRUE(database->RescueJobs()->empty());
  database.clock.Advance(seconds(11));
  EXPECT_EQ(database->RescueJobs()->size(), 1u);
}

// Whoever kills servers does not mean the job; one that ends its process each time is DEAD in the end, and others get
// on meanwhile.
TEST_F(Jobs, OfADeadProcessGoBackToTheQueueAndDieAfterTen) {
  const JobId id = database->CreateJob(Job("a"), 10)->id;
  for (int attempt = 1; attempt <= kMostLostAttempts; ++attempt) {
    EXPECT_EQ(Claim().attempt, attempt);
    database.Close();
    database.Open();
    EXPECT_EQ(database->GetJob(id)->state, attempt < kMostLostAttempts ? JobState::kQueued : JobState::kDead);
    if (attempt == kMostLostAttempts) break;
    const std::chrono::microseconds wait = **database->NextJobWait();
    if (attempt < 3) {
      EXPECT_EQ(wait, seconds(0));
      continue;
    }
    EXPECT_GE(wait, seconds(10) * (1 << std::min(attempt - 3, 6)));
    EXPECT_LE(wait, 2 * seconds(10) * (1 << std::min(attempt - 3, 6)));
    EXPECT_FALSE(database->ClaimJob(kLease)->has_value());
    database.clock.Advance(wait);
  }
  EXPECT_EQ(database->GetJob(id)->error->reason, "OWNER_LOST");
  EXPECT_NE(database->GetJob(id)->error->message.find("axiscal jobs requeue"), std::string::npos);
  ASSERT_TRUE(database->RequeueJob(id, 10, Cell("")).ok());
  EXPECT_EQ(Claim().attempt, 1);
}

// What it has failed in is counted by itself.
TEST_F(Jobs, AttemptsThatFailedCountBesideThoseThatWereLost) {
  const JobId id = database->CreateJob(Job("a"), 10)->id;
  for (const bool is_lost : {true, false, true, false, false}) {
    const JobRecord running = Claim();
    if (is_lost) {
      database.Close();
      database.Open();
    } else {
      ASSERT_TRUE(database->EndJob(ClaimOf(running), JobEnd::kRetry, Error(), seconds(0)).ok());
    }
  }
  EXPECT_EQ(database->GetJob(id)->state, JobState::kDead);
  EXPECT_EQ(database->GetJob(id)->attempt, 5);
}

// What ran beside a job that ends its process is not lost with it each time.
TEST_F(Jobs, ThoseThatWereLostTogetherDoNotBeginTogetherAgain) {
  std::vector<JobId> ids;
  for (const char* const id : {"a", "b", "c"}) ids.push_back(database->CreateJob(Job(id), 10)->id);
  for (int loss = 0; loss < 3; ++loss) {
    for (size_t i = 0; i < ids.size(); ++i) Claim();
    database.Close();
    database.Open();
  }
  for (size_t began = 0; began < ids.size(); ++began) {
    EXPECT_FALSE(database->ClaimJob(kLease)->has_value());
    database.clock.Advance(**database->NextJobWait());
    Claim();
  }
}

// Of a plant whose power fails three times nothing is known against the job; of a process that dies in each attempt it
// is.
TEST_F(Jobs, AttemptsThatEndedWithTheMachineDoNotCount) {
  const JobId id = database->CreateJob(Job("a"), 10)->id;
  for (int restart = 0; restart < 4; ++restart) {
    EXPECT_EQ(Claim().attempt, 1);
    database.Close();
    // As if it had been claimed in an earlier boot: the last part of the owner's text is another one.
    ASSERT_TRUE(database.Beside()->Execute("UPDATE job SET owner = substr(owner, 1, 42) || 'former'").ok());
    database.Open();
    EXPECT_EQ(database->GetJob(id)->state, JobState::kQueued);
    EXPECT_EQ(database->GetJob(id)->attempt, 0);
    EXPECT_EQ(database->GetJob(id)->error->reason, "MACHINE_RESTARTED");
  }
}

TEST_F(Jobs, AnOwnerTellsMachineAndBoot) {
  const std::string self = "0123456789abcdef01234567-mill-boot2";
  EXPECT_TRUE(IsOfEarlierBoot("76543210fedcba9876543210-mill-boot1", self));
  EXPECT_FALSE(IsOfEarlierBoot("76543210fedcba9876543210-mill-boot2", self));   // its process alone died
  EXPECT_FALSE(IsOfEarlierBoot("76543210fedcba9876543210-lathe-boot1", self));  // of whose boots nothing is known here
  EXPECT_FALSE(IsOfEarlierBoot("76543210fedcba9876543210", self));              // of an older version
  EXPECT_FALSE(IsOfEarlierBoot("76543210fedcba9876543210-mill-boot1", "0123456789abcdef01234567"));
}

// Whose claim or outcome did not arrive goes on at once; what is held is left alone, and so is another attempt.
TEST_F(Jobs, WhatNobodyHoldsIsReturnedAndNotCounted) {
  const JobId held = database->CreateJob(Job("a"), 10)->id, lost = database->CreateJob(Job("b"), 10)->id;
  const JobRecord of_held = Claim(), of_lost = Claim();
  ASSERT_EQ(of_held.id, held);
  const auto returned = database->ReturnJobs({ClaimOf(of_held)});
  ASSERT_TRUE(returned.ok()) << returned.status();
  ASSERT_EQ(returned->size(), 1u);
  EXPECT_EQ((*returned)[0].id, lost);
  EXPECT_EQ((*returned)[0].state, JobState::kQueued);
  EXPECT_EQ((*returned)[0].attempt, 0);
  EXPECT_EQ((*returned)[0].error->reason, "STORE_AWAY");
  EXPECT_EQ(base::ErrorReason(database->SucceedJob(ClaimOf(of_lost), {"late", {}, {}}).status()), "LEASE_LOST");
  const JobRecord second = Claim();
  EXPECT_EQ(second.id, lost);
  EXPECT_EQ(second.attempt, 1);
  // An older claim of the same job holds nothing.
  EXPECT_EQ(database->ReturnJobs({ClaimOf(of_held), ClaimOf(of_lost)})->size(), 1u);
  EXPECT_TRUE(database->ReturnJobs({ClaimOf(of_held)})->empty());
  EXPECT_TRUE(database->SucceedJob(ClaimOf(of_held), {"in time", {}, {}}).ok());
}

TEST_F(Jobs, RetriesWaitAndParkedAttemptsDoNotCount) {
  const JobId id = database->CreateJob(Job("a"), 10)->id;
  ASSERT_TRUE(database->EndJob(ClaimOf(Claim()), JobEnd::kRetry, Error(), seconds(5)).ok());
  EXPECT_FALSE(database->ClaimJob(kLease)->has_value());
  EXPECT_EQ(**database->NextJobWait(), seconds(5));
  database.clock.Advance(seconds(5));
  const JobRecord second = Claim();
  EXPECT_EQ(second.attempt, 2);
  EXPECT_EQ(second.error->message, "because");
  ASSERT_TRUE(database->EndJob(ClaimOf(second), JobEnd::kParked, Error(), seconds(0)).ok());
  EXPECT_EQ(Claim().attempt, 2);
  EXPECT_EQ(database->GetJob(id)->state, JobState::kRunning);
}

// Of jobs that wait for another attempt the first one; none of them where another waits for nothing but its turn.
TEST_F(Jobs, WhenTheNextOneMayBeClaimedIsTold) {
  for (const char* const id : {"a", "b"}) ASSERT_TRUE(database->CreateJob(Job(id), 10).ok());
  EXPECT_EQ(**database->NextJobWait(), seconds(0));
  ASSERT_TRUE(database->EndJob(ClaimOf(Claim()), JobEnd::kRetry, Error(), seconds(9)).ok());
  EXPECT_EQ(**database->NextJobWait(), seconds(0));
  ASSERT_TRUE(database->EndJob(ClaimOf(Claim()), JobEnd::kRetry, Error(), seconds(5)).ok());
  EXPECT_EQ(**database->NextJobWait(), seconds(5));
  database.clock.Advance(seconds(7));
  EXPECT_EQ(**database->NextJobWait(), seconds(0));
  EXPECT_EQ(Claim().attempt, 2);
  EXPECT_EQ(**database->NextJobWait(), seconds(2));
}

TEST_F(Jobs, AWallClockSetBackMakesNoJobWait) {
  ASSERT_TRUE(database->CreateJob(Job("a"), 10).ok());
  database.clock.SetUtc(database.clock.UtcNow() - std::chrono::hours(48));
  const JobRecord first = Claim();
  ASSERT_TRUE(database->EndJob(ClaimOf(first), JobEnd::kRetry, Error(), seconds(5)).ok());
  database.Close();
  database.clock.SetUtc(database.clock.UtcNow() - std::chrono::hours(48));
  database.Open();
  EXPECT_FALSE(database->ClaimJob(kLease)->has_value());
  database.clock.Advance(seconds(5));
  EXPECT_EQ(Claim().attempt, 2);
}

TEST_F(Jobs, CancelEndsWaitingOnesAndAsksRunningOnes) {
  const JobId running = database->CreateJob(Job("a"), 10)->id;
  const JobId waiting = database->CreateJob(Job("b"), 10)->id;
  const JobRecord claimed = Claim();
  ASSERT_EQ(claimed.id, running);
  EXPECT_EQ(database->CancelJob(waiting, Cell(""))->state, JobState::kCancelled);
  EXPECT_EQ(database->CancelJob(running, Cell(""))->state, JobState::kRunning);
  EXPECT_TRUE(database->HeartbeatJob(ClaimOf(claimed), kLease, {})->cancel_requested);
  // A worker that fails for another reason does not bring a cancelled job back.
  EXPECT_EQ(database->EndJob(ClaimOf(claimed), JobEnd::kRetry, Error(), seconds(0))->state, JobState::kCancelled);
  EXPECT_EQ(database->CancelJob(running, Cell(""))->state, JobState::kCancelled);
  EXPECT_EQ(base::ErrorReason(database->CancelJob(JobId(99), Cell("")).status()), "JOB_NOT_FOUND");
}

// A thousand reports of megabytes would fit into no answer.
TEST_F(Jobs, ListsHoldNoReports) {
  ASSERT_TRUE(database->CreateJob(Job("a"), 10).ok());
  const JobId id = database->SucceedJob(ClaimOf(Claim()), {"report", {}, {}})->id;
  EXPECT_EQ(database->ListJobs({}, {})->rows.at(0).state, JobState::kSucceeded);
  EXPECT_EQ(database->ListJobs({}, {})->rows.at(0).result, "");
  EXPECT_EQ(database->GetJob(id)->result, "report");
}

TEST_F(Jobs, ListsOfLargeOnesComeInSmallerPages) {
  NewJob job = Job("");
  job.params = std::string(kMaxPageBytes / 3, 'p');
  for (int i = 0; i < 7; ++i) ASSERT_TRUE(database->CreateJob(job, 10).ok());
  std::vector<int64_t> ids;
  PageRequest request = {1000, ""};
  int pages = 0;
  do {
    const auto page = database->ListJobs({}, request);
    ASSERT_TRUE(page.ok()) << page.status();
    size_t bytes = 0;
    for (const JobRecord& row : page->rows) {
      ids.push_back(row.id.number());
      bytes += row.params.size();
    }
    EXPECT_LE(bytes, kMaxPageBytes);
    request.token = page->next_token;
    ++pages;
  } while (!request.token.empty());
  EXPECT_EQ(ids, (std::vector<int64_t>{7, 6, 5, 4, 3, 2, 1}));
  EXPECT_EQ(pages, 4);
}

TEST_F(Jobs, ListsFilterAndPage) {
  NewJob other = Job("x");
  other.kind = "compensate";
  other.input_hash = "h";
  ASSERT_TRUE(database->CreateJob(other, 10).ok());
  for (const char* id : {"a", "b", "c"}) ASSERT_TRUE(database->CreateJob(Job(id), 10).ok());
  ASSERT_TRUE(database->CancelJob(JobId(1), Cell("")).ok());
  JobFilter filter;
  filter.state = JobState::kQueued;
  const auto first = database->ListJobs(filter, {2, ""});
  ASSERT_EQ(first->rows.size(), 2u);
  const auto second = database->ListJobs(filter, {2, first->next_token});
  ASSERT_EQ(second->rows.size(), 1u);
  EXPECT_EQ(second->rows[0].id.number(), 2);
  filter = {};
  filter.input_hash = "h";
  EXPECT_EQ(database->ListJobs(filter, {})->rows.at(0).kind, "compensate");
  EXPECT_EQ(base::ErrorReason(database->ListJobs(filter, {2, first->next_token}).status()), "PAGE_INVALID");
  const UtcTime now = database.clock.UtcNow();
  EXPECT_EQ(database->ListJobs({{}, {}, "", {now, {}}, "compensate"}, {})->rows.size(), 1u);
  EXPECT_EQ(database->ListJobs({{}, {}, "", {now, {}}, ""}, {})->rows.size(), 4u);
  EXPECT_EQ(database->ListJobs({{}, {}, "", {{}, now}, ""}, {})->rows.size(), 0u);
  EXPECT_EQ(database->ListJobs({{}, JobState::kQueued, "", {}, "compensate"}, {})->rows.size(), 0u);
}

}  // namespace
}  // namespace axiscal::storage
