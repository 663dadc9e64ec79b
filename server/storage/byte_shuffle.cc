#include "server/storage/byte_shuffle.h"

#include <algorithm>
#include <cstring>

#include "core/base/demand.h"

namespace axiscal::storage {
namespace {

// Transposes 8 x 8 bytes in place (its own inverse): halves, quarters, then bytes trade places (Warren, Hacker's
// Delight, 7-3).
void Transpose(uint64_t (&rows)[8]) {
  for (int i = 0; i < 4; ++i) {
    const uint64_t trade = (rows[i] >> 32 ^ rows[i + 4]) & 0x00000000FFFFFFFF;
    rows[i + 4] ^= trade;
    rows[i] ^= trade << 32;
  }
  for (const int i : {0, 1, 4, 5}) {
    const uint64_t trade = (rows[i] >> 16 ^ rows[i + 2]) & 0x0000FFFF0000FFFF;
    rows[i + 2] ^= trade;
    rows[i] ^= trade << 16;
  }
  for (const int i : {0, 2, 4, 6}) {
    const uint64_t trade = (rows[i] >> 8 ^ rows[i + 1]) & 0x00FF00FF00FF00FF;
    rows[i + 1] ^= trade;
    rows[i] ^= trade << 8;
  }
}

}  // namespace

std::string Shuffle(const std::vector<uint64_t>& words, int planes) {
  const size_t plane_size = PlaneSize(words.size());
  std::string bytes(planes * plane_size, '\0');
  for (size_t first = 0; first < words.size(); first += 8) {
    uint64_t rows[8] = {};
    std::memcpy(rows, &words[first], std::min<size_t>(8, words.size() - first) * sizeof(uint64_t));
    Transpose(rows);
    for (int plane = 0; plane < planes; ++plane) std::memcpy(&bytes[plane * plane_size + first], &rows[plane], 8);
  }
  return bytes;
}

std::vector<uint64_t> Unshuffle(const std::string& bytes, int planes, size_t word_count) {
  const size_t plane_size = PlaneSize(word_count);
  DEMAND(bytes.size() == planes * plane_size);
  std::vector<uint64_t> words(plane_size);
  for (size_t first = 0; first < word_count; first += 8) {
    uint64_t rows[8] = {};
    for (int plane = 0; plane < planes; ++plane) std::memcpy(&rows[plane], &bytes[plane * plane_size + first], 8);
    Transpose(rows);
    std::memcpy(&words[first], rows, sizeof(rows));
  }
  words.resize(word_count);
  return words;
}

}  // namespace axiscal::storage
