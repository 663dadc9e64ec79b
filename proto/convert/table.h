// Compensation tables on the wire.
#ifndef AXISCAL_PROTO_CONVERT_TABLE_H_
#define AXISCAL_PROTO_CONVERT_TABLE_H_

#include "axiscal/v1/tables_service.pb.h"
#include "core/base/status.h"
#include "core/records/table.h"

namespace axiscal::convert {

v1::MakeTableRequest ToProto(const records::TableParams& params);
// FIELD_INVALID: a missing or unreadable field, numbers that are not finite. The rules of machine and format are
// checked later.
absl::StatusOr<records::TableParams> FromProto(const v1::MakeTableRequest& message);

v1::TableFormat ToProto(const records::TableFormat& format);
absl::StatusOr<records::TableFormat> FromProto(const v1::TableFormat& message);

v1::MakeTableResponse ToProto(const records::MadeTable& made);
absl::StatusOr<records::MadeTable> FromProto(const v1::MakeTableResponse& message);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_TABLE_H_
