#include "core/session/checksum.h"

#include <gtest/gtest.h>

#include <limits>

namespace axiscal::session {
namespace {

TEST(Checksum, CoversEveryBitOfNumbersAndEveryBoundaryOfTexts) {
  const Column zero = {"X_mm", {0.0}, {}}, minus_zero = {"X_mm", {-0.0}, {}};
  EXPECT_NE(ChunkCrc32c({zero}), ChunkCrc32c({minus_zero}));
  const Column split = {"rod", {}, {"ab", "c"}}, other_split = {"rod", {}, {"a", "bc"}};
  EXPECT_NE(ChunkCrc32c({split}), ChunkCrc32c({other_split}));
  const Column nan = {"X_mm", {std::numeric_limits<double>::quiet_NaN()}, {}};
  EXPECT_EQ(ChunkCrc32c({nan}), ChunkCrc32c({nan}));
}

// By a bitwise CRC in another language: 1.0 is 00 00 00 00 00 00 f0 3f.
TEST(Checksum, IsTheOneThatOtherLanguagesCompute) {
  EXPECT_EQ(ChunkCrc32c({Column{"X_mm", {1.0}, {}}}), 0xA642E961u);
  EXPECT_EQ(SessionHash({}), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

}  // namespace
}  // namespace axiscal::session
