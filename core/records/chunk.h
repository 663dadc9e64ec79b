// A piece of a session's readings: how they travel and are kept.
#ifndef AXISCAL_CORE_RECORDS_CHUNK_H_
#define AXISCAL_CORE_RECORDS_CHUNK_H_

#include <cstdint>
#include <vector>

#include "core/session/session.h"

namespace axiscal::records {

// Consecutive readings of all columns, with their place and checksum.
struct Chunk {
  int64_t seq = 0;  // 0, 1, ... within the session
  std::vector<session::Column> columns;
  uint32_t crc32c = 0;  // session::ChunkCrc32c
};

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_CHUNK_H_
