// Rows of `chunk`: a session's readings. What each function returns: database.h.
#ifndef AXISCAL_SERVER_STORAGE_CHUNKS_H_
#define AXISCAL_SERVER_STORAGE_CHUNKS_H_

#include <optional>
#include <string>
#include <vector>

#include "core/records/chunk.h"
#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// Why the readings of a session are not there though nothing is damaged: FAILED_PRECONDITION, in place of
// CHUNK_DAMAGED.
inline constexpr char kReadingsDetached[] = "READINGS_DETACHED";

struct EncodedChunk {
  int64_t seq = 0;
  int64_t reading_count = 0;
  uint32_t crc32c = 0;  // of the readings: session::ChunkCrc32c
  std::string content;  // EncodeChunk
};

// What can be done before the writer's turn. CHUNK_INVALID when the chunk has not the columns `specs`.
absl::StatusOr<EncodedChunk> PrepareChunk(const records::Chunk& chunk, const std::vector<ColumnSpec>& specs);
absl::StatusOr<AppendResult> AppendChunk(Connection& connection, const Moment& now, SessionId id,
                                         const EncodedChunk& chunk);

// Chunk `seq` or nothing after the last one; DATA_LOSS CHUNK_DAMAGED unless it is exactly what was appended.
// FAILED_PRECONDITION READINGS_DETACHED where it was taken out with its neighbours (Connection::HasDetached()).
absl::StatusOr<std::optional<records::Chunk>> ReadChunk(Connection& connection, const SessionRecord& session,
                                                        int64_t seq);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_CHUNKS_H_
