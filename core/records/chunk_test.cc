#include "core/records/chunk.h"

#include <gtest/gtest.h>

#include <limits>
#include <type_traits>

#include "core/base/error_detail.h"
#include "core/session/checksum.h"

namespace axiscal::records {
namespace {

const std::vector<ColumnSpec> kSpecs = {{"X_mm", false}, {"rod", true}};

std::vector<session::Column> Columns() { return {{"X_mm", {1.0, 2.0}, {}}, {"rod", {}, {"a", "b"}}}; }

absl::Status VerifySealed(const std::vector<session::Column>& columns) {
  return Chunk::Verify(0, columns, session::ChunkCrc32c(columns), kSpecs).status();
}

// Readings with a checksum that nobody has looked at must not pass for a chunk.
static_assert(!std::is_aggregate_v<Chunk> && !std::is_default_constructible_v<Chunk>);
static_assert(!std::is_constructible_v<Chunk, int64_t, std::vector<session::Column>, uint32_t>);
static_assert(!std::is_convertible_v<std::vector<session::Column>, Chunk>);

TEST(Chunk, BothMakersMakeTheSame) {
  const Chunk sealed = Chunk::Seal(3, Columns());
  EXPECT_EQ(sealed.crc32c(), session::ChunkCrc32c(Columns()));
  EXPECT_EQ(sealed.reading_count(), 2);
  const auto verified = Chunk::Verify(3, Columns(), sealed.crc32c(), kSpecs);
  ASSERT_TRUE(verified.ok()) << verified.status();
  EXPECT_EQ(verified->seq(), 3);
  EXPECT_EQ(verified->columns(), Columns());
  EXPECT_EQ(verified->crc32c(), sealed.crc32c());
}

TEST(Chunk, AnotherChecksumIsCorrupt) {
  const absl::Status status = Chunk::Verify(7, Columns(), session::ChunkCrc32c(Columns()) + 1, kSpecs).status();
  EXPECT_EQ(base::ErrorReason(status), "CHUNK_CORRUPT");
  EXPECT_EQ(base::GetErrorDetail(status)->facts.at("seq"), "7");
  EXPECT_EQ(status.message(), "chunk 7: its checksum does not fit its content: send it again");
}

TEST(Chunk, RefusesColumnsThatAreNotTheSessions) {
  const std::vector<std::vector<session::Column>> wrong = {
      {},
      {{"X_mm", {1.0}, {}}},
      {{"Y_mm", {1.0}, {}}, {"rod", {}, {"a"}}},
      {{"X_mm", {1.0, 2.0}, {}}, {"rod", {}, {"a"}}},
      {{"X_mm", {}, {}}, {"rod", {}, {}}},
      {{"X_mm", {1.0}, {"b"}}, {"rod", {}, {"a"}}},
      {{"X_mm", std::vector<double>(kMaxChunkReadings + 1), {}},
       {"rod", {}, std::vector<std::string>(kMaxChunkReadings + 1)}}};
  for (const std::vector<session::Column>& columns : wrong)
    EXPECT_EQ(base::ErrorReason(VerifySealed(columns)), "CHUNK_INVALID");
  EXPECT_TRUE(VerifySealed({{"X_mm", {1.0}, {}}, {"rod", {}, {"a"}}}).ok());
  EXPECT_EQ(base::ErrorReason(Chunk::Verify(-1, Columns(), session::ChunkCrc32c(Columns()), kSpecs).status()),
            "CHUNK_INVALID");
}

TEST(Chunk, TakesEmptyCellsAndTheMostReadingsButNoInfinity) {
  std::vector<session::Column> columns = {{"X_mm", std::vector<double>(kMaxChunkReadings, 1.0), {}},
                                 {"rod", {}, std::vector<std::string>(kMaxChunkReadings, "a")}};
  columns[0].values[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(VerifySealed(columns).ok());
  columns[0].values.back() = -std::numeric_limits<double>::infinity();
  EXPECT_EQ(VerifySealed(columns).message(), "chunk 0: X_mm: reading 4095 is infinite");
  columns[0].values.back() = 1.0;
  columns[1].texts[5] = std::string(kMaxChunkTextBytes, 'a');
  EXPECT_EQ(base::ErrorReason(VerifySealed(columns)), "CHUNK_INVALID");
}

TEST(Chunk, KnowsWhoseColumnsItHas) {
  const Chunk chunk = Chunk::Seal(0, Columns());
  EXPECT_TRUE(chunk.HasColumns(kSpecs));
  EXPECT_FALSE(chunk.HasColumns({{"X_mm", false}}));
  EXPECT_FALSE(chunk.HasColumns({{"X_mm", false}, {"rod", true}, {"Y_mm", false}}));
  EXPECT_FALSE(chunk.HasColumns({{"X_mm", false}, {"rod", false}}));
  EXPECT_FALSE(chunk.HasColumns({{"Y_mm", false}, {"rod", true}}));
}

}  // namespace
}  // namespace axiscal::records
