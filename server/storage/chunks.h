// Rows of `chunk`: a session's readings. What each function returns: database.h.
#ifndef AXISCAL_SERVER_STORAGE_CHUNKS_H_
#define AXISCAL_SERVER_STORAGE_CHUNKS_H_

#include <optional>
#include <string>
#include <vector>

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

struct EncodedChunk {
  int64_t seq = 0;
  int64_t reading_count = 0;
  uint32_t crc32c = 0;  // of the readings: session::ChunkCrc32c
  std::string content;  // EncodeChunk
};

// Checks columns and checksum and encodes: what can be done before the writer's turn.
absl::StatusOr<EncodedChunk> PrepareChunk(int64_t seq, const std::vector<session::Column>& columns, uint32_t crc32c,
                                          const std::vector<ColumnSpec>& specs);
absl::StatusOr<AppendResult> AppendChunk(Connection& connection, UtcTime now, SessionId id, const EncodedChunk& chunk);

// Chunk `seq` or nothing after the last one; DATA_LOSS CHUNK_DAMAGED unless it is exactly what was appended.
absl::StatusOr<std::optional<std::vector<session::Column>>> ReadChunk(Connection& connection,
                                                                      const SessionRecord& session, int64_t seq);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_CHUNKS_H_
