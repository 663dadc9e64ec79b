#include <gtest/gtest.h>

#include "core/base/crc32c.h"
#include "core/base/sha256.h"

namespace axiscal::base {
namespace {

TEST(Crc32c, GivesTheCheckValueOfTheStandardAlsoInPieces) {
  EXPECT_EQ(Crc32c(0, "123456789", 9), 0xE3069283u);
  EXPECT_EQ(Crc32c(Crc32c(0, "1234", 4), "56789", 5), 0xE3069283u);
  EXPECT_EQ(Crc32c(0, nullptr, 0), 0u);
}

TEST(Sha256, GivesTheExampleOfTheStandardAlsoInPieces) {
  const std::string expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
  EXPECT_EQ(Sha256Hex("abc"), expected);
  Sha256 sha;
  sha.Add("a");
  sha.Add("bc", 2);
  EXPECT_EQ(sha.HexDigest(), expected);
}

}  // namespace
}  // namespace axiscal::base
