// Sessions on the wire: header and columns, chunks of readings, totals.
#ifndef AXISCAL_PROTO_CONVERT_SESSION_H_
#define AXISCAL_PROTO_CONVERT_SESSION_H_

#include <vector>

#include "axiscal/v1/session.pb.h"
#include "core/base/status.h"
#include "core/session/session.h"
#include "server/storage/records.h"

namespace axiscal::convert {

inline constexpr int kMaxChunkReadings = 4096;
inline constexpr int kMaxChunkBytes = 256 << 10;
inline constexpr int kMaxColumns = 256;

struct SessionSchema {
  std::vector<session::HeaderEntry> header;
  std::vector<storage::ColumnSpec> columns;

  bool operator==(const SessionSchema&) const = default;
};

// Of a session with or without readings.
SessionSchema SchemaOf(const session::Session& session);

v1::SessionSchema ToProto(const SessionSchema& schema);
// FIELD_INVALID: no column, more than kMaxColumns, two of one name, a column of no kind, an empty key.
absl::StatusOr<SessionSchema> FromProto(const v1::SessionSchema& message);

v1::Session ToProto(const storage::SessionRecord& record);
// Without header and columns, which travel as a schema.
absl::StatusOr<storage::SessionRecord> FromProto(const v1::Session& message);
v1::SessionState ToProto(storage::SessionState state);
absl::StatusOr<storage::SessionState> FromProto(v1::SessionState state);

v1::SessionTotals ToProto(const storage::SessionTotals& totals);
absl::StatusOr<storage::SessionTotals> FromProto(const v1::SessionTotals& message);

// Consecutive readings of all columns, with their place and checksum.
struct Chunk {
  int64_t seq = 0;
  std::vector<session::Column> columns;
  uint32_t crc32c = 0;
};

v1::Chunk ToProto(const Chunk& chunk);
// CHUNK_INVALID when it does not fit `columns`: their number and kinds, equal lengths, 1 to kMaxChunkReadings,
// infinities (NaN is an empty cell, which the session's reader judges). CHUNK_CORRUPT when the checksum does not fit.
// Facts: seq.
absl::StatusOr<Chunk> FromProto(const v1::Chunk& message, const std::vector<storage::ColumnSpec>& columns);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_SESSION_H_
