// A chunk of readings as the blob that is stored: a version byte, the number of readings and of columns, then each
// column's size and coding (column_codec.h). Names are not stored: the session has them. Measured logs take 1 to 5
// bytes per number.
#ifndef AXISCAL_SERVER_STORAGE_CHUNK_CODEC_H_
#define AXISCAL_SERVER_STORAGE_CHUNK_CODEC_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// `columns` are those of a records::Chunk.
std::string EncodeChunk(const std::vector<session::Column>& columns);
// DATA_LOSS when `bytes` is not a chunk of such columns. A chunk with flipped bits may also decode to other numbers:
// the caller compares the CRC.
absl::StatusOr<std::vector<session::Column>> DecodeChunk(const std::string& bytes,
                                                         const std::vector<ColumnSpec>& specs);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_CHUNK_CODEC_H_
