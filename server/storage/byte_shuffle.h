// Byte planes: the lowest bytes of all words, then the second ones, ... Neighbouring readings differ in few bytes, so
// planes compress well.
#ifndef AXISCAL_SERVER_STORAGE_BYTE_SHUFFLE_H_
#define AXISCAL_SERVER_STORAGE_BYTE_SHUFFLE_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace axiscal::storage {

// Bytes of one plane: a multiple of 8, the rest zero.
inline size_t PlaneSize(size_t words) { return (words + 7) / 8 * 8; }

// The `planes` (1 .. 8) low planes of `words`; the planes above must be zero. Exactly planes * PlaneSize bytes.
std::string Shuffle(const std::vector<uint64_t>& words, int planes);
// The inverse: `bytes` holds planes * PlaneSize(word_count) bytes.
std::vector<uint64_t> Unshuffle(const std::string& bytes, int planes, size_t word_count);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_BYTE_SHUFFLE_H_
