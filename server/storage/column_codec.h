// One column of readings as few bytes, without loss. Three codings, one byte in front says which:
//   planes  byte-shuffled doubles, zstd;
//   grid    for decimals with few places, as most columns are: integers n with value = n / 10^decimals, their
//           differences of order 0, 1 or 2 (whichever is smallest), zigzag, byte-shuffled, zstd. Only where every
//           double comes back bit by bit;
//   texts   lengths and bytes, zstd.
#ifndef AXISCAL_SERVER_STORAGE_COLUMN_CODEC_H_
#define AXISCAL_SERVER_STORAGE_COLUMN_CODEC_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/storage/bytes.h"

namespace axiscal::storage {

std::string EncodeNumbers(const std::vector<double>& values);
std::string EncodeTexts(const std::vector<std::string>& texts);

// DATA_LOSS when `bytes` is not a coding of `count` readings.
absl::StatusOr<std::vector<double>> DecodeNumbers(ByteReader bytes, size_t count);
absl::StatusOr<std::vector<std::string>> DecodeTexts(ByteReader bytes, size_t count);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_COLUMN_CODEC_H_
