#include "server/jobs/job_watch.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace axiscal::jobs {
namespace {

using records::JobRecord;
using records::JobState;
using std::chrono::milliseconds;

JobRecord Record(int64_t id, JobState state, int64_t version) {
  JobRecord record;
  record.id = JobId(id);
  record.state = state;
  record.version = version;
  return record;
}

TEST(JobWatch, MergesWhatCameTooFastButNeverSkipsTheEnd) {
  JobBoard board;
  const std::shared_ptr<JobWatch> watch = board.Watch(JobId(1));
  EXPECT_FALSE(watch->Next(milliseconds(0)).has_value());
  board.Publish(Record(1, JobState::kQueued, 1));
  board.Publish(Record(1, JobState::kRunning, 2));
  board.Publish(Record(2, JobState::kSucceeded, 9));
  EXPECT_EQ(watch->Next(milliseconds(0))->state, JobState::kRunning);
  EXPECT_FALSE(watch->done());
  board.Publish(Record(1, JobState::kSucceeded, 4));
  board.Publish(Record(1, JobState::kRunning, 3));  // comes late
  EXPECT_FALSE(watch->done());
  EXPECT_EQ(watch->Next(milliseconds(0))->state, JobState::kSucceeded);
  EXPECT_TRUE(watch->done());
}

TEST(JobWatch, ALateRecordDoesNotGoBackInTime) {
  JobBoard board;
  const std::shared_ptr<JobWatch> watch = board.Watch(JobId(1));
  board.Publish(Record(1, JobState::kRunning, 5));
  board.Deliver(*watch, Record(1, JobState::kQueued, 4));
  EXPECT_EQ(watch->Next(milliseconds(0))->version, 5);
}

// How often is judged by the time that has really passed, so that a loaded machine cannot fail it.
TEST(JobWatch, ProgressAloneIsGivenNowAndThenAndChangesOfTheJobAtOnce) {
  JobBoard board;
  const std::shared_ptr<JobWatch> watch = board.Watch(JobId(1));
  const auto start = std::chrono::steady_clock::now();
  std::atomic<bool> is_over = false;
  std::thread runs([&] {
    JobRecord record = Record(1, JobState::kRunning, 2);
    while (!is_over) {
      record.progress.fraction += 1e-9;
      board.Publish(record);
    }
  });
  double furthest = 0;
  int given = 0;
  for (; given < 4; ++given) {
    std::optional<JobRecord> record = watch->Next(std::chrono::minutes(1));
    if (!record) break;
    EXPECT_GT(record->progress.fraction, furthest);
    furthest = record->progress.fraction;
  }
  EXPECT_EQ(given, 4);
  EXPECT_GE(std::chrono::steady_clock::now() - start, (given - 1) * kProgressEvery);
  is_over = true;
  runs.join();
  // What came last is not lost, only late; a change of the job is not late, nor is its end.
  board.Publish(Record(1, JobState::kRunning, 3));
  EXPECT_EQ(watch->Next(milliseconds(0))->version, 3);
  board.Publish(Record(1, JobState::kRunning, 3));
  EXPECT_EQ(watch->Next(std::chrono::minutes(1))->version, 3);
  board.Publish(Record(1, JobState::kRunning, 3));
  board.Publish(Record(1, JobState::kSucceeded, 3));
  EXPECT_EQ(watch->Next(milliseconds(0))->state, JobState::kSucceeded);
  EXPECT_TRUE(watch->done());
}

TEST(JobWatch, WaitsForAChangeAndEndsWithTheBoard) {
  JobBoard board;
  const std::shared_ptr<JobWatch> watch = board.Watch(JobId(1));
  std::thread publisher([&] { board.Publish(Record(1, JobState::kRunning, 2)); });
  EXPECT_EQ(watch->Next(std::chrono::minutes(1))->version, 2);
  publisher.join();
  std::thread closer([&] { board.Close(); });
  EXPECT_FALSE(watch->Next(std::chrono::minutes(1)).has_value());
  closer.join();
  EXPECT_TRUE(watch->done());
  EXPECT_TRUE(board.Watch(JobId(2))->done());
}

}  // namespace
}  // namespace axiscal::jobs
