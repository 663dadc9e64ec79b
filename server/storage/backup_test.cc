#include "server/storage/backup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>

#include "core/base/error_detail.h"
#include "core/base/sha256.h"
#include "server/storage/check.h"
#include "server/storage/file_lock.h"
#include "server/storage/sqlite_connection.h"
#include "server/storage/testing/temp_database.h"
#include "server/storage/undone.h"

namespace axiscal::storage {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::unique_ptr<Database> OpenFile(const std::string& path) {
  SqliteOptions options;
  options.path = path;
  auto opened = OpenSqlite(options);
  DEMAND(opened.ok());
  return *std::move(opened);
}

std::string Bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class Backup : public testing::Test {
 protected:
  std::string Copy(const std::string& name) {
    const std::string path = folder_.File(name);
    const auto made = database_->Backup(path, nullptr);
    EXPECT_TRUE(made.ok()) << made.status();
    return path;
  }
  TempDatabase database_;
  TempDirectory folder_;
};

// Between two pieces others have their turn: so much of the disk's time is taken at once, and no more.
TEST_F(Backup, IsMadeOfSmallPieces) {
  constexpr int64_t kPieceBytes = 1 << 20;
  const SessionId open = [&] {
    StoreSession(*database_, 1);
    return database_->CreateSession(TestSession("large"))->id;
  }();
  std::mt19937_64 random(3);
  for (int seq = 0; seq < 200; ++seq) {
    std::vector<session::Column> columns = TestColumns(seq, 4000);
    for (double& value : columns[1].values) value = static_cast<double>(random()) / 3.0;
    ASSERT_TRUE(Append(*database_, open, seq, columns).ok());
  }
  const std::string path = folder_.File("copy.db");
  std::vector<int64_t> sizes = {0};
  bool is_copying = true;
  const auto look = [&] {
    if (is_copying) sizes.push_back(static_cast<int64_t>(std::filesystem::file_size(path + ".part")));
    return absl::OkStatus();
  };
  const auto made = CopyStore(database_.path(), path, look, [&] { is_copying = false; });
  ASSERT_TRUE(made.ok()) << made.status();
  ASSERT_GT(made->bytes, 5 * kPieceBytes);
  constexpr int64_t kHeldBack = 32 * 4096;  // pages that the cache holds back until the next piece
  for (size_t i = 1; i < sizes.size(); ++i)
    EXPECT_LE(sizes[i] - sizes[i - 1], kPieceBytes + kHeldBack) << "piece " << i;
  EXPECT_GE(static_cast<int64_t>(sizes.size()), made->bytes / kPieceBytes);
}

TEST_F(Backup, IsWholeWhileOthersWrite) {
  const SessionId stored = StoreSession(*database_, 50);
  const SessionId open = database_->CreateSession(TestSession("open"))->id;
  std::atomic<bool> is_over = false;
  std::atomic<int64_t> written = 0;
  std::thread writer([&] {
    for (int64_t seq = 0; !is_over; ++seq) {
      DEMAND(Append(*database_, open, seq, TestColumns(seq, 10)).ok());
      ++written;
    }
  });
  while (written < 3) std::this_thread::yield();
  const int64_t before = written;
  int64_t during = 0;
  const std::string path = folder_.File("copy.db");
  const auto made = database_->Backup(path, [&] {
    // Others go on while it is made.
    const int64_t now = written;
    while (written == now) std::this_thread::yield();
    during = written;
    return absl::OkStatus();
  });
  is_over = true;
  writer.join();
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_GT(during, before);
  EXPECT_EQ(made->report.damage_count, 0);
  EXPECT_EQ(made->bytes, static_cast<int64_t>(Bytes(path).size()));
  EXPECT_EQ(made->sha256, base::Sha256Hex(Bytes(path)));
  struct stat info;
  ASSERT_EQ(stat(path.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600u);
  for (const auto& file : std::filesystem::directory_iterator(std::filesystem::path(path).parent_path()))
    EXPECT_EQ(file.path().string(), path);
  const std::unique_ptr<Database> copy = OpenFile(path);
  EXPECT_EQ(*copy->ReadSession(stored), *database_->ReadSession(stored));
  EXPECT_GE(copy->GetSession(open)->next_seq, before);
}

TEST_F(Backup, LeavesNothingBehindWhenItFails) {
  StoreSession(*database_, 1);
  const std::string path = folder_.File("copy.db");
  const auto stopped = database_->Backup(path, [] { return absl::CancelledError("enough"); });
  EXPECT_TRUE(absl::IsCancelled(stopped.status())) << stopped.status();
  EXPECT_FALSE(std::filesystem::exists(path));
  std::ofstream(path) << "mine";
  EXPECT_TRUE(absl::IsAlreadyExists(database_->Backup(path, nullptr).status()));
  EXPECT_EQ(Bytes(path), "mine");
  EXPECT_EQ(base::ErrorReason(database_->Backup(folder_.File("none/copy.db"), nullptr).status()),
            "FOLDER_NOT_WRITABLE");
}

// A copy is made of what is damaged too: the rest is worth keeping.
TEST_F(Backup, NamesWhatIsDamaged) {
  StoreSession(*database_, 2);
  ASSERT_TRUE((*SqliteConnection::Open(database_.path(), Access::kWrite))
                  ->Execute("DROP TRIGGER chunk_is_never_changed; UPDATE chunk SET crc32c = 1 WHERE seq = 1")
                  .ok());
  const std::string path = folder_.File("copy.db");
  const auto made = database_->Backup(path, nullptr);
  ASSERT_TRUE(made.ok()) << made.status();
  ASSERT_EQ(made->report.damage_count, 2);
  EXPECT_EQ(made->report.damages[0].resource, "schema");  // the trigger that would have refused the change
  EXPECT_EQ(made->report.damages[1].resource, "sessions/1/chunks/1");

  const std::string target = folder_.File("target.db");
  const absl::Status refused = RestoreStore(path, target, false).status();
  EXPECT_EQ(base::ErrorReason(refused), "BACKUP_DAMAGED");
  EXPECT_THAT(std::string(refused.message()), HasSubstr("sessions/1/chunks/1"));
  EXPECT_FALSE(std::filesystem::exists(target));
  EXPECT_TRUE(RestoreStore(path, target, true).ok());
  EXPECT_TRUE(OpenFile(target)->GetSession(SessionId(1)).ok());
}

TEST_F(Backup, IsRestoredInThePlaceOfAnother) {
  const SessionId stored = StoreSession(*database_, 3);
  const session::Session session = *database_->ReadSession(stored);
  const std::string path = Copy("copy.db");
  ASSERT_TRUE(database_->CreateMachine(MachineId("later"), "{}", Cell("")).ok());
  EXPECT_EQ(base::ErrorReason(RestoreStore(path, database_.path(), false).status()), "STORE_LOCKED");
  database_.Close();
  const std::string before = Bytes(database_.path());
  const auto restored = RestoreStore(path, database_.path(), false);
  ASSERT_TRUE(restored.ok()) << restored.status();
  EXPECT_EQ(restored->sessions, 1);
  EXPECT_EQ(Bytes(database_.path() + ".replaced"), before);
  database_.Open();
  EXPECT_EQ(*database_->ReadSession(stored), session);
  EXPECT_TRUE(absl::IsNotFound(database_->GetMachine(MachineId("later")).status()));
  database_.Close();
  EXPECT_EQ(base::ErrorReason(RestoreStore(path, database_.path(), false).status()), "RESTORE_KEPT");
}

// The log that a crash has left belongs to the file that was there: it is never taken for the backup's.
TEST_F(Backup, IsRestoredBesideTheLogOfACrash) {
  StoreSession(*database_, 3);
  const std::string path = Copy("copy.db");
  ASSERT_TRUE(database_->CreateMachine(MachineId("later"), "{}", Cell("")).ok());
  const std::string target = folder_.File("crashed.db");
  for (const char* const end : {"", "-wal"}) std::filesystem::copy_file(database_.path() + end, target + end);
  ASSERT_GT(std::filesystem::file_size(target + "-wal"), 0u);
  ASSERT_TRUE(RestoreStore(path, target, false).ok());
  EXPECT_FALSE(std::filesystem::exists(target + "-wal"));
  EXPECT_TRUE(absl::IsNotFound(OpenFile(target)->GetMachine(MachineId("later")).status()));
  EXPECT_TRUE(OpenFile(target + ".replaced")->GetMachine(MachineId("later")).ok());
}

// A first start that was cut off leaves an empty file and the journal of its first pages: SQLite empties whatever it
// finds beside that journal later.
TEST_F(Backup, IsRestoredBesideTheJournalOfAFirstStart) {
  const SessionId stored = StoreSession(*database_, 3);
  const std::string path = Copy("copy.db"), begun = folder_.File("begun.db"), target = folder_.File("cut-off.db");
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(begun.c_str(), &db), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(db,
                         "PRAGMA cache_size = 2; BEGIN; CREATE TABLE t (x);"
                         "WITH RECURSIVE n (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 3000)"
                         " INSERT INTO t SELECT randomblob (500) FROM n",
                         nullptr, nullptr, nullptr),
            SQLITE_OK);
  std::filesystem::copy_file(begun + "-journal", target + "-journal");
  sqlite3_close(db);
  std::ofstream(target).flush();
  ASSERT_TRUE(RestoreStore(path, target, false).ok());
  EXPECT_TRUE(OpenFile(target)->ReadSession(stored).ok());
  // The journal was put aside. Beside the database that another restore puts there it would empty that.
  ASSERT_TRUE(std::filesystem::exists(KeptPath(target) + "-journal"));
  std::filesystem::remove(KeptPath(target));
  const absl::Status again = RestoreStore(path, target, false).status();
  EXPECT_EQ(base::ErrorReason(again), "RESTORE_KEPT") << again;
  EXPECT_THAT(std::string(again.message()), testing::HasSubstr(KeptPath(target) + "-journal"));
  EXPECT_TRUE(OpenFile(target)->ReadSession(stored).ok());
}

// Who was revoked since the backup is let in again: whoever restores it is told.
TEST_F(Backup, TellsWhatItsRestoringUndoes) {
  const Caller ann = {"ann", ""};
  for (const char* const name : {"bob", "cell-7"}) ASSERT_TRUE(database_->CreatePrincipal(name, "", ann).ok());
  const records::Grant viewer = {records::Role::kViewer, {}};
  ASSERT_TRUE(database_->ChangeRole("bob", viewer, true, ann).ok());
  const std::string path = Copy("copy.db");
  ASSERT_TRUE(database_->CreatePrincipal("later", "", ann).ok());
  ASSERT_TRUE(database_->RevokePrincipal("cell-7", ann).ok());
  ASSERT_TRUE(database_->ChangeRole("bob", viewer, false, ann).ok());
  database_.Close();
  ASSERT_TRUE(RestoreStore(path, database_.path(), false).ok());
  const auto undone = UndoneByRestore(KeptPath(database_.path()), database_.path());
  ASSERT_TRUE(undone.ok()) << undone.status();
  std::vector<std::string> texts;
  for (const AuditEntry& entry : *undone) texts.push_back(entry.action + " " + entry.resource);
  EXPECT_THAT(texts, ElementsAre("principal.revoke principals/cell-7", "role.take principals/bob"));
  // What is no backup of it tells nothing of it, and that is said.
  const std::string other = folder_.File("other.db");
  ASSERT_TRUE(OpenFile(other)->CreatePrincipal("cell-7", "", ann).ok());
  const auto of_other = UndoneByRestore(KeptPath(database_.path()), other);
  EXPECT_EQ(base::ErrorReason(of_other.status()), "NO_EARLIER_STATE") << of_other.status();
}

// A restore that was killed when the database had its second name already.
TEST_F(Backup, ASecondNameThatARestoreHasLeftIsTakenAway) {
  StoreSession(*database_, 1);
  database_.Close();
  ASSERT_EQ(link(database_.path().c_str(), KeptPath(database_.path()).c_str()), 0);
  database_.Open();
  EXPECT_FALSE(std::filesystem::exists(KeptPath(database_.path())));
  EXPECT_TRUE(database_->ReadSession(SessionId(1)).ok());
}

TEST_F(Backup, CompactingGivesBackWhatWasRemoved) {
  const SessionId stored = StoreSession(*database_, 3);
  const session::Session session = *database_->ReadSession(stored);
  const SessionId left = database_->CreateSession(TestSession("left"))->id;
  for (int seq = 0; seq < 200; ++seq) ASSERT_TRUE(Append(*database_, left, seq, TestColumns(seq, 500)).ok());
  ASSERT_TRUE(database_->AbortSession(left).ok());
  EXPECT_EQ(base::ErrorReason(CompactStore(database_.path()).status()), "STORE_LOCKED");
  database_.Close();
  const auto compacted = CompactStore(database_.path());
  ASSERT_TRUE(compacted.ok()) << compacted.status();
  EXPECT_LT(compacted->after_bytes, compacted->before_bytes / 2);
  database_.Open();
  EXPECT_EQ(*database_->ReadSession(stored), session);
  EXPECT_TRUE(database_->CheckAudit().ok());
  // Numbers are not given twice.
  EXPECT_EQ(database_->CreateSession(TestSession("next"))->id.number(), left.number() + 1);
  database_.Close();
  ASSERT_TRUE((*SqliteConnection::Open(database_.path(), Access::kWrite))
                  ->Execute("DROP TRIGGER chunk_is_never_changed; UPDATE chunk SET crc32c = 1")
                  .ok());
  const std::string before = Bytes(database_.path());
  EXPECT_EQ(base::ErrorReason(CompactStore(database_.path()).status()), "STORE_DAMAGED");
  EXPECT_EQ(Bytes(database_.path()), before);
}

}  // namespace
}  // namespace axiscal::storage
