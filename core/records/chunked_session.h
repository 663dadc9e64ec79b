// A session as it travels: cut into chunks, under a name that its content gives.
#ifndef AXISCAL_CORE_RECORDS_CHUNKED_SESSION_H_
#define AXISCAL_CORE_RECORDS_CHUNKED_SESSION_H_

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/records/chunk.h"
#include "core/records/session.h"

namespace axiscal::records {

// Readings per chunk where nobody says otherwise.
inline constexpr int kUsualChunkReadings = 1000;

// A session cut into chunks of equal length, made one by one when they are sent. Each is sealed once: its checksum is
// kept for the totals.
class ChunkedSession {
 public:
  // `session` must outlive it.
  ChunkedSession(const session::Session& session, int chunk_readings);

  int64_t chunk_count() const { return chunk_count_; }
  int64_t reading_count() const { return reading_count_; }
  // Readings in the chunks below `seq`.
  int64_t ReadingsBelow(int64_t seq) const { return std::min(seq * chunk_readings_, reading_count_); }
  Chunk At(int64_t seq);
  // Seals the chunks that nobody asked for.
  SessionTotals Totals();

 private:
  const session::Session& session_;
  const int64_t chunk_readings_;
  const int64_t reading_count_;
  const int64_t chunk_count_;
  std::vector<std::optional<uint32_t>> crc32cs_;  // of the chunks sealed so far
};

// The same for the same machine, header, columns and cells: the request id of an upload.
std::string ContentId(const MachineId& machine, const session::Session& session, int chunk_readings);

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_CHUNKED_SESSION_H_
