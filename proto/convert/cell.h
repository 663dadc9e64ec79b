// Cells on the wire.
#ifndef AXISCAL_PROTO_CONVERT_CELL_H_
#define AXISCAL_PROTO_CONVERT_CELL_H_

#include "axiscal/v1/ingest_service.pb.h"
#include "core/base/status.h"
#include "core/records/cell.h"

namespace axiscal::convert {

inline constexpr size_t kMaxCellProblemBytes = 500;

v1::CellReport ToProto(const records::CellReport& report);
// FIELD_INVALID: no machine, no name, a number that is negative, silent_after_s outside 60 to 2592000 (30 days).
absl::StatusOr<records::CellReport> FromProto(const v1::CellReport& message);

v1::Cell ToProto(const records::CellRecord& cell);
absl::StatusOr<records::CellRecord> FromProto(const v1::Cell& message);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_CELL_H_
