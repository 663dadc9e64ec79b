// Sessions on the wire: header and columns, chunks of readings, totals.
#ifndef AXISCAL_PROTO_CONVERT_SESSION_H_
#define AXISCAL_PROTO_CONVERT_SESSION_H_

#include <vector>

#include "axiscal/v1/session.pb.h"
#include "core/base/status.h"
#include "core/records/chunk.h"
#include "core/records/session.h"

namespace axiscal::convert {

inline constexpr int kMaxChunkBytes = 256 << 10;
inline constexpr int kMaxColumns = 256;

v1::SessionSchema ToProto(const records::SessionSchema& schema);
// FIELD_INVALID: no column, more than kMaxColumns, two of one name, a column of no kind, an empty key.
absl::StatusOr<records::SessionSchema> FromProto(const v1::SessionSchema& message);

v1::SessionRemark ToProto(const records::SessionRemark& remark);
records::SessionRemark FromProto(const v1::SessionRemark& message);
v1::Session ToProto(const records::SessionRecord& record);
// Without header and columns, which travel as a schema.
absl::StatusOr<records::SessionRecord> FromProto(const v1::Session& message);
v1::SessionState ToProto(records::SessionState state);
absl::StatusOr<records::SessionState> FromProto(v1::SessionState state);

v1::SessionTotals ToProto(const records::SessionTotals& totals);
absl::StatusOr<records::SessionTotals> FromProto(const v1::SessionTotals& message);

v1::Chunk ToProto(const records::Chunk& chunk);
// As records::Chunk::Verify against `columns`.
absl::StatusOr<records::Chunk> FromProto(const v1::Chunk& message, const std::vector<records::ColumnSpec>& columns);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_SESSION_H_
