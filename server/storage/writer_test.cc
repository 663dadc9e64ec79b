#include "server/storage/writer.h"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>

#include "server/storage/sqlite_log.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

constexpr int kPageBytes = 4096;

class WriterTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto connection = SqliteConnection::Open(path_, Access::kWrite);
    ASSERT_TRUE(connection.ok()) << connection.status();
    ASSERT_TRUE((*connection)->Execute("CREATE TABLE piece (content BLOB NOT NULL)").ok());
    log_ = std::make_unique<SqliteLog>(**connection, limits_);
    writer_ = std::make_unique<Writer>(*std::move(connection), [this] { log_->Limit(); });
  }
  void Commit(int times) {
    for (int i = 0; i < times; ++i) {
      ASSERT_TRUE(writer_
                      ->Run([](Connection& connection) {
                        return connection.Run("INSERT INTO piece (content) VALUES (?1)",
                                              Blob{std::string(2 * kPageBytes, 'x')});
                      })
                      .ok());
    }
  }
  int64_t LogPages() const { return static_cast<int64_t>(std::filesystem::file_size(path_ + "-wal")) / kPageBytes; }

  TempDirectory directory_;
  const std::string path_ = directory_.File("test.db");
  std::atomic<int> pauses_ = 0;
  LogLimits limits_{.merge_pages = 100, .max_pages = 200, .max_pauses = 10, .pause = [this] { ++pauses_; }};
  std::unique_ptr<SqliteLog> log_;
  std::unique_ptr<Writer> writer_;
};

// As the sqlite3 program's VACUUM INTO does: one state of the file is read for as long as it takes.
TEST_F(WriterTest, ABackupDoesNotHoldUpEachCommit) {
  Commit(10);
  const auto backup = SqliteConnection::Open(path_, Access::kReadOnly);
  ASSERT_TRUE(backup.ok());
  ASSERT_TRUE((*backup)->Execute("BEGIN; SELECT count(*) FROM piece").ok());
  Commit(500);
  const int64_t pages = LogPages();
  ASSERT_GT(pages, 10 * limits_.max_pages);
  const int pauses = pauses_;
  // Not one time for each of 500 commits, but one for each 100 pages.
  EXPECT_GT(pauses, 0);
  EXPECT_LE(pauses, limits_.max_pauses * (pages / limits_.merge_pages + 1));

  ASSERT_TRUE((*backup)->Execute("COMMIT").ok());
  Commit(500);  // as much again, into a log that begins anew
  EXPECT_LE(LogPages(), pages + limits_.merge_pages);
}

TEST_F(WriterTest, WithoutReadersTheLogStaysShortAndNobodyWaits) {
  Commit(1000);
  EXPECT_EQ(pauses_, 0);
  EXPECT_LE(LogPages(), limits_.max_pages);
}

}  // namespace
}  // namespace axiscal::storage
