// How a session is brought to the server: in chunks, resumed where the server stands. Internal to the client.
#ifndef AXISCAL_CLIENT_UPLOAD_H_
#define AXISCAL_CLIENT_UPLOAD_H_

#include <optional>
#include <vector>

#include "client/client.h"
#include "core/records/chunk.h"

namespace axiscal::client {

class Connection;

// A session cut into chunks of equal length, made one by one when they are sent. Each is sealed once: its checksum is
// kept for the totals.
class ChunkedSession {
 public:
  ChunkedSession(const session::Session& session, int chunk_readings);

  int64_t chunk_count() const { return chunk_count_; }
  int64_t reading_count() const { return reading_count_; }
  // Readings in the chunks below `seq`.
  int64_t ReadingsBelow(int64_t seq) const { return std::min(seq * chunk_readings_, reading_count_); }
  records::Chunk At(int64_t seq);
  // Seals the chunks that nobody asked for.
  records::SessionTotals Totals();

 private:
  const session::Session& session_;
  const int64_t chunk_readings_;
  const int64_t reading_count_;
  const int64_t chunk_count_;
  std::vector<std::optional<uint32_t>> crc32cs_;  // of the chunks sealed so far
};

// The same for the same machine, header, columns and cells: the request id of an upload.
std::string ContentId(const MachineId& machine, const session::Session& session, int chunk_readings);

absl::StatusOr<UploadResult> UploadSession(const Connection& connection, const MachineId& machine,
                                           const session::Session& session, const ProgressCallback& progress);

}  // namespace axiscal::client

#endif  // AXISCAL_CLIENT_UPLOAD_H_
