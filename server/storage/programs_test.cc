#include <gtest/gtest.h>

#include "core/base/error_detail.h"
#include "core/base/sha256.h"
#include "server/storage/testing/temp_database.h"

namespace axiscal::storage {
namespace {

class Programs : public testing::Test {
 protected:
  ProgramId Begin(const std::string& request_id) {
    return database->BeginProgram({"nc", "O1.nc", Cell(request_id)})->id;
  }
  std::string Read(ProgramId id, int64_t offset) {
    std::string all;
    DEMAND(database
               ->ReadProgram(id, offset,
                             [&](const std::string& bytes) {
                               all += bytes;
                               return absl::OkStatus();
                             })
               .ok());
    return all;
  }
  std::string Reason(const absl::Status& status) { return base::ErrorReason(status); }

  TempDatabase database;
};

TEST_F(Programs, AreReadBackFromAnyByte) {
  const ProgramId id = Begin("a");
  const std::string parts[] = {"G01 X1\n", "G01 X2\n", std::string(100'000, 'x')};
  std::string whole;
  for (const std::string& part : parts) {
    const auto appended = database->AppendProgram(id, static_cast<int64_t>(whole.size()), part);
    ASSERT_TRUE(appended.ok()) << appended.status();
    whole += part;
    EXPECT_EQ(appended->byte_count, static_cast<int64_t>(whole.size()));
  }
  EXPECT_EQ(Reason(database->ReadProgram(id, 0, [](const std::string&) { return absl::OkStatus(); })),
            "PROGRAM_NOT_COMPLETE");
  const auto done = database->FinishProgram(id, static_cast<int64_t>(whole.size()), base::Sha256Hex(whole));
  ASSERT_TRUE(done.ok()) << done.status();
  EXPECT_EQ(done->sha256, base::Sha256Hex(whole));
  for (const int64_t offset : {0, 3, 7, 20, 100'000, 100'014}) EXPECT_EQ(Read(id, offset), whole.substr(offset));
  EXPECT_EQ(database->ListPrograms({"nc"}, {})->rows.size(), 1u);
  EXPECT_TRUE(database->ListPrograms({"table"}, {})->rows.empty());
}

TEST_F(Programs, UploadsResume) {
  const ProgramId id = Begin("a");
  ASSERT_TRUE(database->AppendProgram(id, 0, "12345").ok());
  EXPECT_EQ(Begin("a"), id);
  EXPECT_EQ(database->GetProgram(id)->byte_count, 5);
  EXPECT_EQ(database->AppendProgram(id, 0, "12345")->byte_count, 5);
  EXPECT_EQ(Reason(database->AppendProgram(id, 0, "99999").status()), "PART_CONFLICT");
  const absl::Status gap = database->AppendProgram(id, 6, "7").status();
  EXPECT_EQ(Reason(gap), "OFFSET_GAP");
  EXPECT_EQ(base::GetErrorDetail(gap)->facts.at("next_offset"), "5");
  EXPECT_EQ(Reason(database->AppendProgram(id, 5, "").status()), "PART_INVALID");
}

TEST_F(Programs, EqualContentIsStoredOnce) {
  const ProgramId first = Begin("a"), second = Begin("b");
  for (const ProgramId id : {first, second}) ASSERT_TRUE(database->AppendProgram(id, 0, "G00").ok());
  ASSERT_TRUE(database->FinishProgram(first, 3, "").ok());
  EXPECT_EQ(database->FinishProgram(second, 3, "")->id, first);
  EXPECT_EQ(database->FinishProgram(second, 3, "")->id, first);  // repeated after a lost answer
  EXPECT_EQ(database->GetProgram(second)->id, first);
  EXPECT_EQ(Read(second, 0), "G00");
  EXPECT_EQ(database->ListPrograms({}, {})->rows.size(), 1u);
}

TEST_F(Programs, WrongTotalsAreRefused) {
  const ProgramId id = Begin("a");
  ASSERT_TRUE(database->AppendProgram(id, 0, "G00").ok());
  EXPECT_EQ(Reason(database->FinishProgram(id, 4, "").status()), "TOTALS_MISMATCH");
  EXPECT_EQ(Reason(database->FinishProgram(id, 3, "00").status()), "TOTALS_MISMATCH");
  ASSERT_TRUE(database->FinishProgram(id, 3, "").ok());
  EXPECT_EQ(Reason(database->AppendProgram(id, 3, "G01").status()), "PROGRAM_CLOSED");
  EXPECT_EQ(Reason(database->GetProgram(ProgramId(9)).status()), "PROGRAM_NOT_FOUND");
}

TEST_F(Programs, AbandonedOnesExpire) {
  const ProgramId id = Begin("a");
  ASSERT_TRUE(database->AppendProgram(id, 0, "G00").ok());
  database.clock.Advance(std::chrono::hours(1));
  database.clock.SetUtc(database.clock.UtcNow() + std::chrono::hours(10));
  EXPECT_EQ(*database->ExpirePrograms(std::chrono::hours(2)), 0);
  EXPECT_EQ(*database->ExpirePrograms(std::chrono::minutes(1)), 1);
  EXPECT_EQ(Reason(database->AppendProgram(id, 3, "G01").status()), "PROGRAM_CLOSED");
  // It can be sent again.
  const ProgramId again = Begin("a");
  EXPECT_NE(again, id);
  EXPECT_EQ(Begin("a"), again);
  ASSERT_TRUE(database->AppendProgram(again, 0, "G00").ok());
  EXPECT_EQ(database->FinishProgram(again, 3, "")->id, again);
}

}  // namespace
}  // namespace axiscal::storage
