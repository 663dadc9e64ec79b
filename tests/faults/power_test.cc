// kill -9 in the midst of work, then a restart: what was acknowledged is there, nothing is there twice.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>
#include <random>

#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

// Runs `work` in a process of its own and kills it after it has told `kill_after` numbers; gives all numbers it told
// before it died.
std::vector<int64_t> RunAndKill(int kill_after, const std::function<void(const std::function<void(int64_t)>&)>& work) {
  int channel[2];
  DEMAND(pipe(channel) == 0);
  const pid_t child = fork();
  DEMAND(child >= 0);
  if (child == 0) {
    close(channel[0]);
    work([&](int64_t told) { DEMAND(write(channel[1], &told, sizeof(told)) == sizeof(told)); });
    _exit(0);
  }
  close(channel[1]);
  std::vector<int64_t> told;
  int64_t number = 0;
  while (read(channel[0], &number, sizeof(number)) == sizeof(number)) {
    told.push_back(number);
    if (static_cast<int>(told.size()) == kill_after) kill(child, SIGKILL);
  }
  close(channel[0]);
  DEMAND(waitpid(child, nullptr, 0) == child);
  return told;
}

std::unique_ptr<Database> Open(const std::string& path) {
  SqliteOptions options;
  options.path = path;
  absl::StatusOr<std::unique_ptr<Database>> database = OpenSqlite(options);
  DEMAND(database.ok());
  return *std::move(database);
}

// Appends from where the session stands, several chunks under way at once, and tells each seq when it is acknowledged.
void Upload(const std::string& path, int first_chunks, int64_t last_seq, const std::function<void(int64_t)>& tell) {
  const std::unique_ptr<Database> database = Open(path);
  const SessionRecord session = *database->CreateSession(TestSession("upload"));
  // As a client does that has not seen the last answers: some chunks are sent again.
  for (int64_t seq = std::max<int64_t>(session.next_seq - first_chunks, 0); seq < last_seq; ++seq) {
    database->AppendChunkAsync(session.id, records::Chunk::Seal(seq, TestColumns(seq, 20)),
                               [seq, &tell](absl::StatusOr<AppendResult> result) {
                                 DEMAND(result.ok());
                                 tell(seq);
                               });
  }
  DEMAND(database->GetSession(session.id).ok());
}

TEST(PowerTest, NoAcknowledgedChunkIsLostOrStoredTwice) {
  constexpr int64_t kChunks = 1200;
  constexpr int kRepeated = 3;
  TempDirectory directory;
  const std::string path = directory.File("power.db");
  ASSERT_TRUE(Open(path)->CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
  std::mt19937 random(5);
  SessionId id;
  int64_t acknowledged = 0;
  for (int kills = 0; acknowledged < kChunks && kills < 200; ++kills) {
    const std::vector<int64_t> told =
        RunAndKill(1 + static_cast<int>(random() % 60),
                   [&](const std::function<void(int64_t)>& tell) { Upload(path, kRepeated, kChunks, tell); });
    if (!told.empty()) acknowledged = std::max(acknowledged, told.back() + 1);
    const std::unique_ptr<Database> database = Open(path);
    const SessionRecord session = *database->CreateSession(TestSession("upload"));
    id = session.id;
    ASSERT_GE(session.next_seq, acknowledged) << "an acknowledged chunk is lost";
    ASSERT_EQ(session.reading_count, session.next_seq * 20) << "a chunk is there twice";
  }
  ASSERT_EQ(acknowledged, kChunks);
  const std::unique_ptr<Database> database = Open(path);
  std::vector<uint32_t> crcs;
  for (int64_t seq = 0; seq < kChunks; ++seq) crcs.push_back(session::ChunkCrc32c(TestColumns(seq, 20)));
  const auto finished = database->FinishSession(id, {kChunks, kChunks * 20, session::SessionHash(crcs)});
  ASSERT_TRUE(finished.ok()) << finished.status();
  int64_t next_seq = 0;
  ASSERT_TRUE(database
                  ->ReadChunks(id, 0,
                               [&](const records::Chunk& chunk) {
                                 EXPECT_EQ(chunk.seq(), next_seq++);
                                 EXPECT_EQ(chunk.columns(), TestColumns(chunk.seq(), 20));
                                 return absl::OkStatus();
                               })
                  .ok());
  EXPECT_EQ(next_seq, kChunks);
}

// Claims job after job; each makes a calibration whose value names the job. Tells what has ended.
void WorkOff(const std::string& path, const std::function<void(int64_t)>& tell) {
  const std::unique_ptr<Database> database = Open(path);
  while (true) {
    const auto claimed = database->ClaimJob(std::chrono::seconds(30));
    DEMAND(claimed.ok());
    if (!claimed->has_value()) return;
    const JobRecord& job = **claimed;
    tell(0);  // another point to be killed at: claimed, not stored
    const JobProduct product = {
        "done", TestCalibration(base::FromUtcUs(job.id.number()), static_cast<double>(job.id.number())), {}};
    DEMAND(database->SucceedJob(ClaimOf(job), product).ok());
    tell(job.id.number());
  }
}

TEST(PowerTest, EveryJobEndsOnceWhateverHappensToItsWorkers) {
  constexpr int kJobs = 120;
  TempDirectory directory;
  const std::string path = directory.File("power.db");
  {
    const std::unique_ptr<Database> database = Open(path);
    ASSERT_TRUE(database->CreateMachine(MachineId("mt"), "{}", Cell("")).ok());
    for (int i = 0; i < kJobs; ++i) {
      NewJob job;
      job.kind = "identify";
      job.max_attempts = 1000;
      ASSERT_TRUE(database->CreateJob(job, kJobs).ok());
    }
  }
  std::mt19937 random(6);
  std::vector<int64_t> told;
  for (int kills = 0; kills < 300; ++kills) {
    const std::vector<int64_t> now = RunAndKill(1 + static_cast<int>(random() % 15),
                                                [&](const std::function<void(int64_t)>& tell) { WorkOff(path, tell); });
    told.insert(told.end(), now.begin(), now.end());
    if (now.empty()) break;  // nothing left to claim
  }
  const std::unique_ptr<Database> database = Open(path);
  for (const int64_t id : told) {
    if (id == 0) continue;
    EXPECT_EQ(database->GetJob(JobId(id))->state, JobState::kSucceeded) << "acknowledged job " << id;
  }
  JobFilter succeeded;
  succeeded.state = JobState::kSucceeded;
  EXPECT_EQ(database->ListJobs(succeeded, {1000, ""})->rows.size(), static_cast<size_t>(kJobs));
  EXPECT_EQ(database->ListCalibrations({}, {1000, ""})->rows.size(), static_cast<size_t>(kJobs));
  const auto drift = database->QueryDrift({MachineId("mt"), {"EA0B"}, base::FromUtcUs(0), base::FromUtcUs(1000), 1000});
  EXPECT_EQ(drift->at(0).points.size(), static_cast<size_t>(kJobs));
}

}  // namespace
}  // namespace axiscal::storage
