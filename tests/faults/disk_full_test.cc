// A disk that takes no more: a clean error, reads go on, and it works again afterwards.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <random>

#include "core/base/error_detail.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

// The limit of this process on the size of any file; lifted again when it goes.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    DEMAND(getrlimit(RLIMIT_FSIZE, &before_) == 0);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    DEMAND(setrlimit(RLIMIT_FSIZE, &limit) == 0);
  }
  ~FileSizeLimit() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_;
};

std::vector<session::Column> Incompressible(std::mt19937_64& random) {
  std::vector<session::Column> columns = TestColumns(0, 2000);
  for (double& value : columns[1].values) value = static_cast<double>(random()) / 3.0;
  return columns;
}

TEST(DiskFull, FailsCleanlyAndRecovers) {
  TempDatabase database;
  const SessionId complete = StoreSession(*database, 2);
  const SessionId id = database->CreateSession(TestSession("big"))->id;
  std::mt19937_64 random(8);
  std::vector<uint32_t> crcs;
  std::vector<session::Column> refused;
  {
    const FileSizeLimit limit(2 << 20);
    absl::Status status;
    for (int seq = 0; seq < 1000 && status.ok(); ++seq) {
      refused = Incompressible(random);
      status = Append(*database, id, seq, refused).status();
      if (status.ok()) crcs.push_back(session::ChunkCrc32c(refused));
    }
    EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
    EXPECT_EQ(base::ErrorReason(status), "DISK_FULL");
    EXPECT_GT(crcs.size(), 10u);
    // Reads go on, of what was there and of what had been acknowledged.
    EXPECT_TRUE(database->ReadSession(complete).ok());
    EXPECT_EQ(database->GetSession(id)->next_seq, static_cast<int64_t>(crcs.size()));
    EXPECT_FALSE(Append(*database, id, static_cast<int64_t>(crcs.size()), refused).ok());
  }
  ASSERT_TRUE(Append(*database, id, static_cast<int64_t>(crcs.size()), refused).ok());
  crcs.push_back(session::ChunkCrc32c(refused));
  const int64_t chunks = static_cast<int64_t>(crcs.size());
  const auto finished = database->FinishSession(id, {chunks, chunks * 2000, session::SessionHash(crcs)});
  ASSERT_TRUE(finished.ok()) << finished.status();
  database.Close();
  database.Open();
  EXPECT_TRUE(database->ReadSession(id).ok());
}

TEST(DiskFull, ConcurrentWritersAllGetAnAnswer) {
  TempDatabase database;
  StoreSession(*database, 1);
  const SessionId id = database->CreateSession(TestSession("big"))->id;
  std::mt19937_64 random(9);
  int64_t acknowledged = 0, failed = 0;
  {
    const FileSizeLimit limit(2 << 20);
    for (int seq = 0; seq < 200; ++seq) {
      database->AppendChunkAsync(id, records::Chunk::Seal(seq, Incompressible(random)),
                                 [&](absl::StatusOr<AppendResult> result) { ++(result.ok() ? acknowledged : failed); });
    }
    EXPECT_FALSE(database->AbortSession(SessionId(99)).ok());  // waits for all before it
  }
  EXPECT_GT(acknowledged, 0);
  EXPECT_GT(failed, 0);
  EXPECT_EQ(acknowledged + failed, 200);
  EXPECT_EQ(database->GetSession(id)->next_seq, acknowledged);
}

}  // namespace
}  // namespace axiscal::storage
