// Bits that flip on the disk: never other readings, always an error that says where.
#include <gtest/gtest.h>

#include <random>

#include "core/base/error_detail.h"
#include "server/storage/connection.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

class Damage : public testing::Test {
 protected:
  // Changes rows behind the store's back, as a disk may.
  void Execute(const std::string& sql) {
    const auto connection = Connection::Open(database.path(), Access::kWrite);
    DEMAND(connection.ok());
    const absl::Status status = (*connection)->Execute(sql);
    ASSERT_TRUE(status.ok()) << status;
  }
  std::string ReadContent(const std::string& sql) {
    const auto connection = Connection::Open(database.path(), Access::kReadOnly);
    DEMAND(connection.ok());
    auto row = (*connection)->Ask(sql);
    DEMAND(row.ok() && row->Step().ok());
    return row->Text(0);
  }
  void WriteContent(const std::string& sql, const std::string& content) {
    const auto connection = Connection::Open(database.path(), Access::kWrite);
    DEMAND(connection.ok());
    const absl::Status status = (*connection)->Run(sql, Blob{content});
    ASSERT_TRUE(status.ok()) << status;
  }

  TempDatabase database;
  std::mt19937 random{7};
};

TEST_F(Damage, OfAChunkIsNoticedAndNamed) {
  const SessionId id = StoreSession(*database, 3);
  const session::Session good = *database->ReadSession(id);
  Execute("DROP TRIGGER chunk_is_never_changed");
  const std::string content = ReadContent("SELECT content FROM chunk WHERE seq = 1");
  for (int round = 0; round < 300; ++round) {
    std::string bad = content;
    bad[random() % bad.size()] ^= static_cast<char>(1 << random() % 8);
    WriteContent("UPDATE chunk SET content = ?1 WHERE seq = 1", bad);
    const absl::StatusOr<session::Session> read = database->ReadSession(id);
    // A bit that means nothing (a filler of the compressed stream) may flip; readings never differ.
    if (read.ok()) {
      ASSERT_EQ(*read, good);
      continue;
    }
    ASSERT_TRUE(absl::IsDataLoss(read.status())) << read.status();
    ASSERT_EQ(base::ErrorReason(read.status()), "CHUNK_DAMAGED");
    ASSERT_EQ(base::GetErrorDetail(read.status())->facts.at("seq"), "1");
  }
  WriteContent("UPDATE chunk SET content = ?1 WHERE seq = 1", content);
  EXPECT_EQ(*database->ReadSession(id), good);
}

TEST_F(Damage, AMissingChunkIsNoticed) {
  const SessionId id = StoreSession(*database, 3);
  Execute("DROP TRIGGER complete_session_keeps_its_chunks; DELETE FROM chunk WHERE seq = 2");
  EXPECT_EQ(base::GetErrorDetail(database->ReadSession(id).status())->facts.at("seq"), "2");
}

TEST_F(Damage, TheStoreItselfCannotChangeRawReadings) {
  StoreSession(*database, 1);
  const auto connection = Connection::Open(database.path(), Access::kWrite);
  EXPECT_FALSE((*connection)->Execute("UPDATE chunk SET crc32c = 0").ok());
  EXPECT_FALSE((*connection)->Execute("DELETE FROM chunk").ok());
  EXPECT_FALSE((*connection)->Execute("DELETE FROM audit").ok());
}

TEST_F(Damage, OfAProgramIsNoticed) {
  const ProgramId id = database->BeginProgram({"nc", "O1", Cell("")})->id;
  ASSERT_TRUE(database->AppendProgram(id, 0, "G01 X1.0000 Y2.0000 Z3.0000\n").ok());
  ASSERT_TRUE(database->FinishProgram(id, 28, "").ok());
  std::string content = ReadContent("SELECT content FROM program_part");
  content[content.size() - 3] ^= 1;
  WriteContent("UPDATE program_part SET content = ?1", content);
  const absl::Status read = database->ReadProgram(id, 0, [](const std::string&) { return absl::OkStatus(); });
  EXPECT_EQ(base::ErrorReason(read), "PART_DAMAGED") << read;
}

}  // namespace
}  // namespace axiscal::storage
