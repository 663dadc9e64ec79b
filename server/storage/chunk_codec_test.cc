#include "server/storage/chunk_codec.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "core/session/checksum.h"

namespace axiscal::storage {
namespace {

using session::Column;

std::vector<ColumnSpec> SpecsOf(const std::vector<Column>& columns) {
  std::vector<ColumnSpec> specs;
  for (const Column& column : columns) specs.push_back({column.name, !column.texts.empty()});
  return specs;
}

// Bit by bit, so that -0 and NaN count.
void ExpectRoundTrip(const std::vector<Column>& columns) {
  const absl::StatusOr<std::vector<Column>> decoded = DecodeChunk(EncodeChunk(columns), SpecsOf(columns));
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  ASSERT_EQ(decoded->size(), columns.size());
  for (size_t i = 0; i < columns.size(); ++i) {
    EXPECT_EQ((*decoded)[i].name, columns[i].name);
    EXPECT_EQ((*decoded)[i].texts, columns[i].texts);
    ASSERT_EQ((*decoded)[i].values.size(), columns[i].values.size());
    for (size_t k = 0; k < columns[i].values.size(); ++k) {
      EXPECT_EQ(std::bit_cast<uint64_t>((*decoded)[i].values[k]), std::bit_cast<uint64_t>(columns[i].values[k]))
          << i << " " << k;
    }
  }
}

double BytesPerValue(const std::vector<double>& values) {
  return static_cast<double>(EncodeChunk({{"x", values, {}}}).size()) / static_cast<double>(values.size());
}

TEST(ChunkCodec, GivesEveryDoubleBackBitByBit) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  ExpectRoundTrip({{"special",
                    {0.0, -0.0, kInfinity, -kInfinity, std::nan("7"), std::numeric_limits<double>::denorm_min(), 1e308,
                     -1e-308, 0.1},
                    {}}});
  ExpectRoundTrip({{"one", {0.1}, {}}});
  ExpectRoundTrip({{"two", {1e15, -1e15}, {}}});
  ExpectRoundTrip({{"large", {2251799813685248.0, 9007199254740992.0, -9007199254740993.0, 9.2e18, -9.3e18}, {}}});
  ExpectRoundTrip({{"constant", std::vector<double>(1000, -350.0), {}}});
}

TEST(ChunkCodec, GivesRandomColumnsOfEveryLengthBack) {
  std::mt19937_64 random(1);
  for (int round = 0; round < 200; ++round) {
    const size_t count = 1 + random() % 40;
    std::vector<Column> columns = {{"bits", {}, {}}, {"grid", {}, {}}, {"text", {}, {}}};
    const double power = std::pow(10.0, static_cast<double>(random() % 13));
    for (size_t i = 0; i < count; ++i) {
      columns[0].values.push_back(std::bit_cast<double>(random()));
      columns[1].values.push_back(static_cast<double>(static_cast<int64_t>(random() % 2'000'001) - 1'000'000) / power);
      columns[2].texts.push_back(std::string(random() % 5, static_cast<char>(random())));
    }
    ExpectRoundTrip(columns);
  }
}

TEST(ChunkCodec, StoresDecimalsInFewBytes) {
  std::mt19937_64 random(2);
  std::normal_distribution<double> noise(0.0, 0.3);
  std::vector<double> smooth, full;
  for (int i = 0; i < 1000; ++i) {
    const double x_mm = 150.0 * std::sin(i / 300.0);
    smooth.push_back(std::round((x_mm + 1e-3 * noise(random)) * 1e4) / 1e4);  // a scale of 0.1 um
    full.push_back(x_mm);
  }
  EXPECT_LT(BytesPerValue(smooth), 1.5);
  EXPECT_LT(BytesPerValue(full), 8.1);
}

// Whatever the bytes: an error or other readings (which the checksum notices), never a crash.
TEST(ChunkCodec, SurvivesDamagedBytes) {
  std::mt19937_64 random(3);
  const std::vector<Column> columns = {{"a", {1.5, 2.5, 2.75, 3.0, 1e-9, 0.1}, {}},
                                       {"b", {0.1 + 0.2, 1.0 / 3.0, 5, 6, 7, 8}, {}},
                                       {"c", {}, {"x", "yy", "", "z", "x", "x"}}};
  const std::string good = EncodeChunk(columns);
  const uint32_t crc = session::ChunkCrc32c(columns);
  for (int round = 0; round < 5000; ++round) {
    std::string bad = good;
    if (random() % 4 == 0) bad.resize(random() % bad.size());
    if (!bad.empty()) bad[random() % bad.size()] ^= static_cast<char>(1 << random() % 8);
    if (bad == good) continue;
    const absl::StatusOr<std::vector<Column>> decoded = DecodeChunk(bad, SpecsOf(columns));
    if (decoded.ok() && session::ChunkCrc32c(*decoded) == crc) {
      EXPECT_EQ(decoded->at(2), columns[2]);
      EXPECT_EQ(decoded->at(0).values, columns[0].values);
    }
  }
}

}  // namespace
}  // namespace axiscal::storage
