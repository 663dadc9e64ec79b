// Controllers' logs on the wire: how they are read and what became of them; their bytes travel beside.
#ifndef AXISCAL_PROTO_CONVERT_LOG_H_
#define AXISCAL_PROTO_CONVERT_LOG_H_

#include "axiscal/v1/ingest_service.pb.h"
#include "core/base/status.h"
#include "core/records/log.h"

namespace axiscal::convert {

v1::LogForm ToProto(const records::LogForm& form);
// FIELD_INVALID: no template, one or a plan that is too long, names that are none, a time that is no number.
absl::StatusOr<records::LogForm> FromProto(const v1::LogForm& message);

v1::PutLogResponse ToProto(const records::StoredLog& stored);
absl::StatusOr<records::StoredLog> FromProto(const v1::PutLogResponse& message);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_LOG_H_
